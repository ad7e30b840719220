// Images to hue planes, as cameras deliver them. Same work for any content, same bytes on any processor.
#pragma once

#include <array>
#include <cstdint>

#include "algo/hue.hpp"
#include "algo/image.hpp"
#include "algo/status.hpp"

namespace vergence {

// Hue of YUV pixels (BT.601, limited range) by look-up: with U and V given, hue and chroma are fixed, and
// whether a pixel is too dark, too grey or too bright depends on Y by three thresholds.
//
// The hue is that of the UNCLIPPED r = 1.164 (Y - 16) + 1.596 (V - 128) and so on, in real numbers: clipping
// to 0..255 would make the hue of bright and dark pixels drift.
class YuvHueTable {
 public:
  void build(const HueLimits& limits);

  // hue | dark below << 8 | undefined above << 16 | bright above << 24, at index 256 U + V: a pixel is dark
  // where Y < dark below, else bright where Y > bright above, else undefined where Y > undefined above, else
  // `hue`.
  [[nodiscard]] const std::uint32_t* entries() const { return entry_.data(); }

  [[nodiscard]] std::uint8_t code(int y, int u, int v) const;

 private:
  alignas(64) std::array<std::uint32_t, 256 * 256> entry_{};
};

// Fills `plane` from an image of any format. `table` serves the YUV formats and must have been built with the
// same limits. kBadImage, and the plane untouched, where the image is empty, beyond the static size, of
// unknown format, of rows that overlap (stride below a row's bytes), or (YUV) of odd width, or (NV12) has no
// chroma plane.
[[nodiscard]] Status make_hue_plane(const ImageView& image, const HueLimits& limits, const YuvHueTable& table,
                                    HuePlane& plane);

}  // namespace vergence
