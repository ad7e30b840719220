#include "hal/gpio_step/step_motors.hpp"

#include <algorithm>

namespace vergence::step {

std::int64_t to_millisteps_per_s(double steps_per_s) {
  const double millisteps = steps_per_s * static_cast<double>(kMillistepsPerStep);
  constexpr double kBeyondAny = 1e15;
  // Written so that what is no number fails it.
  if (!(millisteps > -kBeyondAny && millisteps < kBeyondAny)) return kNever_ns;
  return static_cast<std::int64_t>(millisteps < 0 ? millisteps - 0.5 : millisteps + 0.5);
}

MotorError StepSequencer::configure(const StepMotorsConfig& config, std::int64_t now_ns) {
  if (config.poll_ns < 10'000 || config.poll_ns > 100'000'000 || config.settle_ns < 0 ||
      config.settle_ns > 10'000'000'000) {
    return {TimingError::kBadPoll, -1};
  }
  *this = StepSequencer();
  config_ = config;
  next_poll_ns_ = now_ns;
  return motors_.configure(config.motors, now_ns);
}

void StepSequencer::enter_enabled(std::int64_t now_ns) {
  state_ = PanTiltState::kEnabled;
  fault_ = {};
  settled_ns_ = now_ns + config_.settle_ns;
}

void StepSequencer::enter_disabled() {
  state_ = PanTiltState::kDisabled;
  fault_ = {};
  rates_ = {};
  fresh_rates_ = false;
  motors_.halt();
}

void StepSequencer::enter_fault(const MotorFault& fault) {
  state_ = PanTiltState::kFault;
  fault_ = fault;
  rates_ = {};
  fresh_rates_ = false;
  motors_.halt();
}

void StepSequencer::set_rates(const MotorRates& rates) {
  rates_ = rates;
  fresh_rates_ = true;
}

MotorFault StepSequencer::steer(std::int64_t now_ns) {
  MotorFault fault;
  if (state_ != PanTiltState::kEnabled) return fault;
  const MotorRates none{};
  const int refused = motors_.command(now_ns, now_ns >= settled_ns_ ? rates_ : none, inputs_, fault);
  if (fresh_rates_ && now_ns >= settled_ns_) {
    refused_commands_ += static_cast<std::uint64_t>(refused);
    fresh_rates_ = false;
  }
  return fault;
}

std::int64_t StepSequencer::next_deadline_ns() const {
  return std::min(next_poll_ns_, motors_.next_event_ns());
}

StepReport StepSequencer::report(std::int64_t now_ns) const {
  StepReport report;
  report.feedback.stamp_ns = now_ns;
  report.feedback.state = state_;
  report.fault = fault_;
  for (int i = 0; i < kPanTiltMotors; ++i) {
    const StepGenerator& motor = motors_.motor(i);
    report.feedback.steps[static_cast<std::size_t>(i)] = motor.position_steps();
    report.homed[static_cast<std::size_t>(i)] = motors_.is_homed(i);
    report.late_events += motor.late_events();
    report.delay_ns = std::max(report.delay_ns, motor.delay_ns());
  }
  report.refused_commands = refused_commands_;
  return report;
}

}  // namespace vergence::step
