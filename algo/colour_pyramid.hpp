// An image as luma and chroma at full, half, quarter and eighth resolution: what correlation and refinement
// read.
#pragma once

#include <array>
#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/image.hpp"
#include "algo/limits.hpp"
#include "algo/status.hpp"

namespace vergence {

inline constexpr int kColourLevels = 4;

// A packed pixel: luma, cb, cr, 0 from the least significant byte.
using ColourPixel = std::uint32_t;
inline constexpr ColourPixel kNeutralPixel = 0x00808080;

// Rows packed. The pixel after the last is neutral: samples that fall beside the image are pointed there.
template <int kPixels>
struct ColourPlane {
  int width_px = 0;
  int height_px = 0;
  alignas(64) std::array<ColourPixel, kPixels + 64> pixel{};
};

struct ColourPyramid {
  ColourPlane<kMaxImagePixels> full;
  ColourPlane<kMaxImagePixels / 4> half;
  ColourPlane<kMaxImagePixels / 16> quarter;
  ColourPlane<kMaxImagePixels / 64> eighth;
};

// One level of a pyramid, to read.
struct ColourLevel {
  const ColourPixel* pixel = nullptr;
  int width_px = 0;
  int height_px = 0;

  [[nodiscard]] std::int32_t outside_index() const { return width_px * height_px; }
};

[[nodiscard]] ColourLevel level_of(const ColourPyramid& pyramid, int level);  // 0 full .. 3 eighth

// The camera that would have taken a level: a level-L pixel is the mean of 2^L x 2^L pixels.
[[nodiscard]] CameraModel camera_at_level(const CameraModel& camera, int level);

// The full level alone, and its bytes as the camera delivers them: r g b, or luma cb cr of limited range. All
// that a marker needs. Errors as below.
[[nodiscard]] Status make_raw_colour(const ImageView& image, ColourPyramid& pyramid);

// Each level is the rounded mean of four pixels of the one before; an odd last row or column is left out.
// YUV images are taken as they are (limited range): correlation does not mind gain and offset.
// kBadImage where the size is beyond the static limits, below 4 x 4, or (YUV) odd.
[[nodiscard]] Status make_colour_pyramid(const ImageView& image, ColourPyramid& pyramid);

}  // namespace vergence
