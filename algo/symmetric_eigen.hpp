// Eigenvalues and vectors of a symmetric 6 x 6 by a fixed number of Jacobi sweeps: the same work for every
// matrix, no heap, no pivoting, and as good for a singular one.
#pragma once

#include "algo/pose.hpp"

namespace vergence {

struct SymmetricEigen {
  Vector6 values;   // as they come, not sorted
  Matrix6 vectors;  // columns: A = V * diag(values) * V^T
};

// Of finite A, its entries below 1e100; only the symmetric part counts.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Matrix6& A);

}  // namespace vergence
