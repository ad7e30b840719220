#include "algo/target_motion.hpp"

#include <algorithm>
#include <cmath>

#include "algo/arm_kinematics.hpp"
#include "algo/rotation_vector.hpp"

namespace vergence {
namespace {

constexpr double kLargest = 1e9;      // of any number of the options
constexpr double kMostTurn_rad = 90;  // of a prediction: rotation_from_vector's range, with room

bool is_positive(double value) {
  return value > 0 && value <= kLargest;  // false for NaN
}

bool is_time_constant(double value_s) {
  return value_s >= 1e-3 && value_s <= 1e6;
}

// Seconds from one instant to a later one; zero where it is not later. Differences of far instants do not
// fit into 63 bits.
double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  if (to_ns <= from_ns) return 0;
  return static_cast<double>(static_cast<std::uint64_t>(to_ns) - static_cast<std::uint64_t>(from_ns)) * 1e-9;
}

// What an acceleration of 1 that fades by exp(-t / memory) makes of acceleration, rate and value.
struct Fading {
  double acceleration;
  double rate_s;
  double value_s2;
};

// phi_0 = exp(-x), phi_1 = (1 - phi_0) / x, phi_2 = (1 - phi_1) / x at x = t / memory, by the series of phi_2
// where x is small (the differences would lose all digits), by squaring exp(-x / 2^k) where it is not.
Fading fading(double t_s, double memory_s) {
  const double x = t_s / memory_s;
  double small = x;
  int halvings = 0;
  while (small > 0.5 && halvings < 6) {  // up to x = 32; beyond, exp(-x) is as good as nothing
    small /= 2;
    ++halvings;
  }
  double phi0 = 0;
  double phi1 = 0;
  double phi2 = 0;
  if (small <= 0.5) {
    // The first term left out is x^14 / 16!, below 1e-17.
    double series = 1;
    for (int n = 15; n > 2; --n) series = 1 - small / n * series;
    phi2 = series / 2;
    phi1 = 1 - small * phi2;
    phi0 = 1 - small * phi1;
  }
  if (halvings > 0) {
    for (int i = 0; i < halvings; ++i) phi0 *= phi0;
    phi1 = (1 - phi0) / x;
    phi2 = (1 - phi1) / x;
  }
  return {phi0, phi1 * t_s, phi2 * t_s * t_s};
}

// The state some time later: the acceleration fades; after coast_s the velocity falls to zero within rest_s.
// A turn is exp of the sum of the angular velocities: where their axis itself turns, that is right to
// t^3 |w x w'| / 12, 4e-6 rad for 1 rad/s and 1 rad/s^2 over 35 ms.
TargetState predict(const TargetState& from, double t_s, const TargetMotionOptions& options) {
  const double coast_s = std::min(t_s, options.coast_s);
  const Fading f = fading(coast_s, options.acceleration_memory_s);
  const Vector3& v = from.velocity.linear_mm_per_s;
  const Vector3& w = from.velocity.angular_rad_per_s;
  const Vector3& a = from.acceleration.linear_mm_per_s2;
  const Vector3& aw = from.acceleration.angular_rad_per_s2;
  TargetState to;
  Vector3 move = v * coast_s + a * f.value_s2;
  Vector3 turn = w * coast_s + aw * f.value_s2;
  to.velocity = {v + a * f.rate_s, w + aw * f.rate_s};
  to.acceleration = {a * f.acceleration, aw * f.acceleration};
  if (t_s > options.coast_s) {
    const double share = std::min((t_s - options.coast_s) / options.rest_s, 1.0);
    const double still_s = options.rest_s * share * (1 - share / 2);
    move += to.velocity.linear_mm_per_s * still_s;
    turn += to.velocity.angular_rad_per_s * still_s;
    const double per_s = share < 1 ? -1 / options.rest_s : 0.0;
    to.acceleration = {to.velocity.linear_mm_per_s * per_s, to.velocity.angular_rad_per_s * per_s};
    to.velocity = {to.velocity.linear_mm_per_s * (1 - share), to.velocity.angular_rad_per_s * (1 - share)};
  }
  const double angle = turn.norm();
  if (angle > kMostTurn_rad) turn *= kMostTurn_rad / angle;
  to.T_W_M = {rotation_from_vector(turn) * from.T_W_M.R, from.T_W_M.t_mm + move};
  return to;
}

// Rounding must not build up: a step of Newton towards the nearest rotation squares what is missing to one.
// It is as good for every attitude, where a quaternion's fourth part, taken from the other three, is lost
// near half a turn.
Matrix3 exact(const Matrix3& R) {
  return 0.5 * (R * (3 * Matrix3::Identity() - R.transpose() * R));
}

// Standard deviation an acceleration has in the long run, from white jerk and fading.
double usual_acceleration(double jerk, double memory_s) {
  return jerk * std::sqrt(memory_s / 2);
}

}  // namespace

void AxisFilter::start(double noise, double start_rate, double start_acceleration) {
  P_ = Vector3(noise * noise, start_rate * start_rate, start_acceleration * start_acceleration).asDiagonal();
}

