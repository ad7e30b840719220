// Where a body is at a time: the motions of the experiments.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "algo/pose.hpp"

namespace vergence::render {

struct PoseKey {
  double t_s = 0;
  Pose pose;
  bool teleport = false;  // jumps here at t_s instead of travelling
};

struct Motion {
  enum class Kind {
    kStill,
    kSine,    // pose + amplitude * sin(omega t + phase), per component
    kCosine,  // pose + amplitude * (1 - cos(omega t)): starts at rest
    kSwing,   // on a turntable about the vertical through `pivot`: a triangle wave of the angle
    kKeys,    // through key poses, in straight lines
    kRandom,  // every frame elsewhere: pose +- amplitude
  };
  Kind kind = Kind::kStill;
  Pose pose;
  std::array<double, 6> amplitude{};  // mm, and of e
  double omega_rad_s = 0.628;
  double phase_rad = 0;
  double swing_rad = 0;
  double swing_rad_s = 0;
  Vector3 pivot_mm = Vector3::Zero();
  std::vector<PoseKey> keys;  // by rising time
  double fps = 30;            // random: frames a second
  std::uint64_t seed = 1;
  bool in_view = false;                      // random: drawn again until `accepts`
  std::function<bool(const Pose&)> accepts;  // empty: any pose

  [[nodiscard]] Pose at(double t_s) const;
};

// The path of Table 6.1: twenty key poses relative to `centre`, at 50 mm/s and 10 deg/s, resting `rest_s` at
// each.
[[nodiscard]] std::vector<PoseKey> twenty_steps(const Pose& centre, double rest_s);

}  // namespace vergence::render
