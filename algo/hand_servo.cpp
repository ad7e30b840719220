#include "algo/hand_servo.hpp"

namespace vergence {
namespace {

constexpr double kMostPerSecond = 50;  // a loop with 5 ms of lag bears no more without overshoot

bool is_between(double value, double low, double high) {
  return value >= low && value <= high;  // false for NaN
}

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Transform desired_hand(const Transform& T_W_E, const TargetState& target, const DesiredRelation& relation) {
  if (relation.position_only) {
    return {T_W_E.R, target.T_W_M.t_mm - T_W_E.R * relation.T_Ed_M.t_mm};
  }
  return target.T_W_M * relation.T_Ed_M.inverse();
}

Twist velocity_of(const Transform& T_W_Ed, const TargetState& target, const DesiredRelation& relation) {
  Twist twist;
  if (!relation.position_only) {
    twist.angular_rad_per_s = target.velocity.angular_rad_per_s - T_W_Ed.R * relation.rate.angular_rad_per_s;
  }
  twist.linear_mm_per_s = target.velocity.linear_mm_per_s -
                          cross(twist.angular_rad_per_s, target.T_W_M.t_mm - T_W_Ed.t_mm) -
                          T_W_Ed.R * relation.rate.linear_mm_per_s;
  return twist;
}

}  // namespace

HandGains thesis_gains() {
  return {0.4, 0.1, 0.4, 0.1, 0};
}

HandGains vergence_gains() {
  // Twice as much for e, which is half the angle.
  return {3, 0, 6, 0, 1};
}

Status check(const HandGains& gains) {
  const bool good = is_between(gains.position_per_s, 0, kMostPerSecond) &&
                    is_between(gains.orientation_per_s, 0, kMostPerSecond) &&
                    is_between(gains.position_rate, 0, 0.9) && is_between(gains.orientation_rate, 0, 0.9) &&
                    is_between(gains.feed_forward, 0, 1);
  return good ? Status::kOk : Status::kBadGains;
}

HandError hand_error(const Transform& T_W_E, const Twist& hand_W, const TargetState& target,
                     const DesiredRelation& relation) {
  const Transform T_W_Ed = desired_hand(T_W_E, target, relation);
  const Twist desired = velocity_of(T_W_Ed, target, relation);
  HandError error;
  error.R_W_E = T_W_E.R;
  error.position_mm = T_W_Ed.t_mm - T_W_E.t_mm;
  error.rate.linear_mm_per_s = desired.linear_mm_per_s - hand_W.linear_mm_per_s;
  if (!relation.position_only) {
    error.e = quaternion_vector_from_rotation(T_W_E.R.transpose() * T_W_Ed.R);
    error.rate.angular_rad_per_s = desired.angular_rad_per_s - hand_W.angular_rad_per_s;
  }
  return error;
}

Twist desired_hand_velocity(const Transform& T_W_E, const TargetState& target,
                            const DesiredRelation& relation) {
  return velocity_of(desired_hand(T_W_E, target, relation), target, relation);
}

Twist hand_twist(const HandGains& gains, const HandError& error, const Twist& desired_hand_velocity_W) {
  return {gains.position_per_s * error.position_mm + gains.position_rate * error.rate.linear_mm_per_s +
              gains.feed_forward * desired_hand_velocity_W.linear_mm_per_s,
          gains.orientation_per_s * (error.R_W_E * error.e) +
              gains.orientation_rate * error.rate.angular_rad_per_s +
              gains.feed_forward * desired_hand_velocity_W.angular_rad_per_s};
}

VelocityStep joint_velocity(const SerialArm& arm, const ArmJacobian& J, const Twist& twist_W,
                            const JointVector& q_desired_rad, const JointVector& q_rad,
                            const JointServo& servo) {
  VelocityStep step;
  if (!are_joint_angles(arm, q_desired_rad) || !are_joint_angles(arm, q_rad) ||
      !is_between(servo.position_per_s, 0, kMostPerSecond)) {
    step.status = Status::kBadNumber;
    return step;
  }
  Vector6 twist;
  twist << twist_W.linear_mm_per_s, twist_W.angular_rad_per_s;
  step = damped_joint_velocity(arm, J, twist, servo.damping);
  if (step.status != Status::kOk) return step;
  for (int i = 0; i < arm.joints; ++i) {
    step.velocity_rad_per_s[i] += servo.position_per_s * (q_desired_rad[i] - q_rad[i]);
  }
  return step;
}

}  // namespace vergence
