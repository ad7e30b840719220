// Where the eyes are to look [Eqs. 3.32-3.35], where they do look [3.43, 3.44], and the rates of their
// motors, so that a target is kept in the centre of both images. Signs of the angles: algo/eye_mount.hpp. Why
// the equations differ a little from the printed ones: docs/eye_vergence.md.
#pragma once

#include <optional>

#include "algo/eye_mount.hpp"
#include "algo/motion_limits.hpp"

namespace vergence {

// The mount on the hand. The tilt axis is parallel to x of the hand; the cameras' centres lie on it, either
// side.
struct EyeMount {
  double half_baseline_mm = 120;
  double tilt_axis_y_mm = -100;  // above the hand's axis: y points down
  double tilt_axis_z_mm = 0;
};

// Poses of the cameras in the hand at zero angles, for algo/eye_mount.
[[nodiscard]] Transform left_eye_at_zero(const EyeMount& mount);
[[nodiscard]] Transform right_eye_at_zero(const EyeMount& mount);

// A target nearer than this to the plane of the eyes counts as behind them.
inline constexpr double kLeastDepth_mm = 1;

// Angles that centre a target (in the hand, mm) exactly in both images [3.32-3.34]. None where it is not in
// front of the eyes, or not finite.
[[nodiscard]] std::optional<EyeAngles> desired_eye_angles(const EyeMount& mount, const Vector3& target_mm);

struct EyeRates {
  double tilt_rad_per_s = 0;
  double pan_right_rad_per_s = 0;
  double pan_left_rad_per_s = 0;
};

// How fast those angles change with a target in front of the eyes that moves in the hand.
[[nodiscard]] EyeRates desired_eye_rates(const EyeMount& mount, const Vector3& target_mm,
                                         const Vector3& velocity_mm_per_s);

// Velocity at which a target seems to move in the hand, from its own and the hand's motion, all in the hand's
// axes.
[[nodiscard]] Vector3 apparent_velocity(const Vector3& target_mm, const Vector3& target_velocity_mm_per_s,
                                        const Vector3& hand_linear_mm_per_s,
                                        const Vector3& hand_angular_rad_per_s);

// Where the lines of sight meet, in the hand [3.43, 3.44]. Parallel or diverging eyes have no such point:
// then the direction alone says where they look.
struct Gaze {
  Vector3 direction = {0, 0, 1};  // of unit length, halfway between the two lines of sight
  std::optional<Vector3> point_mm;
};
[[nodiscard]] Gaze gaze(const EyeMount& mount, const EyeAngles& angles);

inline constexpr int kEyeMotors = 3;  // tilt, right pan, left pan, in this order

struct EyeControl {
  double gain_per_period = 1;  // K_P [3.35], of a control period
  double latency_s = 0;        // from a frame's stamp to when the command made from it begins to act
  std::array<double, kEyeMotors> steps_per_rad{};
};

struct EyeCommand {
  std::array<double, kEyeMotors> rate_rad_per_s{};
  std::array<double, kEyeMotors> steps_per_s{};
  std::array<LimitFlags, kEyeMotors> flags{};
  bool holds = false;  // nothing to look at: the motors are brought to rest where they are
};

class EyeVergence {
 public:
  // kOk, or kBadLimits: limits or period not usable, gain outside (0, 1], negative latency, no steps.
  [[nodiscard]] Status configure(const EyeMount& mount, const EyeControl& control,
                                 const std::array<JointLimits, kEyeMotors>& limits, double period_s);

  // The command of the coming period. `target_mm` is where the target was in the hand when the frame was
  // taken, `apparent_mm_per_s` its velocity there (zero: no feed-forward), `now` the angles at the start of
  // the period.
  [[nodiscard]] EyeCommand step(const std::optional<Vector3>& target_mm, const Vector3& apparent_mm_per_s,
                                const EyeAngles& now);

 private:
  EyeMount mount_;
  EyeControl control_;
  MotionLimiter<kEyeMotors> limiter_;
};

}  // namespace vergence
