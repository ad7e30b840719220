#include "firmware_like/self_test.hpp"

#include <cmath>

namespace vergence {

const char* describe(SelfTestFinding finding) {
  switch (finding) {
    case SelfTestFinding::kNone: return "passed";
    case SelfTestFinding::kJointNotFinite:
      return "a joint's position is no number: check the drive's scale and its encoder";
    case SelfTestFinding::kJointBeyondLimits:
      return "a joint stands beyond its limits: move it back by hand, or check its homing and limits";
    case SelfTestFinding::kToolOutsideBox:
      return "the tool is outside the box it is to stay in: move the arm, or check the box";
    case SelfTestFinding::kEyeBeyondLimits:
      return "a motor of the eyes stands beyond its limits: home the eyes, or check steps_per_rad";
  }
  return "unknown finding";
}

SelfTestResult self_test(const RobotConfig& config, const ArmFeedback& arm, const PanTiltFeedback& eyes) {
  if (config.has_arm) {
    for (int i = 0; i < config.arm.joints; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double q = arm.position_rad[k];
      if (!std::isfinite(q)) return {SelfTestFinding::kJointNotFinite, i + 1};
      if (!is_within(q, config.arm.limits[k])) return {SelfTestFinding::kJointBeyondLimits, i + 1};
    }
    const Transform T_W_H = forward_kinematics(config.arm, JointVector(arm.position_rad.data())).T_W_H;
    const Vector3 tool = T_W_H * config.tool_mm;
    const HandLimits& limits = config.hand_limits;
    if ((tool.array() < limits.box_min_mm.array()).any() ||
        (tool.array() > limits.box_max_mm.array()).any()) {
      return {SelfTestFinding::kToolOutsideBox, 0};
    }
  }
  if (config.has_eyes) {
    for (std::size_t i = 0; i < kEyeMotors; ++i) {
      const double angle = static_cast<double>(eyes.steps[i]) / config.eye_control.steps_per_rad[i];
      if (!is_within(angle, config.eye_limits[i])) {
        return {SelfTestFinding::kEyeBeyondLimits, static_cast<int>(i) + 1};
      }
    }
  }
  return {};
}

}  // namespace vergence