void AxisFilter::predict(double dt_s, double memory_s, double jerk) {
  const Fading f = fading(dt_s, memory_s);
  Matrix3 Phi;
  Phi << 1, dt_s, f.value_s2, 0, 1, f.rate_s, 0, 0, f.acceleration;
  // Of white jerk without fading: within a frame the same, over a long gap rather too much.
  const double t = dt_s;
  Matrix3 Q;
  Q << t * t * t * t * t / 20, t * t * t * t / 8, t * t * t / 6,  //
      t * t * t * t / 8, t * t * t / 3, t * t / 2,                //
      t * t * t / 6, t * t / 2, t;
  const Matrix3 P = Phi * P_ * Phi.transpose() + (jerk * jerk) * Q;
  P_ = 0.5 * (P + P.transpose());
}

AxisFilter::Gains AxisFilter::update(double noise) {
  const double R = noise * noise;
  const Vector3 K = P_.col(0) / (P_(0, 0) + R);
  Matrix3 keep = Matrix3::Identity();
  keep.col(0) -= K;
  // Joseph's form stays positive whatever the rounding.
  const Matrix3 P = keep * P_ * keep.transpose() + R * (K * K.transpose());
  P_ = 0.5 * (P + P.transpose());
  return {K[0], K[1], K[2]};
}

Status TargetMotion::configure(const TargetMotionOptions& options) {
  const bool good = is_positive(options.position_noise_mm) && is_positive(options.rotation_noise_rad) &&
                    is_positive(options.jerk_mm_per_s3) && is_positive(options.angular_jerk_rad_per_s3) &&
                    is_positive(options.start_speed_mm_per_s) &&
                    is_positive(options.start_angular_speed_rad_per_s) &&
                    is_time_constant(options.acceleration_memory_s) && is_time_constant(options.coast_s) &&
                    is_time_constant(options.rest_s) && options.coast_s <= 10 && options.rest_s <= 10 &&
                    options.gate_sigma >= 1 && options.gate_sigma <= kLargest && options.restart_after >= 1 &&
                    options.restart_after <= 1000;
  if (!good) return Status::kBadGains;
  options_ = options;
  forget();
  return Status::kOk;
}

void TargetMotion::forget() {
  const TargetMotionOptions options = options_;
  *this = TargetMotion{};
  options_ = options;
}

void TargetMotion::start(std::int64_t stamp_ns, const Transform& T_W_M, const ObservationNoise& noise) {
  known_ = true;
  last_ns_ = stamp_ns;
  outliers_ = 0;
  state_ = {{exact(T_W_M.R), T_W_M.t_mm}, {}, {}};
  const double memory_s = options_.acceleration_memory_s;
  position_.start(noise.position_mm, options_.start_speed_mm_per_s,
                  usual_acceleration(options_.jerk_mm_per_s3, memory_s));
  rotation_.start(noise.rotation_rad, options_.start_angular_speed_rad_per_s,
                  usual_acceleration(options_.angular_jerk_rad_per_s3, memory_s));
}

bool TargetMotion::observe(std::int64_t stamp_ns, const Transform& T_W_M,
                           const std::optional<ObservationNoise>& own_noise) {
  const ObservationNoise noise =
      own_noise.value_or(ObservationNoise{options_.position_noise_mm, options_.rotation_noise_rad});
  if (!is_positive(noise.position_mm) || !is_positive(noise.rotation_rad) || !is_rigid(T_W_M, 1e-6)) {
    return false;
  }
  if (known_ && stamp_ns <= offered_ns_) return false;
  offered_ns_ = stamp_ns;
  const double dt_s = seconds_between(last_ns_, stamp_ns);
  if (!known_ || dt_s > options_.coast_s) {
    start(stamp_ns, T_W_M, noise);
    return true;
  }

  TargetState state = predict(state_, dt_s, options_);
  const Vector3 off_mm = T_W_M.t_mm - state.T_W_M.t_mm;
  const Vector3 off_rad = vector_from_rotation(T_W_M.R * state.T_W_M.R.transpose());
  AxisFilter position = position_;
  AxisFilter rotation = rotation_;
  position.predict(dt_s, options_.acceleration_memory_s, options_.jerk_mm_per_s3);
  rotation.predict(dt_s, options_.acceleration_memory_s, options_.angular_jerk_rad_per_s3);
  const double gate = options_.gate_sigma * options_.gate_sigma;
  if (!(off_mm.squaredNorm() <= gate * position.innovation_variance(noise.position_mm) &&
        off_rad.squaredNorm() <= gate * rotation.innovation_variance(noise.rotation_rad))) {
    if (++outliers_ < options_.restart_after) return false;
    start(stamp_ns, T_W_M, noise);
    return true;
  }

  const AxisFilter::Gains k = position.update(noise.position_mm);
  const AxisFilter::Gains kr = rotation.update(noise.rotation_rad);
  state.T_W_M.t_mm += k.value * off_mm;
  state.T_W_M.R = exact(rotation_from_vector(kr.value * off_rad) * state.T_W_M.R);
  state.velocity.linear_mm_per_s += k.rate_per_s * off_mm;
  state.velocity.angular_rad_per_s += kr.rate_per_s * off_rad;
  state.acceleration.linear_mm_per_s2 += k.acceleration_per_s2 * off_mm;
  state.acceleration.angular_rad_per_s2 += kr.acceleration_per_s2 * off_rad;
  state_ = state;
  position_ = position;
  rotation_ = rotation;
  last_ns_ = stamp_ns;
  outliers_ = 0;
  return true;
}

TargetState TargetMotion::at(std::int64_t t_ns) const {
  return predict(state_, seconds_between(last_ns_, t_ns), options_);
}

}  // namespace vergence
