// Agrees with a driver on what it will send, and reads back what it really gave.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algo/image.hpp"
#include "hal/v4l2/v4l2_config.hpp"
#include "hal/v4l2/video_device.hpp"
#include "hal/v4l2/video_error.hpp"

namespace vergence::v4l2 {

struct StreamFormat {
  bool multi_planar = false;
  std::uint32_t fourcc = 0;
  PixelFormat format = PixelFormat::kYuyv;
  int width_px = 0;
  int height_px = 0;
  int planes = 1;
  std::array<std::size_t, kMaxVideoPlanes> stride_bytes{};  // as the driver gave it
  std::array<std::size_t, kMaxVideoPlanes> image_bytes{};   // that the driver wants for a plane
  std::array<std::size_t, kMaxVideoPlanes>
      needed_bytes{};            // that a whole image has, last row without padding
  std::int64_t interval_ns = 0;  // 0: the driver does not say
};

// The configuration's own ranges, before any device is asked.
[[nodiscard]] VideoError check(const VideoConfig& config);

// Input, timings, format and interval, in this order. `got` is complete where there is no error.
[[nodiscard]] VideoError negotiate(VideoSystem& system, int handle, const VideoConfig& config,
                                   StreamFormat& got);

}  // namespace vergence::v4l2
