#include "hal/gpio_step/motor_set.hpp"

#include <algorithm>

namespace vergence::step {

const char* describe(StepFault fault) {
  switch (fault) {
    case StepFault::kNone: return "no fault";
    case StepFault::kEndReached: return "a motor moved towards a pressed switch: disable, and move it away";
    case StepFault::kHomeMoved:
      return "the home switch is not where it was: steps were lost, lower rate or acceleration, and home "
             "again";
    case StepFault::kInputsUnreadable: return "the inputs cannot be read: is the GPIO chip still there?";
    case StepFault::kOutputsFailed: return "the step lines cannot be set: is the GPIO chip still there?";
    case StepFault::kEnableFailed: return "the enable line cannot be set: cut the motors' power by hand";
  }
  return "unknown fault";
}

MotorError MotorSet::configure(const std::array<MotorConfig, kPanTiltMotors>& config, std::int64_t now_ns) {
  for (std::size_t i = 0; i < generators_.size(); ++i) {
    const int motor = static_cast<int>(i);
    const MotorConfig& c = config[i];
    if ((c.low_end == EndAction::kHome && c.high_end == EndAction::kHome) || c.home_tolerance_steps < 0) {
      return {TimingError::kBadHome, motor};
    }
    if (const TimingError error = generators_[i].configure(c.timing, now_ns); error != TimingError::kNone) {
      return {error, motor};
    }
  }
  config_ = config;
  homed_ = {};
  moved_ = {};
  return {};
}

// The rate that is left of one that goes, or would go, towards a pressed switch.
std::int64_t MotorSet::heed_end(std::size_t motor, EndAction action, std::int64_t direction,
                                std::int64_t rate, MotorFault& fault) {
  StepGenerator& generator = generators_[motor];
  const bool moves_there = direction > 0 ? generator.rate_millisteps_per_s() > 0  //
                                         : generator.rate_millisteps_per_s() < 0;
  const bool wants_there = direction > 0 ? rate > 0 : rate < 0;
  if (action == EndAction::kNone || (!moves_there && !wants_there)) return rate;
  if (moves_there) generator.halt();
  if (action == EndAction::kFault) {
    fault = {StepFault::kEndReached, static_cast<int>(motor)};
  } else if (!homed_[motor]) {
    generator.set_position(config_[motor].home_steps);
    homed_[motor] = true;
  } else {
    const std::int64_t off_steps = generator.position_steps() - config_[motor].home_steps;
    if (off_steps > config_[motor].home_tolerance_steps || -off_steps > config_[motor].home_tolerance_steps) {
      fault = {StepFault::kHomeMoved, static_cast<int>(motor)};
    }
  }
  return wants_there ? 0 : rate;
}

int MotorSet::command(std::int64_t now_ns, const MotorRates& rates, std::uint32_t inputs, MotorFault& fault) {
  int refused = 0;
  for (std::size_t i = 0; i < generators_.size(); ++i) {
    const int motor = static_cast<int>(i);
    std::int64_t rate = rates[i];
    if ((inputs & low_end_bit(motor)) != 0) rate = heed_end(i, config_[i].low_end, -1, rate, fault);
    if ((inputs & high_end_bit(motor)) != 0) rate = heed_end(i, config_[i].high_end, 1, rate, fault);
    if (!generators_[i].command(now_ns, rate)) ++refused;
  }
  return refused;
}

void MotorSet::halt() {
  for (StepGenerator& generator : generators_) generator.halt();
}

std::int64_t MotorSet::next_event_ns() const {
  std::int64_t next_ns = kNever_ns;
  for (const StepGenerator& generator : generators_) next_ns = std::min(next_ns, generator.next_event_ns());
  return next_ns;
}

std::uint32_t MotorSet::advance(std::int64_t now_ns) {
  for (std::size_t i = 0; i < generators_.size(); ++i) {
    moved_[i] = now_ns >= generators_[i].next_event_ns();
    if (moved_[i]) generators_[i].advance(now_ns);
  }
  return outputs();
}

void MotorSet::written(std::int64_t done_ns) {
  for (std::size_t i = 0; i < generators_.size(); ++i) {
    if (moved_[i]) generators_[i].written(done_ns);
  }
}

std::uint32_t MotorSet::outputs() const {
  std::uint32_t levels = 0;
  for (int i = 0; i < kPanTiltMotors; ++i) {
    const StepLevels of_motor = motor(i).levels();
    if (of_motor.step) levels |= step_bit(i);
    if (of_motor.forward) levels |= forward_bit(i);
  }
  return levels;
}

}  // namespace vergence::step
