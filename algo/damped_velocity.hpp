// Joint velocities for a velocity of the hand, for any serial arm: damped least squares, which asks for
// little where the arm can do little and never divides by nothing.
#pragma once

#include "algo/arm_kinematics.hpp"
#include "algo/symmetric_eigen.hpp"

namespace vergence {

struct Damping {
  double length_mm = 300;  // what a radian counts as much as: linear rows are divided by it
  // Singular values of J below this are damped. Joint speeds stay below |twist| / floor, in units of
  // length_mm.
  double singular_value_floor = 0.1;
};

// J with its linear rows divided by a length, the columns of joints that do not move set to zero, and what
// that makes of each direction of the hand's motion.
struct ScaledJacobian {
  ArmJacobian S = ArmJacobian::Zero();
  SymmetricEigen eigen;  // of S S^T: squared singular values and their directions, not sorted
  Vector6 singular_values = Vector6::Zero();  // descending; past the moving joints zero
  int rank_limit = 0;                         // moving joints, at most six

  [[nodiscard]] double smallest() const { return rank_limit > 0 ? singular_values[rank_limit - 1] : 0; }
};

// Bit i of held: joint i + 1 does not move.
[[nodiscard]] ScaledJacobian scale(const SerialArm& arm, const ArmJacobian& J, unsigned held,
                                   double length_mm);

// S^T U diag(1 / denominators) U^T * twist; denominators belong to the eigenvalues, in their order.
[[nodiscard]] JointVector inverse_step(const ScaledJacobian& scaled, const Vector6& twist,
                                       const Vector6& denominators);

// Yoshikawa's measure: the product of the singular values of the joints that are not held, sqrt(det(S S^T))
// where six or more move. Zero where the arm is singular.
[[nodiscard]] double manipulability(const ScaledJacobian& scaled);

struct VelocityStep {
  Status status = Status::kOk;
  JointVector velocity_rad_per_s = JointVector::Zero();
  double smallest_singular_value = 0;  // of as many as the moving joints can have, at most six
};

// q' = J^T (J J^T + Lambda)^-1 * twist_W, held joints zero. twist_W = [mm/s; rad/s] of the hand's origin in
// W. With J J^T = U diag(s^2) U^T, Lambda = U diag(l^2) U^T, l^2 = (floor^2 - s^2) / 2 where s < floor, else
// 0: a direction the arm can move in is followed exactly, one it cannot is given up smoothly as it is lost.
// kBadNumber with zero velocity where J or the twist is not finite or beyond 1e9.
[[nodiscard]] VelocityStep damped_joint_velocity(const SerialArm& arm, const ArmJacobian& J,
                                                 const Vector6& twist_W, const Damping& damping = {});

// Whether both numbers are positive and of a sensible size.
[[nodiscard]] bool is_sensible(const Damping& damping);

}  // namespace vergence
