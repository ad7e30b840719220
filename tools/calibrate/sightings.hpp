// A board seen by both cameras, in every pair of pictures of a folder.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/calibrate/board.hpp"
#include "tools/calibrate/picture_pairs.hpp"

namespace vergence::calibrate {

inline constexpr std::array<const char*, 2> kSides{"left", "right"};

struct Sighting {
  PicturePair pair;
  std::array<Corners, 2> corners;  // left, right
};

struct Sightings {
  int width_px = 0;
  int height_px = 0;
  std::vector<Sighting> seen;  // by rising number
  // Pairs without the whole board in both, as "left/000003.png: the board is not found".
  std::vector<std::string> skipped;
};

// Reads the pictures one by one; `after_pair` is called after each pair. Throws InputError where pictures are
// missing, cannot be read, or differ in size, and where no pair shows the board.
[[nodiscard]] Sightings find_board(
    const std::vector<PicturePair>& pairs, const Board& board,
    const std::function<void()>& after_pair = [] {});

}  // namespace vergence::calibrate
