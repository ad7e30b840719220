// From a pair of pictures to a sighting of the target in the world.
#pragma once

#include <cstdint>

#include "algo/tracker.hpp"
#include "firmware_like/messages.hpp"
#include "firmware_like/robot_config.hpp"
#include "hal/stereo_camera.hpp"

namespace vergence {

// Holds the tracker: tens of megabytes, to be placed statically.
class VisionTask {
 public:
  [[nodiscard]] Status configure(const RobotConfig& config, const MarkerModel& model);
  [[nodiscard]] Status configure(const RobotConfig& config, const PhotoModel& model);

  // True where the frame led to a sighting. False: it is older than what is known of the hand and the eyes,
  // or its pictures are not the rig's; such frames are counted.
  [[nodiscard]] bool step(const StereoFrame& frame, const HandHistory& hand, const EyeHistory& eyes,
                          Sighting& sighting);

  [[nodiscard]] const Tracker& tracker() const { return tracker_; }
  [[nodiscard]] std::uint64_t frames_left_out() const { return left_out_; }

 private:
  void keep(const RobotConfig& config);

  RobotConfig config_;
  Tracker tracker_;
  std::uint64_t left_out_ = 0;
};

}  // namespace vergence
