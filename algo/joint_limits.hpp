// How far and how fast a joint may move, and how quickly that may change.
#pragma once

namespace vergence {

struct JointLimits {
  double min_rad = 0;
  double max_rad = 0;
  double velocity_rad_per_s = 0;
  double acceleration_rad_per_s2 = 0;
  double jerk_rad_per_s3 = 0;
};

}  // namespace vergence
