#include "tools/plant/arm_servo.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "hal/clock.hpp"

namespace vergence::plant {
namespace {

constexpr double kMostLoad = 0.9;  // of what motor and brake can hold

}  // namespace

ArmServoOptions servo_of(const SerialArm& arm) {
  constexpr double kBeyondEnd_rad = 0.05;
  constexpr double kSpeedReserve = 1.1;
  constexpr double kTorqueReserve = 1.5;
  ArmServoOptions options;
  options.joints = arm.joints;
  for (std::size_t i = 0; i < static_cast<std::size_t>(arm.joints); ++i) {
    const JointLimits& limits = arm.limits[i];
    JointDrive& drive = options.drive[i];
    drive.min_rad = limits.min_rad - kBeyondEnd_rad;
    drive.max_rad = limits.max_rad + kBeyondEnd_rad;
    drive.velocity_rad_per_s = kSpeedReserve * limits.velocity_rad_per_s;
    drive.acceleration_rad_per_s2 = kTorqueReserve * limits.acceleration_rad_per_s2;
    drive.quick_stop_rad_per_s2 = drive.acceleration_rad_per_s2;
  }
  return options;
}

ArmServo::ArmServo(const ArmServoOptions& options) : options_(options) {
  bool is_good = options.joints >= 1 && options.joints <= kMaxJoints && options.enable_delay_ns >= 0 &&
                 options.command_period_ns > 0 && options.watchdog_periods >= 0;
  for (int i = 0; is_good && i < options.joints; ++i) {
    const auto joint = static_cast<std::size_t>(i);
    is_good = is_usable(options.drive[joint], options.start_rad[joint]);
    position_rad_[joint] = options.start_rad[joint];
  }
  if (!is_good) throw std::invalid_argument("ArmServo: options outside their ranges");
}

void ArmServo::request(ArmRequest request) {
  switch (request) {
    case ArmRequest::kDisable:
      if (state_ != ArmState::kFault) state_ = ArmState::kDisabled;
      return;
    case ArmRequest::kEnable:
      if (state_ == ArmState::kQuickStop) enable_now();
      if (state_ != ArmState::kDisabled) return;
      if (options_.enable_delay_ns == 0) return enable_now();
      state_ = ArmState::kEnabling;
      enable_left_ns_ = options_.enable_delay_ns;
      return;
    case ArmRequest::kQuickStop:
      if (state_ == ArmState::kEnabled) state_ = ArmState::kQuickStop;
      if (state_ == ArmState::kEnabling) state_ = ArmState::kDisabled;
      return;
    case ArmRequest::kResetFault:
      if (state_ != ArmState::kFault) return;
      state_ = ArmState::kDisabled;
      fault_ = 0;
      return;
  }
}

void ArmServo::enable_now() {
  state_ = ArmState::kEnabled;
  command_rad_per_s_ = {};
  watchdog_left_ns_ = options_.watchdog_periods * options_.command_period_ns;
}

void ArmServo::command(const JointArray& velocity_rad_per_s) {
  if (state_ != ArmState::kEnabled) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(options_.joints); ++i) {
    const double most = options_.drive[i].velocity_rad_per_s;
    const double wanted = velocity_rad_per_s[i];
    command_rad_per_s_[i] = std::isnan(wanted) ? 0 : std::clamp(wanted, -most, most);
  }
  watchdog_left_ns_ = options_.watchdog_periods * options_.command_period_ns;
}

std::int64_t ArmServo::until_event_ns() const {
  if (state_ == ArmState::kEnabling) return enable_left_ns_;
  if (state_ == ArmState::kEnabled && options_.watchdog_periods > 0) return watchdog_left_ns_;
  return INT64_MAX;
}

void ArmServo::advance(std::int64_t dt_ns) {
  while (dt_ns > 0) {
    // In parts, so that an event has its own instant and not that of the step it falls into.
    const std::int64_t part_ns = std::min(dt_ns, until_event_ns());
    move(seconds(part_ns));
    dt_ns -= part_ns;
    if (state_ == ArmState::kEnabling) {
      enable_left_ns_ -= part_ns;
      if (enable_left_ns_ == 0) enable_now();
    } else if (state_ == ArmState::kEnabled && options_.watchdog_periods > 0) {
      watchdog_left_ns_ -= part_ns;
      if (watchdog_left_ns_ == 0) state_ = ArmState::kQuickStop;
    }
  }
}

void ArmServo::move(double dt_s) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(options_.joints); ++i) {
    const JointDrive& drive = options_.drive[i];
    JointState joint{position_rad_[i], velocity_rad_per_s_[i]};
    if (state_ == ArmState::kEnabled) {
      follow(drive, command_rad_per_s_[i], load_rad_per_s2_[i], dt_s, joint);
    } else {
      brake(drive, load_rad_per_s2_[i], dt_s, joint);
    }
    if (keep_between_stops(drive, joint)) ends_hit_ |= 1U << i;
    position_rad_[i] = joint.position_rad;
    velocity_rad_per_s_[i] = joint.velocity_rad_per_s;
  }
}

ArmFeedback ArmServo::feedback(std::int64_t stamp_ns) const {
  ArmFeedback feedback;
  feedback.stamp_ns = stamp_ns;
  feedback.state = state_;
  feedback.fault = fault_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(options_.joints); ++i) {
    const double counts_per_rad = options_.drive[i].counts_per_rad;
    feedback.position_rad[i] = std::nearbyint(position_rad_[i] * counts_per_rad) / counts_per_rad;
    feedback.velocity_rad_per_s[i] = std::nearbyint(velocity_rad_per_s_[i] * counts_per_rad) / counts_per_rad;
  }
  return feedback;
}

void ArmServo::shove(const JointArray& jump_rad_per_s) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(options_.joints); ++i) {
    velocity_rad_per_s_[i] += jump_rad_per_s[i];
  }
}

void ArmServo::set_load(const JointArray& load_rad_per_s2) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(options_.joints); ++i) {
    const JointDrive& drive = options_.drive[i];
    const double most = kMostLoad * std::min(drive.acceleration_rad_per_s2, drive.quick_stop_rad_per_s2);
    load_rad_per_s2_[i] = std::clamp(load_rad_per_s2[i], -most, most);
  }
}

void ArmServo::inject_fault(std::uint32_t code) {
  if (code == 0) throw std::invalid_argument("ArmServo: a fault's code is not zero");
  state_ = ArmState::kFault;
  fault_ = code;
}

}  // namespace vergence::plant
