// A pose over time, between the instants it was measured at.
#pragma once

#include <optional>
#include <vector>

#include "tools/calibrate/hand_poses.hpp"

namespace vergence::calibrate {

class PoseTrack {
 public:
  // By rising time; two poses at least.
  explicit PoseTrack(std::vector<TimedPose> poses);

  // Cubic between the neighbours. Nothing before the first pose, after the last, and in gaps longer than
  // kLongestGap_s.
  [[nodiscard]] std::optional<Transform> at(double t_s) const;

  [[nodiscard]] double first_s() const { return poses_.front().t_s; }
  [[nodiscard]] double last_s() const { return poses_.back().t_s; }

  static constexpr double kLongestGap_s = 0.1;

 private:
  std::vector<TimedPose> poses_;
};

}  // namespace vergence::calibrate
