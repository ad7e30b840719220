#include "algo/arm_kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algo/rotation_vector.hpp"
#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

constexpr double kFullTurn_rad = 2 * std::numbers::pi;

bool is_between(double value, double low, double high) {
  return value >= low && value <= high;  // false for NaN
}

bool is_valid(const DhRow& row) {
  return is_between(row.a_mm, -1e5, 1e5) && is_between(row.d_mm, -1e5, 1e5) &&
         is_between(row.alpha_rad, -10, 10) && is_between(row.theta_offset_rad, -10, 10);
}

bool is_valid(const JointLimits& limits) {
  return is_between(limits.min_rad, -kMaxJointAngle_rad, kMaxJointAngle_rad) &&
         is_between(limits.max_rad, limits.min_rad, kMaxJointAngle_rad) && limits.max_rad > limits.min_rad &&
         is_between(limits.velocity_rad_per_s, 1e-9, 1e9) &&
         is_between(limits.acceleration_rad_per_s2, 1e-9, 1e9) &&
         is_between(limits.jerk_rad_per_s3, 1e-9, 1e9);
}

Transform link(const DhRow& row, double q_rad) {
  const auto [s, c] = sin_cos(q_rad + row.theta_offset_rad);
  const auto [sa, ca] = sin_cos(row.alpha_rad);
  Transform T;
  T.R << c, -s * ca, s * sa,  //
      s, c * ca, -c * sa,     //
      0, sa, ca;
  T.t_mm = {row.a_mm * c, row.a_mm * s, row.d_mm};
  return T;
}

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Status validate(const SerialArm& arm) {
  if (arm.joints < 1 || arm.joints > kMaxJoints) return Status::kBadArm;
  const unsigned all = (1U << static_cast<unsigned>(arm.joints)) - 1;
  if ((arm.held & ~all) != 0 || arm.held == all) return Status::kBadArm;
  for (int i = 0; i < arm.joints; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!is_valid(arm.dh[k]) || !is_valid(arm.limits[k])) return Status::kBadArm;
  }
  if (!is_rigid(arm.T_W_base, 1e-9) || !is_rigid(arm.T_flange_hand, 1e-9)) return Status::kBadArm;
  return Status::kOk;
}

bool are_joint_angles(const SerialArm& arm, const JointVector& q_rad) {
  for (int i = 0; i < arm.joints; ++i) {
    if (!is_between(q_rad[i], -kMaxJointAngle_rad, kMaxJointAngle_rad)) return false;
  }
  return true;
}

bool is_rigid(const Transform& T, double tolerance) {
  for (int i = 0; i < 3; ++i) {
    if (!is_between(T.t_mm[i], -1e9, 1e9)) return false;
    for (int j = 0; j < 3; ++j) {
      if (!is_between(T.R(i, j), -2, 2)) return false;
    }
  }
  const Matrix3 off = T.R * T.R.transpose() - Matrix3::Identity();
  if (off.cwiseAbs().maxCoeff() > tolerance) return false;
  return cross(T.R.col(0), T.R.col(1)).dot(T.R.col(2)) > 0;
}

ArmFrames forward_kinematics(const SerialArm& arm, const JointVector& q_rad) {
  ArmFrames frames;
  frames.T_W_joint[0] = arm.T_W_base;
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const Transform& T = frames.T_W_joint[i];
    const auto joint = static_cast<int>(i);
    frames.T_W_joint[i + 1] = joint < arm.joints ? T * link(arm.dh[i], q_rad[joint]) : T;
  }
  frames.T_W_H = frames.T_W_joint[kMaxJoints] * arm.T_flange_hand;
  return frames;
}

ArmJacobian geometric_jacobian(const SerialArm& arm, const ArmFrames& frames) {
  ArmJacobian J = ArmJacobian::Zero();
  for (int i = 0; i < arm.joints; ++i) {
    const Transform& T = frames.T_W_joint[static_cast<std::size_t>(i)];
    const Vector3 axis = T.R.col(2);
    J.col(i) << cross(axis, frames.T_W_H.t_mm - T.t_mm), axis;
  }
  return J;
}

Vector6 pose_difference(const Transform& T_W_from, const Transform& T_W_to) {
  Vector6 difference;
  difference << T_W_to.t_mm - T_W_from.t_mm, vector_from_rotation(T_W_to.R * T_W_from.R.transpose());
  return difference;
}

double nearest_turn(double angle_rad, double near_rad, const JointLimits& limits) {
  const double nearest = angle_rad + kFullTurn_rad * std::floor((near_rad - angle_rad) / kFullTurn_rad + 0.5);
  if (is_within(nearest, limits)) return nearest;
  // Within the limits, the nearest copy is the first on the way to them.
  const double turns = nearest < limits.min_rad ? std::ceil((limits.min_rad - nearest) / kFullTurn_rad)
                                                : -std::ceil((nearest - limits.max_rad) / kFullTurn_rad);
  const double other = nearest + turns * kFullTurn_rad;
  return is_within(other, limits) ? other : nearest;
}

bool is_within(double angle_rad, const JointLimits& limits) {
  return is_between(angle_rad, limits.min_rad, limits.max_rad);
}

}  // namespace vergence
