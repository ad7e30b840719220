// The kernel's pixel formats and which of them the vision core reads.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "algo/image.hpp"

namespace vergence::v4l2 {

struct KnownFormat {
  std::uint32_t fourcc = 0;
  PixelFormat format = PixelFormat::kYuyv;
  int planes = 1;            // pieces of memory
  int row_bytes_per_px = 2;  // of the first plane
};

// Nothing where the vision core cannot read it; refusal() has the reason.
[[nodiscard]] std::optional<KnownFormat> known_format(std::uint32_t fourcc);

// Why a format cannot be used, in words; null where it can.
[[nodiscard]] const char* refusal(std::uint32_t fourcc);

// Its four letters, ended by a zero; what is no letter is a '?'.
[[nodiscard]] std::array<char, 5> spell(std::uint32_t fourcc);

}  // namespace vergence::v4l2
