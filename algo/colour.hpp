// Luma and chroma of an RGB pixel: BT.601 full range, in integers that fit 16 bits.
#pragma once

#include <cstdint>

namespace vergence {

struct YCbCr {
  std::uint8_t luma;
  std::uint8_t cb;
  std::uint8_t cr;
};

// Each within 1 of the exact value; chroma is centred on 128.
[[nodiscard]] constexpr YCbCr ycbcr_from_rgb(int r, int g, int b) {
  const int y = (77 * r + 150 * g + 29 * b + 128) >> 8;
  const int cb = ((-43 * r - 85 * g + 128 * b + 127) >> 8) + 128;
  const int cr = ((128 * r - 107 * g - 21 * b + 127) >> 8) + 128;
  return {static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(cb), static_cast<std::uint8_t>(cr)};
}

}  // namespace vergence
