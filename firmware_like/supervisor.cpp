#include "firmware_like/supervisor.hpp"

namespace vergence {

void Supervisor::configure(int most_missed_deadlines) {
  *this = {};
  most_missed_deadlines_ = most_missed_deadlines;
}

void Supervisor::command(OperatorCommand command) {
  if (commanded_ && command_ == OperatorCommand::kStop) return;
  commanded_ = true;
  command_ = command;
}

void Supervisor::apply(std::int64_t now_ns, Event event) {
  const Mode next = next_mode(mode_, event);
  if (next == mode_) return;
  kept_[changes_ % kChanges] = {now_ns, mode_, next, event};
  ++changes_;
  mode_ = next;
  // What was wanted before something went wrong is not wanted any more.
  if (!is_armed(mode_)) servo_wanted_ = false;
}

Mode Supervisor::step(std::int64_t now_ns, const Conditions& conditions) {
  if (conditions.device_fault) apply(now_ns, Event::kDeviceFault);
  if (conditions.missed_deadlines >= most_missed_deadlines_) apply(now_ns, Event::kDeadlineMissed);
  if (conditions.following_error) apply(now_ns, Event::kFollowingError);
  if (commanded_) {
    commanded_ = false;
    switch (command_) {
      case OperatorCommand::kStop: apply(now_ns, Event::kStop); break;
      case OperatorCommand::kArm:
        // Nor are drives switched on by a controller that is late already.
        if (conditions.missed_deadlines < most_missed_deadlines_) apply(now_ns, Event::kArm);
        break;
      case OperatorCommand::kDisarm: apply(now_ns, Event::kDisarm); break;
      case OperatorCommand::kServo:
        servo_wanted_ = is_armed(mode_);
        if (mode_ == Mode::kHold) apply(now_ns, Event::kServo);
        break;
      case OperatorCommand::kHold:
        servo_wanted_ = false;
        apply(now_ns, Event::kHold);
        break;
      case OperatorCommand::kReset:
        // A reset while something still moves, or is still broken, is no reset.
        if (conditions.at_rest && !conditions.device_fault) apply(now_ns, Event::kReset);
        break;
    }
  }
  if (mode_ == Mode::kInit && conditions.devices_ready) apply(now_ns, Event::kDevicesReady);
  if (mode_ == Mode::kSelfTest && conditions.self_test == SelfTest::kPassed) {
    apply(now_ns, Event::kSelfTestPassed);
  }
  if (mode_ == Mode::kSelfTest && conditions.self_test == SelfTest::kFailed) {
    apply(now_ns, Event::kSelfTestFailed);
  }
  apply(now_ns, conditions.target_believed ? Event::kTargetFound : Event::kTargetLost);
  if (mode_ == Mode::kTrack && servo_wanted_) apply(now_ns, Event::kServo);
  return mode_;
}

}  // namespace vergence
