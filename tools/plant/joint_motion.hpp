// How a joint moves with its motor. It follows its command as a first-order lag, within what its motor can
// do, between hard stops:
//
//   v' = clamp((command - v) / time_constant, +-acceleration) + load
//
// It is integrated exactly, whatever the step.
#pragma once

#include <numbers>

namespace vergence::plant {

struct JointDrive {
  double min_rad = -std::numbers::pi;  // hard stops
  double max_rad = std::numbers::pi;
  double velocity_rad_per_s = 2;  // commands beyond it are clamped
  double acceleration_rad_per_s2 = 20;
  double quick_stop_rad_per_s2 = 20;  // also of the brakes of a joint without torque
  double time_constant_s = 0.020;
  double counts_per_rad = 0x1p20 / (2 * std::numbers::pi);
};

struct JointState {
  double position_rad = 0;
  double velocity_rad_per_s = 0;
};

// First as fast as the motor can, until the loop asks for less; then exponentially.
void follow(const JointDrive& drive, double command_rad_per_s, double load_rad_per_s2, double dt_s,
            JointState& joint);

// To rest, and there it stays: a brake holds any load below its deceleration.
void brake(const JointDrive& drive, double load_rad_per_s2, double dt_s, JointState& joint);

// True where the joint is at a hard stop, which takes what velocity points outward.
[[nodiscard]] bool keep_between_stops(const JointDrive& drive, JointState& joint);

// All numbers positive and finite, the start between the stops.
[[nodiscard]] bool is_usable(const JointDrive& drive, double start_rad);

}  // namespace vergence::plant
