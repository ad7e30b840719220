// A camera's frame in colour, as people see it.
#pragma once

#include <array>
#include <cstdint>

#include "algo/image.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::tools {

// Red, green, blue of a pixel; of YUV by BT.601 in full range, as the vision core takes it.
[[nodiscard]] std::array<std::uint8_t, 3> rgb_at(const ImageView& image, int x, int y);
[[nodiscard]] RgbImage rgb_of(const ImageView& image);

}  // namespace vergence::tools
