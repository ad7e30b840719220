#include "tools/plant/state_history.hpp"

#include <algorithm>
#include <stdexcept>

namespace vergence::plant {
namespace {

Transform between(const Transform& a, const Transform& b, double part) {
  // Small turns: the quaternion's vector part grows in proportion to the angle.
  const Vector3 e = quaternion_vector_from_rotation(a.R.transpose() * b.R);
  return {a.R * rotation_from_quaternion_vector(part * e), a.t_mm + part * (b.t_mm - a.t_mm)};
}

double between(double a, double b, double part) {
  return a + part * (b - a);
}

}  // namespace

StateHistory::StateHistory(std::int64_t interval_ns, std::size_t capacity)
    : interval_ns_(interval_ns), ring_(capacity) {
  if (interval_ns <= 0 || capacity < 2) throw std::invalid_argument("StateHistory: no interval or no room");
}

void StateHistory::push(const HeadState& state) {
  ring_[static_cast<std::size_t>(pushed_) % ring_.size()] = state;
  ++pushed_;
}

HeadState StateHistory::at(std::int64_t t_ns) const {
  t_ns = std::max<std::int64_t>(t_ns, 0);
  const std::int64_t index = t_ns / interval_ns_;
  const std::int64_t rest_ns = t_ns % interval_ns_;
  const std::int64_t oldest = pushed_ - static_cast<std::int64_t>(ring_.size());
  if (index < oldest || index + (rest_ns > 0 ? 1 : 0) >= pushed_) {
    throw std::out_of_range("StateHistory: time not in the history");
  }
  const HeadState& a = ring_[static_cast<std::size_t>(index) % ring_.size()];
  if (rest_ns == 0) return a;
  const HeadState& b = ring_[static_cast<std::size_t>(index + 1) % ring_.size()];
  const double part = static_cast<double>(rest_ns) / static_cast<double>(interval_ns_);
  return {between(a.T_W_H, b.T_W_H, part),
          {between(a.eyes.tilt_rad, b.eyes.tilt_rad, part),
           between(a.eyes.pan_right_rad, b.eyes.pan_right_rad, part),
           between(a.eyes.pan_left_rad, b.eyes.pan_left_rad, part)}};
}

}  // namespace vergence::plant
