#include "algo/pose_covariance.hpp"

#include <Eigen/Cholesky>

namespace vergence {
namespace {

// Covariance of the pose from that of the increment.
Matrix6 transformed(const Matrix6& increment, const Transform& T_H_M) {
  const Matrix6 J = pose_jacobian(T_H_M);
  // Products one by one: chained, Eigen makes a temporary that may come from the heap.
  const Matrix6 half = J * increment;
  const Matrix6 all = half * J.transpose();
  return 0.5 * (all + all.transpose());
}

}  // namespace

Matrix6 pose_covariance(const Matrix6& information, const Transform& T_H_M) {
  return transformed(information.ldlt().solve(Matrix6::Identity()), T_H_M);
}

Matrix6 pose_covariance(const Vector6& deviation, const Transform& T_H_M) {
  Matrix6 increment = Matrix6::Zero();
  increment.diagonal() = deviation.array().square();
  return transformed(increment, T_H_M);
}

}  // namespace vergence
