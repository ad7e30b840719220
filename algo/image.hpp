// A view of a camera's frame in memory that somebody else owns.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vergence {

enum class PixelFormat : std::uint8_t {
  kRgb24,  // r g b
  kYuyv,   // y0 u y1 v
  kUyvy,   // u y0 v y1
  kNv12,   // plane of y, then a half-size plane of u v pairs
};

struct ImageView {
  const std::uint8_t* data = nullptr;
  int width_px = 0;
  int height_px = 0;
  std::size_t stride_bytes = 0;  // of a row
  PixelFormat format = PixelFormat::kRgb24;
  const std::uint8_t* chroma = nullptr;  // NV12 only: the u v plane
  std::size_t chroma_stride_bytes = 0;
};

}  // namespace vergence
