// Tables of poses: of the hand at each picture, or at each instant.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "algo/pose.hpp"

namespace vergence::calibrate {

// frame,x_mm,y_mm,z_mm,e1,e2,e3: a pose for each number. Throws InputError: no such file, other columns, not
// finite, no unit quaternion, a number twice.
[[nodiscard]] std::map<int, Transform> read_numbered_poses(const std::filesystem::path& file);

struct TimedPose {
  double t_s = 0;
  Transform T;
};

// t_s,x_mm,y_mm,z_mm,e1,e2,e3: by rising time. Throws InputError as above, and where time does not rise.
[[nodiscard]] std::vector<TimedPose> read_timed_poses(const std::filesystem::path& file);

}  // namespace vergence::calibrate
