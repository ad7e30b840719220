// Step motors on lines in memory in virtual time: both tasks in one thread, one after the other.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/gpio_step/memory_lines.hpp"
#include "hal/gpio_step/step_motors.hpp"
#include "hal/sim/sim_devices.hpp"

namespace vergence::testing {

// Quick enough for short tests: 10 000 steps a second within 10 ms.
inline step::StepMotorsConfig config_of_step_rig() {
  step::StepMotorsConfig config;
  for (step::MotorConfig& motor : config.motors) {
    motor.timing.jitter_ns = 20'000;
    motor.timing.max_rate_millisteps_per_s = 10'000'000;
    motor.timing.acceleration_millisteps_per_s2 = 1'000'000'000;
  }
  config.settle_ns = 2'000'000;
  return config;
}

template <step::StepLines Lines = step::MemoryLines>
class StepRig {
 public:
  static constexpr std::size_t kMostEdges = 20'000;

  // The configuration's errors, and whether the lines could be set.
  [[nodiscard]] step::MotorError configure(const step::StepMotorsConfig& config) {
    return motors.configure(config, lines_work);
  }

  // The step task until then, late by late_ns each time; the eyes' task reads as often.
  void run_until(std::int64_t until_ns) {
    while (motors.next_deadline_ns() < until_ns) {
      clock.set_now_ns(std::max(clock.now_ns(), motors.next_deadline_ns()) + late_ns);
      run_once();
    }
    clock.set_now_ns(std::max(clock.now_ns(), until_ns));
  }
  void run_for(std::int64_t ns) { run_until(clock.now_ns() + ns); }
  void run_once() {
    ++runs;
    motors.run_edges(clock.now_ns());
    (void)motors.read(feedback);
  }
  // Enabled and settled.
  [[nodiscard]] bool enable() {
    motors.enable(true);
    run_for(5'000'000);
    return state() == PanTiltState::kEnabled;
  }
  void command(double tilt, double right = 0, double left = 0) { motors.command({tilt, right, left}); }

  [[nodiscard]] PanTiltState state() const { return feedback.state; }
  [[nodiscard]] const step::StepReport& report() const { return motors.report(); }
  [[nodiscard]] std::int64_t steps(std::size_t motor = 0) const { return feedback.steps[motor]; }
  // Active edges of a motor's step line on record.
  [[nodiscard]] std::int64_t pulses(int motor = 0) const {
    const int line = 2 * motor;
    return std::count_if(lines.edges().begin(), lines.edges().end(),
                         [line](const step::LineEdge& edge) { return edge.line == line && edge.level; });
  }

  std::array<step::LineEdge, kMostEdges> record{};
  sim::SimClock clock;
  Lines lines{std::span<step::LineEdge>(record), clock};
  step::StepMotors<Lines, sim::SimClock> motors{lines, clock};
  PanTiltFeedback feedback;
  bool lines_work = false;
  std::int64_t late_ns = 0;
  std::uint64_t runs = 0;
};

static_assert(PanTilt<step::StepMotors<step::MemoryLines, sim::SimClock>>);

}  // namespace vergence::testing
