// A period of the eyes: they look at the target, or, while there is none, at the middle of where it is
// searched for.
#pragma once

#include <cstdint>

#include "algo/eye_vergence.hpp"
#include "firmware_like/messages.hpp"
#include "firmware_like/robot_config.hpp"
#include "hal/pan_tilt.hpp"

namespace vergence {

class EyeTask {
 public:
  [[nodiscard]] Status configure(const RobotConfig& config, double period_s);

  // `view` is the last word of hand and target, feedback the last word of the motors.
  EyeCommand step(std::int64_t now_ns, const HandView& view, const PanTiltFeedback& feedback);

  // Angles at so many issued steps.
  [[nodiscard]] EyeAngles angles(const PanTiltFeedback& feedback) const;

 private:
  EyeVergence vergence_;
  std::array<double, kEyeMotors> steps_per_rad_{};
  Vector3 home_mm_ = Vector3::Zero();  // in the hand
};

}  // namespace vergence
