// Do both cameras give what the controller needs: the pictures asked for, as often as asked for, of the same
// instant, and of colours that stay?
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/v4l2/capture.hpp"
#include "hal/v4l2/controls.hpp"
#include "hal/v4l2/v4l2_config.hpp"
#include "tools/bringup/finding.hpp"
#include "tools/bringup/light_watch.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::tools {

struct SeenFrame {
  std::uint64_t number = 0;  // the driver's, so that a gap is a lost frame
  std::int64_t stamp_ns = 0;
};

using ControlReadings = std::array<v4l2::ControlReading, v4l2::kControlRoles>;

struct EyeObservation {
  bool streamed = false;
  v4l2::VideoError error;  // the last, also one that was recovered from
  v4l2::StreamFormat format;
  v4l2::CaptureCounts counts;  // of the run
  std::vector<SeenFrame> frames;
  ControlReadings first{};  // when the run began, values locked
  ControlReadings last{};
  LightSummary light;
  RgbImage picture;  // of the run's beginning; empty where there was none
};

struct CameraObservation {
  std::array<EyeObservation, 2> eyes;  // left, right
};

[[nodiscard]] std::vector<Finding> judge(const CameraObservation& seen,
                                         const v4l2::StereoVideoConfig& config);

// Of two runs of frames, each rising: for each left frame the nearest right one.
struct Skew {
  std::size_t pairs = 0;
  double median_ms = 0;  // without sign, like the largest
  double largest_ms = 0;
  double drift_us_per_s = 0;  // of left minus right; cameras that run freely drift
};
[[nodiscard]] Skew skew_of(const std::vector<SeenFrame>& left, const std::vector<SeenFrame>& right);

}  // namespace vergence::tools
