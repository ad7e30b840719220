// The arm's drives: velocities go out once a period, positions and states come back.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>

#include "algo/limits.hpp"

namespace vergence {

enum class ArmState : std::uint8_t {
  kDisabled,  // no torque
  kEnabling,
  kEnabled,    // follows velocities
  kQuickStop,  // the drives brake by themselves
  kFault,
};

struct ArmFeedback {
  std::int64_t stamp_ns = 0;  // when the positions were sampled
  std::array<double, kMaxJoints> position_rad{};
  std::array<double, kMaxJoints> velocity_rad_per_s{};
  ArmState state = ArmState::kDisabled;
  std::uint32_t fault = 0;  // the driver's own code; 0: none
};

enum class ArmRequest : std::uint8_t {
  kDisable,
  kEnable,
  kQuickStop,
  kResetFault,
};

// None of these waits. read() answers false where nothing new came since the last call.
template <typename T>
concept Arm = requires(T& arm, ArmFeedback& feedback, const std::array<double, kMaxJoints>& velocity,
                       ArmRequest request) {
  { arm.read(feedback) } -> std::same_as<bool>;
  { arm.command(velocity) } -> std::same_as<void>;
  { arm.request(request) } -> std::same_as<void>;
};

}  // namespace vergence
