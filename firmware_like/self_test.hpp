// Before drives are switched on: is what the devices say what the configuration expects?
#pragma once

#include <cstdint>

#include "firmware_like/robot_config.hpp"
#include "firmware_like/supervisor.hpp"
#include "hal/arm.hpp"
#include "hal/pan_tilt.hpp"

namespace vergence {

enum class SelfTestFinding : std::uint8_t {
  kNone,
  kJointNotFinite,
  kJointBeyondLimits,
  kToolOutsideBox,
  kEyeBeyondLimits,
};

// What was found, and what to do about it, in words.
[[nodiscard]] const char* describe(SelfTestFinding finding);

struct SelfTestResult {
  SelfTestFinding finding = SelfTestFinding::kNone;
  int index = 0;  // of joint or motor, from 1
};

[[nodiscard]] SelfTestResult self_test(const RobotConfig& config, const ArmFeedback& arm,
                                       const PanTiltFeedback& eyes);

}  // namespace vergence
