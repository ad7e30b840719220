#include "algo/pose_covariance.hpp"

#include <Eigen/Cholesky>

namespace vergence {

Matrix6 pose_covariance(const Matrix6& information, const Transform& T_H_M) {
  const Matrix6 J = pose_jacobian(T_H_M);
  const Matrix6 increment = information.ldlt().solve(Matrix6::Identity());
  // Products one by one: chained, Eigen makes a temporary that may come from the heap.
  const Matrix6 half = J * increment;
  const Matrix6 all = half * J.transpose();
  return 0.5 * (all + all.transpose());
}

}  // namespace vergence
