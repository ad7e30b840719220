// The lines of the three motors as bits of a word, and whoever can set and read them.
#pragma once

#include <concepts>
#include <cstdint>

#include "hal/pan_tilt.hpp"

namespace vergence::step {

// Bits of outputs: step and direction of each motor, in the order of hal/pan_tilt.hpp.
[[nodiscard]] constexpr std::uint32_t step_bit(int motor) {
  return 1U << (2 * motor);
}
[[nodiscard]] constexpr std::uint32_t forward_bit(int motor) {
  return 2U << (2 * motor);
}
inline constexpr int kOutputLines = 2 * kPanTiltMotors;

// Bits of inputs: the switches at the ends of each motor's range.
[[nodiscard]] constexpr std::uint32_t low_end_bit(int motor) {
  return 1U << (2 * motor);
}
[[nodiscard]] constexpr std::uint32_t high_end_bit(int motor) {
  return 2U << (2 * motor);
}
inline constexpr int kInputLines = 2 * kPanTiltMotors;

// All three answer false where it did not succeed, and none of them waits. Levels are logical: 1 is a step, a
// positive direction, drives enabled, a switch pressed. set_outputs() sets all lines in one call;
// set_enable() may be called from any thread, whatever the others do.
template <typename T>
concept StepLines = requires(T& lines, std::uint32_t levels, std::uint32_t& read, bool on) {
  { lines.set_outputs(levels) } -> std::same_as<bool>;
  { lines.set_enable(on) } -> std::same_as<bool>;
  { lines.read_inputs(read) } -> std::same_as<bool>;
};

}  // namespace vergence::step
