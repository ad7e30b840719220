#include "algo/damped_velocity.hpp"

#include <algorithm>
#include <cmath>

namespace vergence {
namespace {

constexpr double kLargest = 1e9;

template <typename Matrix>
bool is_sensible(const Matrix& m) {
  for (int i = 0; i < m.rows(); ++i) {
    for (int j = 0; j < m.cols(); ++j) {
      if (!(m(i, j) >= -kLargest && m(i, j) <= kLargest)) return false;
    }
  }
  return true;
}

}  // namespace

bool is_sensible(const Damping& damping) {
  return damping.length_mm >= 1e-3 && damping.length_mm <= kLargest && damping.singular_value_floor >= 1e-6 &&
         damping.singular_value_floor <= 1e3;
}

ScaledJacobian scale(const SerialArm& arm, const ArmJacobian& J, unsigned held, double length_mm) {
  ScaledJacobian scaled;
  scaled.S = J;
  scaled.S.topRows<3>() /= length_mm;
  int moving = 0;
  for (int i = 0; i < kMaxJoints; ++i) {
    if (i < arm.joints && (held >> static_cast<unsigned>(i) & 1U) == 0) {
      ++moving;
    } else {
      scaled.S.col(i).setZero();
    }
  }
  scaled.rank_limit = std::min(moving, 6);
  scaled.eigen = symmetric_eigen(scaled.S * scaled.S.transpose());
  Vector6 ascending = scaled.eigen.values;
  std::sort(ascending.data(), ascending.data() + 6);
  for (int i = 0; i < scaled.rank_limit; ++i) {
    scaled.singular_values[i] = std::sqrt(std::max(ascending[5 - i], 0.0));
  }
  return scaled;
}

JointVector inverse_step(const ScaledJacobian& scaled, const Vector6& twist, const Vector6& denominators) {
  const Vector6 along = scaled.eigen.vectors.transpose() * twist;
  return scaled.S.transpose() * (scaled.eigen.vectors * along.cwiseQuotient(denominators));
}

double manipulability(const ScaledJacobian& scaled) {
  double product = 1;
  for (int i = 0; i < scaled.rank_limit; ++i) product *= scaled.singular_values[i];
  return product;
}

VelocityStep damped_joint_velocity(const SerialArm& arm, const ArmJacobian& J, const Vector6& twist_W,
                                   const Damping& damping) {
  VelocityStep step;
  if (!is_sensible(J) || !is_sensible(twist_W) || !is_sensible(damping)) {
    step.status = Status::kBadNumber;
    return step;
  }
  Vector6 twist = twist_W;
  twist.head<3>() /= damping.length_mm;
  const ScaledJacobian scaled = scale(arm, J, arm.held, damping.length_mm);
  const double floor_squared = damping.singular_value_floor * damping.singular_value_floor;
  Vector6 denominators;
  for (int i = 0; i < 6; ++i) {
    const double squared = std::max(scaled.eigen.values[i], 0.0);
    denominators[i] = std::max(squared, 0.5 * (squared + floor_squared));
  }
  step.velocity_rad_per_s = inverse_step(scaled, twist, denominators);
  step.smallest_singular_value = scaled.smallest();
  return step;
}

}  // namespace vergence
