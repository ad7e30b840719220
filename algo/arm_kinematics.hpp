// A serial arm of revolute joints: its links and limits, where its frames are at given joint angles, and how
// the hand moves with them. The frames follow Denavit and Hartenberg's classic convention:
//
//   T_{i-1}_i(q_i) = Rz(q_i + theta_offset_i) * Tz(d_i) * Tx(a_i) * Rx(alpha_i)
//
// so joint i turns about z of frame i - 1; frame 0 is the base, frame n the flange.
// T_W_H = T_W_base * T_0_1 * ... * T_{n-1}_n * T_flange_hand.
#pragma once

#include <array>

#include "algo/joint_limits.hpp"
#include "algo/limits.hpp"
#include "algo/pose.hpp"
#include "algo/status.hpp"

namespace vergence {

// One number a joint, base to hand; those past the arm's last joint are ignored, and answered as zero.
using JointVector = Eigen::Matrix<double, kMaxJoints, 1>;

// Columns of joints past the last are zero.
using ArmJacobian = Eigen::Matrix<double, 6, kMaxJoints>;

struct DhRow {
  double a_mm = 0;
  double alpha_rad = 0;
  double d_mm = 0;
  double theta_offset_rad = 0;
};

struct SerialArm {
  int joints = 0;
  std::array<DhRow, kMaxJoints> dh{};
  std::array<JointLimits, kMaxJoints> limits{};
  unsigned held = 0;  // bit i: joint i + 1 does not move, whatever is asked of the hand
  Transform T_W_base;
  Transform T_flange_hand;
};

// Angles farther from zero are no joint's; |q + theta_offset| stays where sin_cos is defined.
inline constexpr double kMaxJointAngle_rad = 50;

// kBadArm where a number is not finite or not sensible: joints 1 to kMaxJoints, one of them not held; lengths
// to 1e5 mm, twists and offsets to 10 rad; limits in order, within kMaxJointAngle_rad, rates above zero;
// rotations orthonormal to 1e-9.
[[nodiscard]] Status validate(const SerialArm& arm);

// True where each of the arm's joint angles is finite and within kMaxJointAngle_rad.
[[nodiscard]] bool are_joint_angles(const SerialArm& arm, const JointVector& q_rad);

// True where T is finite, within 1e9 mm, and its rotation orthonormal to the tolerance, and right-handed.
[[nodiscard]] bool is_rigid(const Transform& T, double tolerance);

struct ArmFrames {
  std::array<Transform, kMaxJoints + 1> T_W_joint;  // [i]: frame i; past the flange, the flange again
  Transform T_W_H;
};

// Of a valid arm, for are_joint_angles(q_rad); other angles answer NaN, never anything undefined.
[[nodiscard]] ArmFrames forward_kinematics(const SerialArm& arm, const JointVector& q_rad);

// Geometric Jacobian of the hand's origin in W: [velocity in mm/s; angular velocity in rad/s] = J * q'.
// All joints have their column, held ones too.
[[nodiscard]] ArmJacobian geometric_jacobian(const SerialArm& arm, const ArmFrames& frames);

// What takes the hand from one pose to another: [translation in mm; rotation vector in rad], both in W.
[[nodiscard]] Vector6 pose_difference(const Transform& T_W_from, const Transform& T_W_to);

// The angle of the same direction (modulo a full turn) that lies nearest to near_rad among those within the
// limits; where none is within, the nearest of all.
[[nodiscard]] double nearest_turn(double angle_rad, double near_rad, const JointLimits& limits);

[[nodiscard]] bool is_within(double angle_rad, const JointLimits& limits);

}  // namespace vergence
