// Whether brightness and hue stay what they are: the method compares hues, so a camera that changes its
// exposure or white balance moves every colour. Looks at a grid of pixels of each frame.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "algo/image.hpp"

namespace vergence::tools {

struct LightSummary {
  std::size_t frames = 0;
  double mean_luma = 0;       // 0 to 255
  double luma_drift = 0;      // last tenth of the frames against the first, as a share of the mean
  double luma_flicker = 0;    // standard deviation from frame to frame, as a share of the mean
  double clipped_share = 0;   // of the pixels, too bright for a hue
  double coloured_share = 0;  // of the pixels, saturated in the first frame
  // Of the coloured pixels, against the same pixel of the first frame:
  double hue_noise_deg = 0;  // circular standard deviation, over pixels and frames
  double hue_drift_deg = 0;  // circular mean over the last tenth of the frames
};

class LightWatch {
 public:
  // All of one size.
  void look(const ImageView& image);
  [[nodiscard]] LightSummary summary() const;

 private:
  struct Frame {
    double luma = 0;
    std::complex<double> turned;  // sum of unit vectors, one a coloured pixel, by how far its hue has turned
    std::size_t coloured = 0;
  };
  std::vector<std::uint8_t> first_;  // hue codes of the grid
  std::vector<Frame> frames_;
  std::size_t clipped_ = 0;
  std::size_t looked_ = 0;
  std::size_t coloured_at_first_ = 0;
};

}  // namespace vergence::tools
