#include "hal/gpio_step/motor_set.hpp"

#include <algorithm>

namespace vergence::step {
namespace {

constexpr std::int64_t magnitude(std::int64_t x) {
  return x < 0 ? -x : x;
}

// The first cause stays.
void blame(MotorFault& fault, StepFault what, std::size_t motor) {
  if (fault.fault == StepFault::kNone) fault = {what, static_cast<int>(motor)};
}

}  // namespace

const char* describe(StepFault fault) {
  switch (fault) {
    case StepFault::kNone: return "no fault";
    case StepFault::kEndReached: return "a motor moved towards a pressed switch: disable, and move it away";
    case StepFault::kHomeMoved:
      return "the home switch is not where it was: steps were lost, or the switch is broken; lower rate or "
             "acceleration, and home again";
    case StepFault::kInputsUnreadable: return "the inputs cannot be read: is the GPIO chip still there?";
    case StepFault::kOutputsFailed: return "the step lines cannot be set: is the GPIO chip still there?";
    case StepFault::kEnableFailed:
      return "the enable line cannot be set, drives may be on: cut the motors' power by hand";
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
  pressed_ = 0;
  return {};
}

// The rate that is left of one that leads, or would lead, towards the switch at an end.
std::int64_t MotorSet::heed_end(std::size_t motor, const End& end, std::int64_t rate, MotorFault& fault) {
  StepGenerator& generator = generators_[motor];
  const MotorConfig& config = config_[motor];
  const bool moves_there = generator.rate_millisteps_per_s() * end.direction > 0;
  const bool wants_there = rate * end.direction > 0;
  if (end.action == EndAction::kNone || (!moves_there && !wants_there)) return rate;

  const std::int64_t beyond_home_steps = (generator.position_steps() - config.home_steps) * end.direction;
  bool is_home_elsewhere = false;
  if (end.is_pressed) {
    if (moves_there) generator.halt();
    if (wants_there) rate = 0;
    if (end.action == EndAction::kFault) {
      blame(fault, StepFault::kEndReached, motor);
    } else if (!homed_[motor]) {
      generator.set_position(config.home_steps);
      homed_[motor] = true;
    } else if (end.is_new) {  // further inside a switch that stayed pressed says nothing
      is_home_elsewhere = magnitude(beyond_home_steps) > config.home_tolerance_steps;
    }
  } else if (end.action == EndAction::kHome && homed_[motor] && moves_there) {
    is_home_elsewhere = beyond_home_steps > config.home_tolerance_steps;
  }
  if (is_home_elsewhere) {
    homed_[motor] = false;
    blame(fault, StepFault::kHomeMoved, motor);
  }
  return rate;
}

int MotorSet::command(std::int64_t now_ns, const MotorRates& rates, std::uint32_t inputs, MotorFault& fault) {
  int refused = 0;
  for (std::size_t i = 0; i < generators_.size(); ++i) {
    const int motor = static_cast<int>(i);
    const auto end_at = [&](std::uint32_t bit, EndAction action, std::int64_t direction) {
      return End{action, direction, (inputs & bit) != 0, (inputs & ~pressed_ & bit) != 0};
    };
    std::int64_t rate = rates[i];
    if (!generators_[i].accepts(rate)) {
      ++refused;
      rate = 0;
    }
    rate = heed_end(i, end_at(low_end_bit(motor), config_[i].low_end, -1), rate, fault);
    rate = heed_end(i, end_at(high_end_bit(motor), config_[i].high_end, 1), rate, fault);
    (void)generators_[i].command(now_ns, rate);
  }
  pressed_ = inputs;
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

void MotorSet::rewritten(std::int64_t done_ns) {
  for (StepGenerator& generator : generators_) generator.rewritten(done_ns);
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
