#include "tools/calibrate/board.hpp"

#include <charconv>
#include <stdexcept>

namespace vergence::calibrate {

Board parse_board(const std::string& text, double square_mm) {
  constexpr int kFewest = 3;
  constexpr int kMost = 40;
  Board board;
  board.square_mm = square_mm;
  const char* const end = text.data() + text.size();
  const auto [x, first_error] = std::from_chars(text.data(), end, board.columns);
  bool good = first_error == std::errc{} && x != end && *x == 'x';
  if (good) {
    const auto [rest, second_error] = std::from_chars(x + 1, end, board.rows);
    good = second_error == std::errc{} && rest == end;
  }
  const auto possible = [](int n) { return n >= kFewest && n <= kMost; };
  if (!good || !possible(board.columns) || !possible(board.rows)) {
    throw std::invalid_argument("'" + text +
                                "' is not COLSxROWS: count the inner corners, where four squares meet, as in "
                                "9x6; 3 to 40 each");
  }
  return board;
}

}  // namespace vergence::calibrate
