// The two cameras on their pan/tilt mounts [3.6]: where each looks at given motor angles.
#pragma once

#include "algo/pose.hpp"

namespace vergence {

// Angles in rad; zero is the pose of calibration. Positive tilt looks down (+y), positive right pan turns the
// right camera to the left (-x), positive left pan the left camera to the right (+x): towards each other.
struct EyeAngles {
  double tilt_rad = 0;
  double pan_right_rad = 0;
  double pan_left_rad = 0;
};

// Pose of a camera in the hand at the angles, from its pose at zero. The axes meet in the camera's centre;
// the tilt carries the pan.
[[nodiscard]] Transform left_eye_in_hand(const Transform& T_H_C_at_zero, const EyeAngles& angles);
[[nodiscard]] Transform right_eye_in_hand(const Transform& T_H_C_at_zero, const EyeAngles& angles);

}  // namespace vergence
