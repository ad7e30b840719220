// How late or early the cameras' stamps are against those of the hand, from a target that stands still while
// the hand moves: with the right offset its pose in the world does not move.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/calibrate/hand_poses.hpp"

namespace vergence::calibrate {

// Where the tables came from, for complaints.
struct TimeOffsetFiles {
  std::filesystem::path frames;
  std::filesystem::path hand;
};

struct TimeOffset {
  double offset_ms = 0;       // to be added to the cameras' stamps
  double half_width_ms = 0;   // of the 95 % confidence interval
  std::size_t frames = 0;     // used
  std::size_t left_out = 0;   // beside the hand's table, or far off
  double speed_mm_per_s = 0;  // of the target in the hand, RMS
  double speed_deg_per_s = 0;
  double before_mm = 0;  // RMS wandering of the target in the world without the offset, and with it
  double before_deg = 0;
  double after_mm = 0;
  double after_deg = 0;
};

inline constexpr double kWidestInterval_ms = 1;  // half of it; wider: refused
inline constexpr std::size_t kFewestFrames = 30;

// `T_H_M` at the cameras' stamps, `T_W_H` at those of the hand; offsets up to `range_ms` either way are
// looked at. Throws InputError where the tables hardly overlap, where the motion is too slow or repeats
// itself, and where the offset is beyond the range.
[[nodiscard]] TimeOffset find_time_offset(const TimeOffsetFiles& files, const std::vector<TimedPose>& T_H_M,
                                          const std::vector<TimedPose>& T_W_H, double range_ms);

}  // namespace vergence::calibrate
