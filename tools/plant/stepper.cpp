#include "tools/plant/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "hal/clock.hpp"
#include "tools/plant/decay.hpp"

namespace vergence::plant {
namespace {

bool is_positive(double x) {
  return x > 0 && std::isfinite(x);
}

bool is_usable(const StepperOptions& options) {
  if (!is_positive(std::abs(options.steps_per_rad)) || !is_positive(options.steps_per_cycle) ||
      !is_positive(options.pull_out_steps_per_s) || !is_positive(options.settling_s) ||
      options.torque.empty()) {
    return false;
  }
  for (std::size_t i = 0; i < options.torque.size(); ++i) {
    if (!is_positive(options.torque[i].acceleration_steps_per_s2)) return false;
    if (i > 0 && !(options.torque[i].rate_steps_per_s > options.torque[i - 1].rate_steps_per_s)) return false;
  }
  return true;
}

}  // namespace

Stepper::Stepper(const StepperOptions& options, double start_rad) : options_(options) {
  if (!is_usable(options) || !(std::abs(start_rad * options.steps_per_rad) < 0x1p52)) {
    throw std::invalid_argument("Stepper: options outside their ranges");
  }
  issued_steps_ = std::llround(start_rad * options.steps_per_rad);
}

double Stepper::torque_steps_per_s2(double rate_steps_per_s) const {
  const double rate = std::abs(rate_steps_per_s);
  const auto above = std::find_if(options_.torque.begin(), options_.torque.end(),
                                  [&](const TorquePoint& point) { return point.rate_steps_per_s > rate; });
  if (above == options_.torque.begin()) return above->acceleration_steps_per_s2;
  const TorquePoint& a = *(above - 1);
  if (above == options_.torque.end()) return a.acceleration_steps_per_s2;
  const double part = (rate - a.rate_steps_per_s) / (above->rate_steps_per_s - a.rate_steps_per_s);
  return a.acceleration_steps_per_s2 +
         part * (above->acceleration_steps_per_s2 - a.acceleration_steps_per_s2);
}

void Stepper::advance(double rate_steps_per_s, double dt_s) {
  // No generator makes more; and the count could not hold it for long.
  constexpr double kMostRate = 1e9;
  rate_steps_per_s = std::clamp(rate_steps_per_s, -kMostRate, kMostRate);
  phase_ += rate_steps_per_s * dt_s;
  const double whole = std::floor(phase_);
  phase_ -= whole;
  issued_steps_ += static_cast<std::int64_t>(whole);

  if (std::abs(rate_steps_per_s) > options_.pull_out_steps_per_s) {
    rotor_steps_per_s_ = 0;
    lag_steps_ += rate_steps_per_s * dt_s;
    fall_back();
    return;
  }
  const double behind = rate_steps_per_s - rotor_steps_per_s_;
  const double torque = torque_steps_per_s2(rotor_steps_per_s_);
  const double slewing_s = std::min(dt_s, std::abs(behind) / torque);
  const double change = std::copysign(torque * slewing_s, behind);
  lag_steps_ += (behind - change / 2) * slewing_s;
  rotor_steps_per_s_ = slewing_s < dt_s ? rate_steps_per_s : rotor_steps_per_s_ + change;
  fall_back();
  // Equal where it was set to it, above.
  if (rotor_steps_per_s_ == rate_steps_per_s) pull_in(dt_s - slewing_s);
}

void Stepper::pull_in(double dt_s) {
  lag_steps_ *= decay(dt_s / options_.settling_s);
  // A thousandth of a step is no lag any more: at rest the rotor is where the count says.
  if (std::abs(lag_steps_) < 1e-3) lag_steps_ = 0;
}

void Stepper::fall_back() {
  if (std::abs(lag_steps_) <= options_.steps_per_cycle / 2) return;
  const double fallen = std::nearbyint(lag_steps_ / options_.steps_per_cycle) * options_.steps_per_cycle;
  lag_steps_ -= fallen;
  lost_steps_ += fallen;
  rotor_steps_per_s_ = 0;
}

double Stepper::true_rad() const {
  return (static_cast<double>(issued_steps_) - lost_steps_ - lag_steps_) / options_.steps_per_rad;
}

PanTiltPlant::PanTiltPlant(const PanTiltOptions& options)
    : motors_{Stepper(options.motor[0], options.start.tilt_rad),
              Stepper(options.motor[1], options.start.pan_right_rad),
              Stepper(options.motor[2], options.start.pan_left_rad)} {}

void PanTiltPlant::enable(bool on) {
  if (!on) state_ = PanTiltState::kDisabled;
  if (on && state_ == PanTiltState::kDisabled) {
    state_ = PanTiltState::kEnabled;
    rate_steps_per_s_ = {};
  }
}

void PanTiltPlant::command(const std::array<double, kPanTiltMotors>& steps_per_s) {
  for (std::size_t i = 0; i < steps_per_s.size(); ++i) {
    rate_steps_per_s_[i] = std::isfinite(steps_per_s[i]) ? steps_per_s[i] : 0;
  }
}

void PanTiltPlant::advance(std::int64_t dt_ns) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    if (state_ == PanTiltState::kEnabled) {
      motors_[i].advance(rate_steps_per_s_[i], seconds(dt_ns));
    } else {
      motors_[i].stop();
    }
  }
}

PanTiltFeedback PanTiltPlant::feedback(std::int64_t stamp_ns) const {
  return {
      stamp_ns, {motors_[0].issued_steps(), motors_[1].issued_steps(), motors_[2].issued_steps()}, state_};
}

EyeAngles PanTiltPlant::true_angles() const {
  return {motors_[0].true_rad(), motors_[1].true_rad(), motors_[2].true_rad()};
}

}  // namespace vergence::plant
