#include "algo/eye_vergence.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

constexpr double kFarthest_mm = 1e9;         // what is beyond is no target; squares stay finite
constexpr double kLeastVergence_rad = 1e-9;  // eyes closer to parallel meet nowhere

// A target as the mount sees it.
struct Sight {
  double x, y, z;   // from the middle of the eyes, in the hand's axes
  double distance;  // from the tilt axis, in the tilted plane
};

Sight sight(const EyeMount& mount, const Vector3& target_mm) {
  const double y = target_mm[1] - mount.tilt_axis_y_mm;
  const double z = target_mm[2] - mount.tilt_axis_z_mm;
  return {target_mm[0], y, z, std::sqrt(y * y + z * z)};
}

bool is_in_front(const EyeMount& mount, const Vector3& target_mm) {
  // Written so that NaN is not in front.
  return target_mm.cwiseAbs().maxCoeff() < kFarthest_mm && target_mm.allFinite() &&
         target_mm[2] - mount.tilt_axis_z_mm >= kLeastDepth_mm;
}

std::array<double, kEyeMotors> in_order(const EyeAngles& a) {
  return {a.tilt_rad, a.pan_right_rad, a.pan_left_rad};
}
std::array<double, kEyeMotors> in_order(const EyeRates& r) {
  return {r.tilt_rad_per_s, r.pan_right_rad_per_s, r.pan_left_rad_per_s};
}

}  // namespace

Transform left_eye_at_zero(const EyeMount& mount) {
  return {Matrix3::Identity(), {-mount.half_baseline_mm, mount.tilt_axis_y_mm, mount.tilt_axis_z_mm}};
}

Transform right_eye_at_zero(const EyeMount& mount) {
  return {Matrix3::Identity(), {mount.half_baseline_mm, mount.tilt_axis_y_mm, mount.tilt_axis_z_mm}};
}

std::optional<EyeAngles> desired_eye_angles(const EyeMount& mount, const Vector3& target_mm) {
  if (!is_in_front(mount, target_mm)) return std::nullopt;
  const Sight s = sight(mount, target_mm);
  const double l = mount.half_baseline_mm;
  return EyeAngles{arc_tangent2(s.y, s.z), arc_tangent2(l - s.x, s.distance),
                   arc_tangent2(l + s.x, s.distance)};
}

EyeRates desired_eye_rates(const EyeMount& mount, const Vector3& target_mm,
                           const Vector3& velocity_mm_per_s) {
  const Sight s = sight(mount, target_mm);
  const Vector3& v = velocity_mm_per_s;
  const double d2 = s.distance * s.distance;
  const double receding = (s.y * v[1] + s.z * v[2]) / s.distance;
  const double right = mount.half_baseline_mm - s.x;
  const double left = mount.half_baseline_mm + s.x;
  return {(s.z * v[1] - s.y * v[2]) / d2, (-s.distance * v[0] - right * receding) / (d2 + right * right),
          (s.distance * v[0] - left * receding) / (d2 + left * left)};
}

Vector3 apparent_velocity(const Vector3& target_mm, const Vector3& target_velocity_mm_per_s,
                          const Vector3& hand_linear_mm_per_s, const Vector3& hand_angular_rad_per_s) {
  return target_velocity_mm_per_s - hand_linear_mm_per_s - hand_angular_rad_per_s.cross(target_mm);
}

Gaze gaze(const EyeMount& mount, const EyeAngles& angles) {
  const SinCos tilt = sin_cos(angles.tilt_rad);
  const auto in_hand = [&tilt](double x, double distance) -> Vector3 {
    return {x, distance * tilt.sine, distance * tilt.cosine};
  };
  const auto [middle_s, middle_c] = sin_cos((angles.pan_left_rad - angles.pan_right_rad) / 2);
  Gaze gaze;
  gaze.direction = in_hand(middle_s, middle_c);

  // [3.43, 3.44] with tangents written as sines and cosines, which stay finite.
  const auto [right_s, right_c] = sin_cos(angles.pan_right_rad);
  const auto [left_s, left_c] = sin_cos(angles.pan_left_rad);
  const double meeting = right_s * left_c + right_c * left_s;  // sine of the angle between the lines
  if (meeting > kLeastVergence_rad && right_c > 0 && left_c > 0) {
    const double l = mount.half_baseline_mm;
    const double x = l * (left_s * right_c - left_c * right_s) / meeting;
    const double distance = 2 * l * right_c * left_c / meeting;
    gaze.point_mm = in_hand(x, distance) + Vector3(0, mount.tilt_axis_y_mm, mount.tilt_axis_z_mm);
  }
  return gaze;
}

Status EyeVergence::configure(const EyeMount& mount, const EyeControl& control,
                              const std::array<JointLimits, kEyeMotors>& limits, double period_s) {
  mount_ = mount;
  control_ = control;
  limiter_.limits = limits;
  limiter_.period_s = period_s;
  limiter_.last = {};
  const bool mounted = mount.half_baseline_mm > 0 && std::isfinite(mount.half_baseline_mm) &&
                       std::isfinite(mount.tilt_axis_y_mm) && std::isfinite(mount.tilt_axis_z_mm);
  const bool controlled = control.gain_per_period > 0 && control.gain_per_period <= 1 &&
                          control.latency_s >= 0 && std::isfinite(control.latency_s);
  bool stepped = true;
  for (const double steps : control.steps_per_rad) stepped = stepped && steps != 0 && std::isfinite(steps);
  return mounted && controlled && stepped ? limiter_.check_limits() : Status::kBadLimits;
}

EyeCommand EyeVergence::step(const std::optional<Vector3>& target_mm, const Vector3& apparent_mm_per_s,
                             const EyeAngles& now) {
  const double period_s = limiter_.period_s;
  std::array<double, kEyeMotors> desired{};
  EyeCommand command;
  command.holds = true;
  if (target_mm) {
    // To when the command begins to act; the rates, to the middle of the period it acts for.
    const Vector3 target = *target_mm + control_.latency_s * apparent_mm_per_s;
    const Vector3 midway = target + period_s / 2 * apparent_mm_per_s;
    const auto angles = desired_eye_angles(mount_, target);
    if (angles && is_in_front(mount_, midway)) {
      command.holds = false;
      const auto goal = in_order(*angles);
      const auto at = in_order(now);
      const auto rates = in_order(desired_eye_rates(mount_, midway, apparent_mm_per_s));
      for (std::size_t i = 0; i < kEyeMotors; ++i) {
        // [3.35], but no faster than the motor can come to rest from at the goal.
        const double error = control_.gain_per_period * (goal[i] - at[i]) / period_s;
        const double most = largest_step(std::abs(goal[i] - at[i]) / period_s,
                                         limiter_.limits[i].acceleration_rad_per_s2 * period_s);
        desired[i] = std::clamp(error, -most, most) + rates[i];
      }
    }
  }
  const auto at = in_order(now);
  for (std::size_t i = 0; i < kEyeMotors; ++i) limiter_.last[i].position_rad = at[i];
  command.flags = limiter_.limit(desired);
  for (std::size_t i = 0; i < kEyeMotors; ++i) {
    command.rate_rad_per_s[i] = limiter_.last[i].velocity_rad_per_s;
    command.steps_per_s[i] = command.rate_rad_per_s[i] * control_.steps_per_rad[i];
  }
  return command;
}

}  // namespace vergence
