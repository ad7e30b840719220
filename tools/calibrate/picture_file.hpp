// Pictures for calibration, PNG or JPEG, as grey levels.
//
// JPEG by libjpeg: OpenCV's own reader pulls in a hundred libraries, which every start of `vergence` would
// wait for.
#pragma once

#include <filesystem>

#include "tools/io/image_file.hpp"

namespace vergence::calibrate {

// By the name's ending: .png, .jpg, .jpeg, in any case.
[[nodiscard]] bool is_picture(const std::filesystem::path& file);

// Throws InputError where the file is missing, damaged, or no picture of that kind.
[[nodiscard]] tools::GreyImage read_picture(const std::filesystem::path& file);

}  // namespace vergence::calibrate
