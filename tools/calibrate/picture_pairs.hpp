// Which pictures of a folder belong together.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace vergence::calibrate {

struct PicturePair {
  int number = 0;
  std::array<std::filesystem::path, 2> files;  // left, right
};

// By rising number: left/000000.png with right/000000.png, or left01.jpg with right01.jpg in the folder
// itself; PNG or JPEG. Throws InputError where there are none, or one of a pair is missing.
[[nodiscard]] std::vector<PicturePair> list_pairs(const std::filesystem::path& directory);

}  // namespace vergence::calibrate
