#include "algo/motion_predictor.hpp"

namespace vergence {
namespace {

// Share of a new difference in the velocity: a straight mean of the first two, then exponential.
constexpr double kSmoothing = 0.5;
constexpr double kMaxGap_s = 0.5;  // after a longer gap the old velocity means nothing

}  // namespace

void MotionPredictor::forget() {
  *this = MotionPredictor{};
}

void MotionPredictor::observe(double t_s, const Transform& T_W_H, const Transform& T_H_M) {
  const Transform T_W_M = T_W_H * T_H_M;
  const double dt_s = t_s - t_s_;
  if (observations_ > 0 && dt_s > 0 && dt_s <= kMaxGap_s) {
    const Vector3 velocity = (T_W_M.t_mm - T_W_M_.t_mm) / dt_s;
    const Vector3 spin = quaternion_vector_from_rotation(T_W_M.R * T_W_M_.R.transpose()) / dt_s;
    const double share = observations_ == 1 ? 1 : kSmoothing;
    velocity_mm_per_s_ += share * (velocity - velocity_mm_per_s_);
    spin_per_s_ += share * (spin - spin_per_s_);
    ++observations_;
  } else {
    velocity_mm_per_s_.setZero();
    spin_per_s_.setZero();
    observations_ = 1;
  }
  t_s_ = t_s;
  T_W_M_ = T_W_M;
}

Transform MotionPredictor::predict(double t_s, const Transform& T_W_H) const {
  const double gap_s = t_s - t_s_;
  const double dt_s = gap_s > 0 && gap_s <= kMaxGap_s ? gap_s : 0;
  const Transform predicted{rotation_from_quaternion_vector(spin_per_s_ * dt_s) * T_W_M_.R,
                            T_W_M_.t_mm + velocity_mm_per_s_ * dt_s};
  return T_W_H.inverse() * predicted;
}

}  // namespace vergence
