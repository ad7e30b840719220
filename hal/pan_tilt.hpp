// The three stepper motors that turn the eyes: tilt, right pan, left pan, in this order.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>

namespace vergence {

inline constexpr int kPanTiltMotors = 3;

enum class PanTiltState : std::uint8_t {
  kDisabled,
  kEnabled,
  kFault,
};

struct PanTiltFeedback {
  std::int64_t stamp_ns = 0;
  std::array<std::int64_t, kPanTiltMotors> steps{};  // issued since the eyes were at zero, with sign
  PanTiltState state = PanTiltState::kDisabled;
};

// None of these waits. Rates in steps a second hold until the next command; disabling stops the pulses.
template <typename T>
concept PanTilt = requires(T& eyes, PanTiltFeedback& feedback, const std::array<double, kPanTiltMotors>& rate,
                           bool on) {
  { eyes.read(feedback) } -> std::same_as<bool>;
  { eyes.command(rate) } -> std::same_as<void>;
  { eyes.enable(on) } -> std::same_as<void>;
};

}  // namespace vergence
