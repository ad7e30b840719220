// Three step generators, and what the switches at the ends of their ranges do to them. Knows neither lines
// nor threads.
#pragma once

#include <array>
#include <cstdint>

#include "hal/gpio_step/step_generator.hpp"
#include "hal/gpio_step/step_lines.hpp"
#include "hal/gpio_step/step_timing.hpp"

namespace vergence::step {

enum class EndAction : std::uint8_t {
  kNone,   // no switch there
  kFault,  // a motor that moves towards a pressed switch is a fault
  kHome,   // it stops at once, and has home_steps there
};

struct MotorConfig {
  StepTiming timing;
  EndAction low_end = EndAction::kNone;  // where the position is least
  EndAction high_end = EndAction::kNone;
  std::int64_t home_steps = 0;
  // Once home was found, to run into its switch elsewhere by more than this, or past home by more without
  // meeting it, is a fault: steps were lost. The next time it is met, it is home anew.
  std::int64_t home_tolerance_steps = 50;
};

enum class StepFault : std::uint8_t {
  kNone,
  kEndReached,  // towards a pressed switch
  kHomeMoved,
  kInputsUnreadable,
  kOutputsFailed,
  kEnableFailed,
};

// What happened and what to do, for people.
[[nodiscard]] const char* describe(StepFault fault);

struct MotorFault {
  StepFault fault = StepFault::kNone;
  int motor = -1;  // -1: all of them
};

struct MotorError {
  TimingError error = TimingError::kNone;
  int motor = -1;
};

using MotorRates = std::array<std::int64_t, kPanTiltMotors>;  // thousandths of a step a second

class MotorSet {
 public:
  // All at rest, positions 0.
  [[nodiscard]] MotorError configure(const std::array<MotorConfig, kPanTiltMotors>& config,
                                     std::int64_t now_ns);

  // Rates to ramp to; not towards pressed switches. Answers how many were above their maximum; those motors
  // ramp to rest. `inputs` are the bits of step_lines.hpp.
  int command(std::int64_t now_ns, const MotorRates& rates, std::uint32_t inputs, MotorFault& fault);
  // At rest at once; pulses that have begun get their length.
  void halt();

  [[nodiscard]] std::int64_t next_event_ns() const;
  // The outputs from now on; where they differ from before they are to be set, and written() called.
  std::uint32_t advance(std::int64_t now_ns);
  void written(std::int64_t done_ns);
  // The same after an attempt to set them that failed.
  void rewritten(std::int64_t done_ns);
  [[nodiscard]] std::uint32_t outputs() const;

  [[nodiscard]] const StepGenerator& motor(int i) const { return generators_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool is_homed(int i) const { return homed_[static_cast<std::size_t>(i)]; }

 private:
  struct End {
    EndAction action;
    std::int64_t direction;  // 1 or -1
    bool is_pressed;
    bool is_new;  // and was not before
  };
  std::int64_t heed_end(std::size_t motor, const End& end, std::int64_t rate, MotorFault& fault);

  std::array<MotorConfig, kPanTiltMotors> config_{};
  std::array<StepGenerator, kPanTiltMotors> generators_{};
  std::array<bool, kPanTiltMotors> homed_{};
  std::array<bool, kPanTiltMotors> moved_{};  // by the last advance()
  std::uint32_t pressed_ = 0;                 // switches, at the last command()
};

}  // namespace vergence::step
