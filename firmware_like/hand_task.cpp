#include "firmware_like/hand_task.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "algo/stopping_room.hpp"

namespace vergence {
namespace {

constexpr double kLagsToRest = 6;  // a quarter of a per cent is left then

Twist of_point(const Twist& origin, const Vector3& arm_mm) {
  return {origin.linear_mm_per_s + origin.angular_rad_per_s.cross(arm_mm), origin.angular_rad_per_s};
}

bool is_zero(const Twist& twist) {
  return twist.linear_mm_per_s.isZero(0) && twist.angular_rad_per_s.isZero(0);
}

Twist to_twist(const Vector6& v) {
  return {v.head<3>(), v.tail<3>()};
}

}  // namespace

Status HandTask::configure(const RobotConfig& config, double period_s) {
  *this = {};
  arm_ = config.arm;
  gains_ = config.gains;
  joint_servo_ = config.joint_servo;
  hand_limits_ = config.hand_limits;
  tool_mm_ = config.tool_mm;
  relation_ = config.relation;
  drive_lag_ns_ = config.drive_lag_ns;
  drive_lag_s_ = static_cast<double>(config.drive_lag_ns) * 1e-9;
  following_error_rad_ = config.following_error_rad;
  period_s_ = period_s;
  lag_share_ = period_s / (period_s + drive_lag_s_);
  limiter_.limits = arm_.limits;
  limiter_.period_s = period_s;
  // Joints the arm does not have never move; any limits do for them.
  for (std::size_t i = static_cast<std::size_t>(arm_.joints); i < kMaxJoints; ++i) {
    limiter_.limits[i] = limiter_.limits[0];
  }
  if (const Status status = validate(arm_); status != Status::kOk) return status;
  if (const Status status = check(hand_limits_, period_s); status != Status::kOk) return status;
  if (const Status status = check(gains_); status != Status::kOk) return status;
  const double joint_gain = joint_servo_.position_per_s;
  const bool sensible = joint_gain >= 0 && joint_gain * period_s < 1 && following_error_rad_ > 0 &&
                        std::isfinite(following_error_rad_) && tool_mm_.allFinite() &&
                        is_sensible(joint_servo_.damping) && config.drive_lag_ns >= 0;
  return sensible ? limiter_.check_limits() : Status::kBadLimits;
}

Twist HandTask::desired_twist(const HandPeriod& period, const TargetState& target, const TargetState& ahead) {
  const HandError error = hand_error(period.T_W_H, period.hand, target, relation_);
  // The drives take their time to follow, so the velocity is that of the target by then.
  Twist twist = hand_twist(gains_, error, desired_hand_velocity(period.T_W_H, ahead, relation_));
  if (relation_.position_only) {
    // Joints at their limits turn the hand a little; it is turned back to how it stood.
    if (!held_orientation_) held_orientation_ = period.T_W_H.R;
    const Matrix3& R = period.T_W_H.R;
    const Vector3 e = quaternion_vector_from_rotation(R.transpose() * *held_orientation_);
    twist.angular_rad_per_s = gains_.orientation_per_s * (R * e);
  }
  return twist;
}

void HandTask::limit_joints(const ArmFrames& frames, const ArmJacobian& J,
                            const std::array<double, kMaxJoints>& wanted, HandPeriod& period) {
  const MotionLimiter<kMaxJoints> before = limiter_;
  for (const LimitFlags flags : limiter_.limit(wanted)) period.joint_flags |= flags;

  const Vector3 arm_mm = frames.T_W_H.R * tool_mm_;
  ArmJacobian J_tool = J;
  for (int i = 0; i < arm_.joints; ++i) {
    J_tool.col(i).head<3>() += Vector3(J.col(i).tail<3>()).cross(arm_mm);
  }
  // Where the tool will be at the end of this period, the drives' lag made up for.
  Vector3 tool_mm = frames.T_W_H.t_mm + arm_mm;
  for (int i = 0; i < arm_.joints; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double way =
        drive_lag_s_ * followed_rad_per_s_[i] + period_s_ * limiter_.last[k].velocity_rad_per_s;
    tool_mm += way * J_tool.col(i).head<3>();
  }
  const ToolRoom room = stopping_room(arm_, J_tool, tool_mm, limiter_.last, period_s_);
  const Vector3 now_mm = frames.T_W_H.t_mm + arm_mm;
  // Where the tool is out already, it may not go farther.
  const bool inside = (room.min_mm.array() >= hand_limits_.box_min_mm.cwiseMin(now_mm).array()).all() &&
                      (room.max_mm.array() <= hand_limits_.box_max_mm.cwiseMax(now_mm).array()).all();
  if (!inside) {
    limiter_ = before;
    (void)limiter_.brake();
    period.joint_flags |= kBoxLimited;
  }
}

// A hand that brakes with nowhere to be is not to go on, slowly, to where it would have braked to by its
// model.
void HandTask::rest_where_it_comes_to_rest(const JointVector& q) {
  for (Eigen::Index i = 0; i < arm_.joints; ++i) {
    if ((arm_.held >> i & 1U) != 0) continue;
    reference_rad_[i] = q[i];
    reference_rad_per_s_[i] = followed_rad_per_s_[i];
  }
}

HandPeriod HandTask::step(Mode mode, const ArmFeedback& feedback, const std::optional<TargetState>& target,
                          const std::optional<TargetState>& ahead) {
  HandPeriod period;
  const JointVector q(feedback.position_rad.data());
  const ArmFrames frames = forward_kinematics(arm_, q);
  const ArmJacobian J = geometric_jacobian(arm_, frames);
  period.T_W_H = frames.T_W_H;

  if (feedback.state != ArmState::kEnabled) {
    // Drives that do not follow: be ready to start from where they are.
    reference_rad_ = q;
    reference_rad_per_s_.setZero();
    followed_rad_per_s_.setZero();
    tool_twist_ = {};
    rest_s_ = 0;
    held_orientation_.reset();
    for (std::size_t i = 0; i < kMaxJoints; ++i) limiter_.last[i] = {feedback.position_rad[i], 0, 0, 0};
    period.at_rest = true;
    return period;
  }
  period.hand = to_twist(J * followed_rad_per_s_);
  JointVector deviation = reference_rad_ - q;
  period.following_error = !(deviation.cwiseAbs().maxCoeff() <= following_error_rad_);

  // Where the joints will be when the drives have followed what they were sent: what limits count from.
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    limiter_.last[i].position_rad =
        feedback.position_rad[i] + drive_lag_s_ * followed_rad_per_s_[static_cast<Eigen::Index>(i)];
  }

