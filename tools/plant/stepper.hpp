// Stepper motors that count pulses. What is issued is exact; whether the rotor went along is another matter,
// and nobody tells the controller: there is no encoder.
//
// The rotor turns as fast as the pulses, as far as its torque lets it change speed; meanwhile it lags. Up to
// half an electrical cycle (two full steps) the field pulls it back in. Farther, it falls back by a whole
// cycle and stalls: steps are lost. Above the pull-out rate it stalls at once.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "algo/eye_mount.hpp"
#include "hal/pan_tilt.hpp"

namespace vergence::plant {

// A point of the torque-speed curve.
struct TorquePoint {
  double rate_steps_per_s = 0;
  double acceleration_steps_per_s2 = 0;
};

struct StepperOptions {
  double steps_per_rad = 16000 / (2 * std::numbers::pi);  // negative: turns the other way
  double steps_per_cycle = 64;                            // electrical: four full steps of 16
  // By rising rate; straight lines between, level beyond the ends.
  std::vector<TorquePoint> torque = {{0, 250e3}, {15e3, 150e3}, {30e3, 50e3}};
  double pull_out_steps_per_s = 30e3;
  double settling_s = 0.005;  // time constant at which the field pulls a lagging rotor back in
};

class Stepper {
 public:
  // The start is rounded to whole steps. Throws std::invalid_argument where a number is outside its range.
  explicit Stepper(const StepperOptions& options, double start_rad = 0);

  // Pulses at a steady rate for dt, which should be short against the changes of the rate: a millisecond.
  void advance(double rate_steps_per_s, double dt_s);
  // Without pulses or current the rotor stays where it is.
  void stop() { rotor_steps_per_s_ = 0; }

  [[nodiscard]] std::int64_t issued_steps() const { return issued_steps_; }
  [[nodiscard]] double true_rad() const;
  [[nodiscard]] double lost_steps() const { return lost_steps_; }  // whole cycles, with sign

 private:
  [[nodiscard]] double torque_steps_per_s2(double rate_steps_per_s) const;
  void pull_in(double dt_s);
  void fall_back();

  StepperOptions options_;
  std::int64_t issued_steps_ = 0;
  double phase_ = 0.5;  // of the next step, in [0, 1): a step comes out midway to it
  double rotor_steps_per_s_ = 0;
  double lag_steps_ = 0;
  double lost_steps_ = 0;
};

struct PanTiltOptions {
  std::array<StepperOptions, kPanTiltMotors> motor{};  // tilt, right pan, left pan
  EyeAngles start;
};

class PanTiltPlant {
 public:
  explicit PanTiltPlant(const PanTiltOptions& options = {});

  void enable(bool on);  // switching off ends a fault
  // Holds until the next one; no number counts as zero. Without effect unless enabled.
  void command(const std::array<double, kPanTiltMotors>& steps_per_s);
  void advance(std::int64_t dt_ns);
  void inject_fault() { state_ = PanTiltState::kFault; }

  [[nodiscard]] PanTiltFeedback feedback(std::int64_t stamp_ns) const;
  [[nodiscard]] EyeAngles true_angles() const;
  [[nodiscard]] const Stepper& motor(int i) const { return motors_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Stepper, kPanTiltMotors> motors_;
  std::array<double, kPanTiltMotors> rate_steps_per_s_{};
  PanTiltState state_ = PanTiltState::kDisabled;
};

}  // namespace vergence::plant
