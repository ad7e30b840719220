#include "tools/bringup/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vergence::tools {
namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

std::array<std::uint8_t, 3> of_yuv(int y, int u, int v) {
  const double cb = u - 128;
  const double cr = v - 128;
  return {to_byte(y + 1.402 * cr), to_byte(y - 0.344136 * cb - 0.714136 * cr), to_byte(y + 1.772 * cb)};
}

}  // namespace

std::array<std::uint8_t, 3> rgb_at(const ImageView& image, int x, int y) {
  const std::uint8_t* row = image.data + static_cast<std::size_t>(y) * image.stride_bytes;
  // Two pixels side by side share their chroma.
  const std::uint8_t* pair = row + std::ptrdiff_t{4} * (x / 2);
  const int odd = x & 1;
  switch (image.format) {
    case PixelFormat::kRgb24: return {row[3 * x], row[3 * x + 1], row[3 * x + 2]};
    case PixelFormat::kYuyv: return of_yuv(pair[2 * odd], pair[1], pair[3]);
    case PixelFormat::kUyvy: return of_yuv(pair[2 * odd + 1], pair[0], pair[2]);
    case PixelFormat::kNv12: break;
  }
  const std::uint8_t* chroma = image.chroma + static_cast<std::size_t>(y / 2) * image.chroma_stride_bytes;
  return of_yuv(row[x], chroma[x & ~1], chroma[x | 1]);
}

RgbImage rgb_of(const ImageView& image) {
  RgbImage picture(image.width_px, image.height_px);
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const auto rgb = rgb_at(image, x, y);
      std::copy(rgb.begin(), rgb.end(), picture.at(x, y));
    }
  }
  return picture;
}

}  // namespace vergence::tools
