// Pictures as cameras give them: YUYV, BT.601, luma 16 to 235, one colour for two pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/io/image_file.hpp"

namespace vergence::rig {

// Two bytes a pixel, rows packed; the width is even.
void to_yuyv(const tools::RgbImage& image, std::vector<std::uint8_t>& yuyv);

}  // namespace vergence::rig
