// What a stepper drive needs of its pulses, how exactly this machine can make them, and the rate that
// follows.
#pragma once

#include <cstdint>

namespace vergence::step {

// Phase is counted in 1e-12 steps: a rate in thousandths of a step a second times nanoseconds is a whole
// number of them, so nothing is ever rounded.
inline constexpr std::int64_t kPhasePerStep = 1'000'000'000'000;
inline constexpr std::int64_t kMillistepsPerStep = 1'000;
inline constexpr std::int64_t kShortestPulse_ns = 100;
inline constexpr std::int64_t kLongestPulse_ns = 100'000'000;
inline constexpr std::int64_t kLongestRamp_ns = 10'000'000;
inline constexpr std::int64_t kFastestAcceleration_millisteps_per_s2 = 100'000'000'000;

struct StepTiming {
  std::int64_t steplen_ns = 5'000;    // step line active, at least
  std::int64_t stepspace_ns = 5'000;  // step line at rest before it becomes active again, at least
  std::int64_t dirsetup_ns = 20'000;  // direction unchanged before a step begins, at least
  std::int64_t dirhold_ns = 20'000;   // direction unchanged after a step has ended, at least
  // Largest lateness of an edge that was measured on this machine, from when it was due to when the line had
  // its level. Time it is later than that is not made up for: the motion is delayed instead.
  std::int64_t jitter_ns = 100'000;
  std::int64_t ramp_ns = 1'000'000;  // the rate changes so often while it changes
  std::int64_t max_rate_millisteps_per_s = 2'000'000;
  std::int64_t acceleration_millisteps_per_s2 = 10'000'000;
};

// The rate at which a pulse, a pause, and both their edges late by the jitter just fit. 0: unusable
// durations.
[[nodiscard]] constexpr std::int64_t fastest_rate_millisteps_per_s(const StepTiming& timing) {
  const auto usable = [](std::int64_t ns) { return ns >= 0 && ns <= kLongestPulse_ns; };
  if (!usable(timing.steplen_ns) || !usable(timing.stepspace_ns) || !usable(timing.jitter_ns)) return 0;
  const std::int64_t period_ns = timing.steplen_ns + timing.stepspace_ns + 2 * timing.jitter_ns;
  return period_ns > 0 ? kPhasePerStep / period_ns : 0;
}

// By how much the rate changes at once while it changes.
[[nodiscard]] constexpr std::int64_t ramp_step_millisteps_per_s(const StepTiming& timing) {
  return timing.acceleration_millisteps_per_s2 * timing.ramp_ns / 1'000'000'000;
}

enum class TimingError : std::uint8_t {
  kNone,
  kBadPulse,
  kBadDirection,
  kBadJitter,
  kBadRamp,
  kBadAcceleration,
  kRateTooHigh,
  kBadPoll,
  kBadHome,
};

[[nodiscard]] constexpr TimingError check(const StepTiming& timing) {
  const auto within = [](std::int64_t value, std::int64_t low, std::int64_t high) {
    return value >= low && value <= high;
  };
  if (!within(timing.steplen_ns, kShortestPulse_ns, kLongestPulse_ns) ||
      !within(timing.stepspace_ns, kShortestPulse_ns, kLongestPulse_ns)) {
    return TimingError::kBadPulse;
  }
  if (!within(timing.dirsetup_ns, 0, kLongestPulse_ns) || !within(timing.dirhold_ns, 0, kLongestPulse_ns)) {
    return TimingError::kBadDirection;
  }
  // Lateness of up to a change of the rate is made up for, so two changes at most come at once.
  if (!within(timing.ramp_ns, 1'000, kLongestRamp_ns)) return TimingError::kBadRamp;
  if (!within(timing.jitter_ns, 0, timing.ramp_ns)) return TimingError::kBadJitter;
  if (!within(timing.acceleration_millisteps_per_s2, 1, kFastestAcceleration_millisteps_per_s2) ||
      ramp_step_millisteps_per_s(timing) < 1) {
    return TimingError::kBadAcceleration;
  }
  if (!within(timing.max_rate_millisteps_per_s, 1, fastest_rate_millisteps_per_s(timing))) {
    return TimingError::kRateTooHigh;
  }
  return TimingError::kNone;
}

// What is wrong and what to do, for people.
[[nodiscard]] constexpr const char* describe(TimingError error) {
  switch (error) {
    case TimingError::kNone: return "no error";
    case TimingError::kBadPulse: return "steplen and stepspace must be 100 ns to 100 ms";
    case TimingError::kBadDirection: return "dirsetup and dirhold must be 0 to 100 ms";
    case TimingError::kBadJitter: return "the jitter must be 0 up to the time between changes of the rate";
    case TimingError::kBadRamp: return "the rate may change every 1 us to 10 ms";
    case TimingError::kBadAcceleration:
      return "the acceleration must change the rate by a thousandth of a step a second each time, and be at "
             "most "
             "1e8 steps/s^2";
    case TimingError::kRateTooHigh:
      return "the maximum rate must be positive and at most 1/(steplen + stepspace + 2 jitter): lower it, or "
             "make the step task more punctual and measure its jitter again";
    case TimingError::kBadPoll:
      return "inputs must be polled every 10 us to 100 ms, and drives have 0 to 10 s to settle";
    case TimingError::kBadHome: return "a motor has one home at most, and its tolerance is not negative";
  }
  return "unknown error";
}

}  // namespace vergence::step
