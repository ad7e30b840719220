#include "firmware_like/eye_task.hpp"

#include <Eigen/Geometry>

#include "hal/clock.hpp"

namespace vergence {

Status EyeTask::configure(const RobotConfig& config, double period_s) {
  steps_per_rad_ = config.eye_control.steps_per_rad;
  for (int i = 0; i < 3; ++i) home_mm_[i] = config.tracker.box.centre[static_cast<std::size_t>(i)];
  return vergence_.configure(config.mount, config.eye_control, config.eye_limits, period_s);
}

EyeAngles EyeTask::angles(const PanTiltFeedback& feedback) const {
  const auto angle = [&](std::size_t i) {
    return static_cast<double>(feedback.steps[i]) / steps_per_rad_[i];
  };
  return {angle(0), angle(1), angle(2)};
}

EyeCommand EyeTask::step(std::int64_t now_ns, const HandView& view, const PanTiltFeedback& feedback) {
  const EyeAngles now = angles(feedback);
  if (!is_armed(view.mode)) return vergence_.step(std::nullopt, Vector3::Zero(), now);
  if (!view.target_known) return vergence_.step(home_mm_, Vector3::Zero(), now);
  // Hand and target move on by themselves from when they were told to now; both are a period old at most.
  const double since_s = seconds(now_ns - view.t_ns);
  const Vector3 target_W_mm = view.target_mm + since_s * view.target_mm_per_s;
  const Vector3 hand_W_mm = view.T_W_H.t_mm + since_s * view.hand.linear_mm_per_s;
  const Matrix3 R_H_W = view.T_W_H.R.transpose();
  const Vector3 target_H_mm = R_H_W * (target_W_mm - hand_W_mm);
  const Vector3 apparent =
      apparent_velocity(target_H_mm, R_H_W * view.target_mm_per_s, R_H_W * view.hand.linear_mm_per_s,
                        R_H_W * view.hand.angular_rad_per_s);
  const Vector3 turned_mm = target_H_mm - since_s * (R_H_W * view.hand.angular_rad_per_s).cross(target_H_mm);
  return vergence_.step(turned_mm, apparent, now);
}

}  // namespace vergence
