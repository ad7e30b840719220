// The twist of the hand that brings it to a desired place relative to the target and keeps it there
// [Eqs. 3.23-3.29], with feed-forward of the target's own motion, and the joint velocities for it [3.31].
// Why the gains are what they are, and what was measured with them: docs/hand_servo.md.
#pragma once

#include "algo/damped_velocity.hpp"
#include "algo/hand_limits.hpp"
#include "algo/target_motion.hpp"

namespace vergence {

// Where the hand (E) is to be, Ed, seen from the target M.
struct DesiredRelation {
  Transform T_Ed_M;
  Twist rate;  // how T_Ed_M changes: of M's origin and of M's rotation, in the axes of Ed
  // The hand keeps its orientation: only the target's position counts, and T_Ed_M.t_mm is where it is to be
  // in the hand's own axes. T_Ed_M.R and rate.angular_rad_per_s are not read.
  bool position_only = false;
};

struct HandGains {
  double position_per_s = 0;     // K_PP
  double position_rate = 0;      // K_VP, of the difference of velocities
  double orientation_per_s = 0;  // K_PO, of the quaternion's vector part: of half the angle where it is small
  double orientation_rate = 0;   // K_VO
  double feed_forward = 0;       // K_FF, share of Ed's own velocity; the thesis has none
};

// As printed: 0.4 /s and 0.1, no feed-forward.
[[nodiscard]] HandGains thesis_gains();
// Feed-forward 1, errors fall with 3 /s in position and orientation.
[[nodiscard]] HandGains vergence_gains();

// kOk, or kBadGains: K_P outside [0, 50 /s], K_V outside [0, 0.9], K_FF outside [0, 1], or not finite. The
// velocity of the hand that K_V looks at is a period old at least: from 1 on, the loop would swing.
[[nodiscard]] Status check(const HandGains& gains);

// From the hand E to where it is to be.
struct HandError {
  Vector3 position_mm = Vector3::Zero();  // r_{E,Ed}, in W
  Vector3 e = Vector3::Zero();            // vector part of the quaternion of R_E_Ed, in E, eta >= 0
  Twist rate;                             // time derivative of r_{E,Ed}, and omega_{E,Ed}: both in W
  Matrix3 R_W_E = Matrix3::Identity();    // takes e to W
};

// The error [3.23-3.25], [3.28, 3.29]. hand_W: velocity of E's origin and rotation, in W; target: of the
// instant T_W_E is of. T_E_Ed = T_E_M * inv(T_Ed_M), and its derivative in closed form.
[[nodiscard]] HandError hand_error(const Transform& T_W_E, const Twist& hand_W, const TargetState& target,
                                   const DesiredRelation& relation);

// Velocity of Ed's origin and rotation, in W:
//   w_Ed = w_M - R_W_Ed w_rel,  v_Ed = v_M - w_Ed x (r_M - r_Ed) - R_W_Ed v_rel.
// T_W_E is read where the relation is position_only: Ed then turns as the hand does, not at all.
[[nodiscard]] Twist desired_hand_velocity(const Transform& T_W_E, const TargetState& target,
                                          const DesiredRelation& relation);

// The twist to ask of the arm, in W [3.26, 3.27]:
//   v = K_PP r + K_VP r' + K_FF v_Ed,  w = K_PO R_W_E e + K_VO w_{E,Ed} + K_FF w_Ed.
// A drive that follows late by some lead wants the velocity of that much later: desired_hand_velocity of the
// target's state at now + lead (and the relation there), hand_error of now. No input is refused: what is not
// finite comes out as not finite, for the limits (hand_limits) to brake on.
[[nodiscard]] Twist hand_twist(const HandGains& gains, const HandError& error,
                               const Twist& desired_hand_velocity_W);

struct JointServo {
  double position_per_s = 1;  // K_PQ
  Damping damping;
};

// q' = K_PQ (q_d - q) + J^+ [v; w] [3.31], J of the hand's origin in W, twist likewise. Held joints have the
// first term only: q_d is where they are held. kBadNumber with zero velocity where an angle is not one
// (are_joint_angles), J or the twist is not finite or beyond 1e9, or K_PQ is outside [0, 50 /s].
[[nodiscard]] VelocityStep joint_velocity(const SerialArm& arm, const ArmJacobian& J, const Twist& twist_W,
                                          const JointVector& q_desired_rad, const JointVector& q_rad,
                                          const JointServo& servo = {});

}  // namespace vergence