  JointVector correction = JointVector::Zero();
  if (mode == Mode::kSafeStop || !is_armed(mode)) {
    period.at_rest = limiter_.brake();
    tool_twist_ = {};
  } else {
    Twist desired;
    std::optional<Vector3> target_mm;
    if (target && ahead) {
      desired = desired_twist(period, *target, *ahead);
      target_mm = target->T_W_M.t_mm;
    }
    const Vector3 arm_mm = frames.T_W_H.R * tool_mm_;
    const LimitedTwist limited = limit_twist(hand_limits_, period_s_, frames.T_W_H.t_mm + arm_mm, tool_twist_,
                                             of_point(desired, arm_mm), target_mm);
    tool_twist_ = limited.twist;
    period.hand_flags = limited.flags;
    const Twist twist = of_point(limited.twist, -arm_mm);
    // The drives need some lags more to come to rest. Not longer: who moves the arm then is found out.
    rest_s_ = target ? 0 : is_zero(limited.twist) ? rest_s_ - period_s_ : kLagsToRest * drive_lag_s_;
    if (rest_s_ > 0) {
      rest_where_it_comes_to_rest(q);
      deviation = reference_rad_ - q;
    }
    // [3.31]. q_d is the integral of J^+ [v; w], as the drives should have followed it by now: the inverse
    // kinematics of the integrated pose [3.30] without a branch to choose. Who pushes the arm is pushed back.
    const VelocityStep step = joint_velocity(arm_, J, twist, reference_rad_, q, joint_servo_);
    correction = joint_servo_.position_per_s * deviation;
    period.smallest_singular_value = step.smallest_singular_value;
    std::array<double, kMaxJoints> wanted{};
    for (int i = 0; i < arm_.joints; ++i) wanted[static_cast<std::size_t>(i)] = step.velocity_rad_per_s[i];
    limit_joints(frames, J, wanted, period);
    period.at_rest = true;
    for (const JointMotion& joint : limiter_.last) {
      period.at_rest = period.at_rest && std::abs(joint.velocity_rad_per_s) < 1e-3;
    }
  }
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const double sent = limiter_.last[i].velocity_rad_per_s;
    period.velocity_rad_per_s[i] = sent;
    const auto k = static_cast<Eigen::Index>(i);
    followed_rad_per_s_[k] += lag_share_ * (sent - followed_rad_per_s_[k]);
    const bool is_held = (arm_.held >> i & 1U) != 0;
    const double referred = is_held ? 0 : sent - correction[k];
    reference_rad_per_s_[k] += lag_share_ * (referred - reference_rad_per_s_[k]);
    reference_rad_[k] += period_s_ * reference_rad_per_s_[k];
  }
  return period;
}

}  // namespace vergence
