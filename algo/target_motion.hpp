// Where a target is in the world at any instant, how fast it moves and how that changes, from poses observed
// at irregular times. For the control of hand and eyes; the tracker's own predictor (motion_predictor) is
// simpler. Model, covariances and measurements: docs/target_motion.md.
#pragma once

#include <cstdint>
#include <optional>

#include "algo/hand_limits.hpp"
#include "algo/pose.hpp"
#include "algo/status.hpp"

namespace vergence {

struct TargetMotionOptions {
  // Standard deviation of an observation: of each axis of the position, of the rotation about each axis.
  double position_noise_mm = 0.5;
  double rotation_noise_rad = 0.005;
  // White jerk: the acceleration wanders by this much in a second, by sqrt(t) as much in t seconds.
  double jerk_mm_per_s3 = 500;
  double angular_jerk_rad_per_s3 = 3;
  double acceleration_memory_s = 1;  // an acceleration not seen again fades by exp(-t / memory)
  // Standard deviation of each axis of the velocity of a target just found.
  double start_speed_mm_per_s = 300;
  double start_angular_speed_rad_per_s = 1;
  // After this time without an observation the motion is no longer believed: the target is brought to rest
  // within rest_s, and the next observation starts anew.
  double coast_s = 0.5;
  double rest_s = 0.5;
  // An observation farther than this from the prediction, in standard deviations, is left out; the last of so
  // many in a row is where the filter starts anew.
  double gate_sigma = 6;
  int restart_after = 4;
};

struct ObservationNoise {
  double position_mm = 0;  // standard deviations, as in the options
  double rotation_rad = 0;
};

// Accelerations, in the axes of the world.
struct TwistRate {
  Vector3 linear_mm_per_s2 = Vector3::Zero();
  Vector3 angular_rad_per_s2 = Vector3::Zero();
};

// At one instant. Twist and rate: of M's origin and of its rotation, in W. The rate is that of the twist.
struct TargetState {
  Transform T_W_M;
  Twist velocity;
  TwistRate acceleration;
};

// Value, rate and acceleration of one axis over a time step, and the covariance of the three, which is the
// same for the three axes: all have the same noise, so the filter knows no direction from another.
class AxisFilter {
 public:
  struct Gains {
    double value = 0;
    double rate_per_s = 0;
    double acceleration_per_s2 = 0;
  };

  void start(double noise, double start_rate, double start_acceleration);
  void predict(double dt_s, double memory_s, double jerk);
  [[nodiscard]] double innovation_variance(double noise) const { return P_(0, 0) + noise * noise; }
  [[nodiscard]] Gains update(double noise);

 private:
  Matrix3 P_ = Matrix3::Zero();
};

class TargetMotion {
 public:
  // kOk, or kBadGains (and the options before stay): a number not finite or not positive, a time constant
  // outside [1 ms, 1e6 s], coast_s or rest_s above 10 s, gate_sigma below 1, restart_after outside [1, 1000].
  [[nodiscard]] Status configure(const TargetMotionOptions& options);

  void forget();
  [[nodiscard]] bool known() const { return known_; }

  // The target was seen at T_W_M at an instant of any clock, in ns. False where it was left out: not newer
  // than the last one offered, not rigid to 1e-6 or beyond 1e9 mm, its noise not positive, or outside the
  // gate. own_noise: of this observation, instead of the options'.
  bool observe(std::int64_t stamp_ns, const Transform& T_W_M,
               const std::optional<ObservationNoise>& own_noise = std::nullopt);

  // At an instant of the same clock. Before last_ns(): as at last_ns(). Where nothing is known: identity, at
  // rest. Never farther from the last estimate than the motion of coast_s and half of rest_s after it.
  [[nodiscard]] TargetState at(std::int64_t t_ns) const;

  // Of the newest observation that was taken.
  [[nodiscard]] std::int64_t last_ns() const { return last_ns_; }

 private:
  void start(std::int64_t stamp_ns, const Transform& T_W_M, const ObservationNoise& noise);

  TargetMotionOptions options_;
  bool known_ = false;
  std::int64_t last_ns_ = 0;
  std::int64_t offered_ns_ = 0;  // newest stamp, taken or not
  int outliers_ = 0;             // in a row
  TargetState state_;            // at last_ns_
  AxisFilter position_;
  AxisFilter rotation_;
};

}  // namespace vergence
