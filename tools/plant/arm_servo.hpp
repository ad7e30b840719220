// An arm's drives: what becomes of velocities that are sent to them. How a joint moves is in
// joint_motion.hpp; defaults and what is left out: docs/plant.md.
#pragma once

#include <array>
#include <cstdint>

#include "algo/arm_kinematics.hpp"
#include "hal/arm.hpp"
#include "tools/plant/joint_motion.hpp"

namespace vergence::plant {

using JointArray = std::array<double, kMaxJoints>;

struct ArmServoOptions {
  int joints = kMaxJoints;
  std::array<JointDrive, kMaxJoints> drive{};
  JointArray start_rad{};
  std::int64_t enable_delay_ns = 200'000'000;
  std::int64_t command_period_ns = 2'000'000;
  int watchdog_periods = 10;  // so many without a command: quick stop; 0: no watchdog
};

// The drives of an arm, a little better than the limits the controller keeps: hard stops 0.05 rad beyond the
// joint's ends, 1.1 times its speed, 1.5 times its acceleration, which the quick stop has too.
[[nodiscard]] ArmServoOptions servo_of(const SerialArm& arm);

class ArmServo {
 public:
  // Throws std::invalid_argument where a rate, time or count is not positive, or the start not between stops.
  explicit ArmServo(const ArmServoOptions& options);

  // Enables from disabled, after the delay, and at once from quick stop; both with command zero. A quick stop
  // while enabling disables. What the state does not allow is ignored.
  void request(ArmRequest request);
  // Holds until the next one; no number counts as zero. Ignored unless enabled.
  void command(const JointArray& velocity_rad_per_s);
  void advance(std::int64_t dt_ns);

  // What the drives report: whole counts, and whole counts a second.
  [[nodiscard]] ArmFeedback feedback(std::int64_t stamp_ns) const;

  [[nodiscard]] const JointArray& true_position_rad() const { return position_rad_; }
  [[nodiscard]] const JointArray& true_velocity_rad_per_s() const { return velocity_rad_per_s_; }
  [[nodiscard]] unsigned ends_hit() const { return ends_hit_; }  // bit i: joint i + 1 was at a hard stop

  // A blow: velocities jump by so much, whatever the state; the loop or the brakes fight it.
  void shove(const JointArray& jump_rad_per_s);
  // A steady push or weight. Kept to nine tenths of what motor and brake can hold; against the loop it leaves
  // a velocity of load * time_constant.
  void set_load(const JointArray& load_rad_per_s2);
  // The drives report this code, which is not zero, and brake until the fault is reset.
  void inject_fault(std::uint32_t code);

 private:
  void enable_now();
  [[nodiscard]] std::int64_t until_event_ns() const;
  void move(double dt_s);

  ArmServoOptions options_;
  ArmState state_ = ArmState::kDisabled;
  std::uint32_t fault_ = 0;
  std::int64_t enable_left_ns_ = 0;
  std::int64_t watchdog_left_ns_ = 0;
  JointArray command_rad_per_s_{};
  JointArray load_rad_per_s2_{};
  JointArray position_rad_{};
  JointArray velocity_rad_per_s_{};
  unsigned ends_hit_ = 0;
};

}  // namespace vergence::plant
