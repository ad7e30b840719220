// A period of the arm: from where the target is to what its joints are sent [Eqs. 3.23-3.31], through every
// limit there is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "algo/motion_limits.hpp"
#include "firmware_like/mode.hpp"
#include "firmware_like/robot_config.hpp"
#include "hal/arm.hpp"

namespace vergence {

struct HandPeriod {
  std::array<double, kMaxJoints> velocity_rad_per_s{};  // to be sent
  Transform T_W_H;                                      // the hand as measured
  Twist hand;                                           // its velocity as commanded, lagged as the drives do
  double smallest_singular_value = 0;
  LimitFlags hand_flags = 0;
  LimitFlags joint_flags = 0;  // of all joints together
  bool at_rest = false;
  bool following_error = false;
};

class HandTask {
 public:
  [[nodiscard]] Status configure(const RobotConfig& config, double period_s);

  // `target` answers where the target is believed to be at an instant; it is asked only in mode servo.
  template <typename TargetAt>
  HandPeriod step(std::int64_t now_ns, Mode mode, const ArmFeedback& feedback, bool target_believed,
                  const TargetAt& target_at) {
    std::optional<TargetState> target;
    std::optional<TargetState> ahead;
    if (mode == Mode::kServo && target_believed) {
      target = target_at(feedback.stamp_ns);
      ahead = target_at(now_ns + drive_lag_ns_);
    }
    return step(mode, feedback, target, ahead);
  }

 private:
  HandPeriod step(Mode mode, const ArmFeedback& feedback, const std::optional<TargetState>& target,
                  const std::optional<TargetState>& ahead);
  void limit_joints(const ArmFrames& frames, const ArmJacobian& J,
                    const std::array<double, kMaxJoints>& wanted, HandPeriod& period);
  [[nodiscard]] Twist desired_twist(const HandPeriod& period, const TargetState& target,
                                    const TargetState& ahead);
  void rest_where_it_comes_to_rest(const JointVector& q);

  SerialArm arm_;
  HandGains gains_;
  JointServo joint_servo_;
  HandLimits hand_limits_;
  Vector3 tool_mm_ = Vector3::Zero();
  DesiredRelation relation_;
  std::int64_t drive_lag_ns_ = 0;
  double drive_lag_s_ = 0;
  double following_error_rad_ = 0;
  double period_s_ = 0;
  double lag_share_ = 1;  // of the way to its command that a drive goes in a period

  MotionLimiter<kMaxJoints> limiter_;
  // What the drives should have made by now of all that was sent, and q_d: of it without the correction of
  // the joints' own deviations.
  JointVector followed_rad_per_s_ = JointVector::Zero();
  JointVector reference_rad_per_s_ = JointVector::Zero();
  JointVector reference_rad_ = JointVector::Zero();
  double rest_s_ = 0;                        // above 0: coming to rest, without a target
  Twist tool_twist_;                         // last limited
  std::optional<Matrix3> held_orientation_;  // R_W_H, where only the position is to follow
};

}  // namespace vergence
