// The corners of a chessboard in a picture, to a fraction of a pixel, in an order that is the same in every
// picture.
#pragma once

#include <optional>

#include "tools/calibrate/board.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::calibrate {

// All of the board's corners, or nothing. A symmetric board does not tell which corner is the first: then the
// rows run as near to `row_direction` (in the image) as they can.
[[nodiscard]] std::optional<Corners> find_corners(const tools::GreyImage& image, const Board& board,
                                                  const Vector2& row_direction = {1, 0});

// From the first corner of the first row to its last.
[[nodiscard]] Vector2 row_direction(const Corners& corners, const Board& board);

}  // namespace vergence::calibrate
