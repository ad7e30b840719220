#include "tools/rig/yuyv.hpp"

namespace vergence::rig {
namespace {

constexpr int kHalf = 1 << 15;  // rounds; factors are in 1/65536

std::uint8_t luma(const std::uint8_t* rgb) {
  return static_cast<std::uint8_t>(16 + ((16829 * rgb[0] + 33039 * rgb[1] + 6416 * rgb[2] + kHalf) >> 16));
}

}  // namespace

void to_yuyv(const tools::RgbImage& image, std::vector<std::uint8_t>& yuyv) {
  const std::size_t pairs = image.data.size() / 6;
  yuyv.resize(pairs * 4);
  for (std::size_t i = 0; i < pairs; ++i) {
    const std::uint8_t* rgb = &image.data[i * 6];
    // Sums of two pixels: factors are halved.
    const int r = rgb[0] + rgb[3];
    const int g = rgb[1] + rgb[4];
    const int b = rgb[2] + rgb[5];
    yuyv[i * 4] = luma(rgb);
    yuyv[i * 4 + 1] = static_cast<std::uint8_t>(128 + ((-4857 * r - 9535 * g + 14392 * b + kHalf) >> 16));
    yuyv[i * 4 + 2] = luma(rgb + 3);
    yuyv[i * 4 + 3] = static_cast<std::uint8_t>(128 + ((14392 * r - 12051 * g - 2341 * b + kHalf) >> 16));
  }
}

}  // namespace vergence::rig
