// How a joint goes that is moved by hand, its drive off: sines about where it started, as many as are told
// of.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "tools/plant/arm_servo.hpp"

namespace vergence::rig {

struct Sway {
  std::size_t joint = 0;
  double amplitude_rad = 0;
  double omega_rad_s = 0;
};

// Of that joint, so long after the start.
[[nodiscard]] inline plant::JointState swayed(std::span<const Sway> sways, std::size_t joint,
                                              double start_rad, double t_s) {
  plant::JointState state{start_rad, 0};
  for (const Sway& sway : sways) {
    if (sway.joint != joint) continue;
    state.position_rad += sway.amplitude_rad * std::sin(sway.omega_rad_s * t_s);
    state.velocity_rad_per_s += sway.amplitude_rad * sway.omega_rad_s * std::cos(sway.omega_rad_s * t_s);
  }
  return state;
}

}  // namespace vergence::rig
