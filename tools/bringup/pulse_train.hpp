// Moves each motor of the eyes a little way and back, slowly, with the controller's own step generator, and
// keeps the times of the pulses.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/clock.hpp"
#include "hal/gpio_step/step_lines.hpp"
#include "hal/gpio_step/step_motors.hpp"
#include "hal/rt/sleep.hpp"
#include "tools/bringup/gpio_checks.hpp"

namespace vergence::tools {

struct PulsePlan {
  std::int64_t steps = 200;  // there, and as many back
  double steps_per_s = 200;  // no faster than the motor's own greatest rate
};

// Lines that keep when each step line became active.
template <step::StepLines Lines, Clock C>
class RecordedLines {
 public:
  RecordedLines(Lines& lines, C& clock) : lines_(&lines), clock_(&clock) {}

  [[nodiscard]] bool set_outputs(std::uint32_t levels) {
    const std::uint32_t risen = levels & ~levels_;
    const bool done = lines_->set_outputs(levels);
    levels_ = levels;
    for (int motor = 0; motor < kPanTiltMotors; ++motor) {
      if ((risen & step::step_bit(motor)) == 0) continue;
      pulses_[static_cast<std::size_t>(motor)].push_back(clock_->now_ns());
    }
    return done;
  }
  [[nodiscard]] bool set_enable(bool on) { return lines_->set_enable(on); }
  [[nodiscard]] bool read_inputs(std::uint32_t& levels) { return lines_->read_inputs(levels); }

  [[nodiscard]] std::vector<std::int64_t> take(std::size_t motor) { return std::move(pulses_[motor]); }

 private:
  Lines* lines_;
  C* clock_;
  std::uint32_t levels_ = 0;
  std::array<std::vector<std::int64_t>, kPanTiltMotors> pulses_;
};

template <step::StepLines Lines, Clock C, rt::Sleeper S>
class PulseTrain {
 public:
  // `watch` may be null. Everything must outlive this.
  PulseTrain(Lines& lines, C& clock, S& sleeper, EdgeWatch* watch)
      : clock_(&clock), sleeper_(&sleeper), watch_(watch), lines_(lines, clock), motors_(lines_, clock) {}

  // One motor after the other; the drives are on only meanwhile.
  [[nodiscard]] std::array<PulseObservation, kPanTiltMotors> run(const step::StepMotorsConfig& config,
                                                                 const PulsePlan& plan) {
    std::array<PulseObservation, kPanTiltMotors> seen;
    for (std::size_t motor = 0; motor < seen.size(); ++motor) seen[motor] = run_one(motor, config, plan);
    return seen;
  }

 private:
  static constexpr std::int64_t kRest_ns = 50'000'000;  // at each end
  static constexpr std::int64_t kSlack_ns = 2'000'000'000;

  PulseObservation run_one(std::size_t motor, step::StepMotorsConfig config, const PulsePlan& plan) {
    PulseObservation seen;
    // A home switch would set the position, and the way back would be another one.
    for (step::MotorConfig& its : config.motors) {
      if (its.low_end == step::EndAction::kHome) its.low_end = step::EndAction::kFault;
      if (its.high_end == step::EndAction::kHome) its.high_end = step::EndAction::kFault;
    }
    bool lines_work = false;
    const step::MotorError error = motors_.configure(config, lines_work);
    if (error.error != step::TimingError::kNone || !lines_work) {
      seen.problem =
          error.error != step::TimingError::kNone ? step::describe(error.error) : "the lines cannot be set";
      return seen;
    }
    const double fastest = static_cast<double>(config.motors[motor].timing.max_rate_millisteps_per_s) / 1000;
    const double rate = std::min(plan.steps_per_s, fastest);
    give_up_ns_ = clock_->now_ns() + config.settle_ns + kSlack_ns +
                  static_cast<std::int64_t>(4e9 * static_cast<double>(plan.steps) / rate);
    motors_.enable(true);
    drive(motor, rate, seen, [&] { return steps(motor) >= plan.steps; });
    seen.farthest_steps = steps(motor);
    drive(motor, -rate, seen, [&] { return steps(motor) <= 0; });
    seen.final_steps = steps(motor);
    seen.late_events = motors_.report().late_events;
    motors_.enable(false);
    motors_.run_edges(clock_->now_ns());
    seen.issued_ns = lines_.take(motor);
    return seen;
  }

  // At this rate until there, then at rest for a while.
  template <typename IsThere>
  void drive(std::size_t motor, double rate, PulseObservation& seen, IsThere&& is_there) {
    std::array<double, kPanTiltMotors> rates{};
    rates[motor] = rate;
    while (seen.problem.empty() && !is_there()) {
      motors_.command(rates);
      step_once(seen);
    }
    const std::int64_t until_ns = clock_->now_ns() + kRest_ns;
    while (seen.problem.empty() && clock_->now_ns() < until_ns) {
      motors_.command({});
      step_once(seen);
    }
  }

  void step_once(PulseObservation& seen) {
    sleeper_->sleep_until(motors_.next_deadline_ns());
    const std::int64_t now = clock_->now_ns();
    motors_.run_edges(now);
    if (watch_ != nullptr) watch_->collect(seen.looped_ns);
    PanTiltFeedback feedback;
    if (motors_.read(feedback)) feedback_ = feedback;
    if (feedback_.state == PanTiltState::kFault) seen.problem = step::describe(motors_.report().fault.fault);
    if (seen.problem.empty() && now > give_up_ns_)
      seen.problem = "it took far too long: a switch holds it back";
  }

  [[nodiscard]] std::int64_t steps(std::size_t motor) const { return feedback_.steps[motor]; }

  C* clock_;
  S* sleeper_;
  EdgeWatch* watch_;
  RecordedLines<Lines, C> lines_;
  step::StepMotors<RecordedLines<Lines, C>, C> motors_;
  PanTiltFeedback feedback_;
  std::int64_t give_up_ns_ = 0;
};

}  // namespace vergence::tools
