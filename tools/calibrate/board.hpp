// The chessboard that is photographed: its inner corners, where four squares meet.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "algo/pose.hpp"

namespace vergence::calibrate {

// Board frame B: origin at the first corner, x along a row, y along a column, z away from who looks at it.
// Where columns + rows is odd, the square between the first corners is dark: it tells up from down.
struct Board {
  int columns = 9;
  int rows = 6;
  double square_mm = 25;

  [[nodiscard]] std::size_t corners() const { return static_cast<std::size_t>(columns * rows); }
  // Looks the same after half a turn.
  [[nodiscard]] bool is_symmetric() const { return (columns + rows) % 2 == 0; }
  [[nodiscard]] Vector3 corner_mm(std::size_t index) const {
    const auto i = static_cast<int>(index);
    const int row = i / columns;
    return {square_mm * (i - row * columns), square_mm * row, 0};
  }
  [[nodiscard]] Vector3 centre_mm() const {
    return {0.5 * square_mm * (columns - 1), 0.5 * square_mm * (rows - 1), 0};
  }
};

// Image of a board's corners, row by row, in pixels.
using Corners = std::vector<Vector2>;

// "9x6": inner corners in a row, and in a column; 3 to 40 each. Throws std::invalid_argument.
[[nodiscard]] Board parse_board(const std::string& text, double square_mm);

}  // namespace vergence::calibrate
