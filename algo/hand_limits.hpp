// Limits of the hand's motion in space: speed and acceleration, a box the tool stays in, and a least distance
// to the target. The twist is scaled by one factor, so that the direction asked for is kept; at a wall the
// part into it shrinks to zero, and the part along it stays. Why the tool cannot leave the box:
// docs/motion_limits.md.
#pragma once

#include <optional>

#include "algo/motion_limits.hpp"
#include "algo/pose.hpp"

namespace vergence {

// Of the tool's point, in the axes of the world.
struct Twist {
  Vector3 linear_mm_per_s = Vector3::Zero();
  Vector3 angular_rad_per_s = Vector3::Zero();
};

struct HandLimits {
  double linear_velocity_mm_per_s = 0;
  double angular_velocity_rad_per_s = 0;
  double linear_acceleration_mm_per_s2 = 0;
  double angular_acceleration_rad_per_s2 = 0;
  Vector3 box_min_mm = Vector3::Zero();  // of the tool's point, in the world
  Vector3 box_max_mm = Vector3::Zero();
  double least_distance_mm = 0;  // of the tool's point to the target; 0: none
};

struct LimitedTwist {
  Twist twist;  // to be held for the coming period
  LimitFlags flags = 0;
};

// kOk, or kBadLimits: not finite, a limit that is not positive, an empty box, a negative distance.
[[nodiscard]] Status check(const HandLimits& limits, double period_s);

// The twist of the coming period. `tool_mm` is where the tool's point is, `last` the twist it has; a target,
// where there is one, is taken to stand still for as long as braking lasts.
[[nodiscard]] LimitedTwist limit_twist(const HandLimits& limits, double period_s, const Vector3& tool_mm,
                                       const Twist& last, const Twist& desired,
                                       const std::optional<Vector3>& target_mm);

}  // namespace vergence
