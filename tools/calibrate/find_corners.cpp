#include "tools/calibrate/find_corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace vergence::calibrate {
namespace {

std::size_t at(const Board& board, int column, int row) {
  return static_cast<std::size_t>(row * board.columns + column);
}

// The corners in another order: from(column, row) names the old column and row.
template <class From>
Corners reordered(const Corners& corners, const Board& board, From&& from) {
  Corners result;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const auto [old_column, old_row] = from(column, row);
      result.push_back(corners[at(board, old_column, old_row)]);
    }
  }
  return result;
}

Corners half_turn(const Corners& corners) {
  return {corners.rbegin(), corners.rend()};
}

Corners quarter_turn(const Corners& corners, const Board& square_board) {
  return reordered(corners, square_board, [&](int column, int row) {
    return std::pair{row, square_board.rows - 1 - column};
  });
}

// Least distance between neighbours, in pixels.
double spacing(const Corners& corners, const Board& board) {
  double least = HUGE_VAL;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const Vector2& here = corners[at(board, column, row)];
      if (column > 0) least = std::min(least, (here - corners[at(board, column - 1, row)]).norm());
      if (row > 0) least = std::min(least, (here - corners[at(board, column, row - 1)]).norm());
    }
  }
  return least;
}

// Level of a square's middle; of 3 x 3 pixels.
double level(const tools::GreyImage& image, const Vector2& centre) {
  int sum = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = std::clamp(static_cast<int>(std::lround(centre.x())) + dx, 0, image.width_px - 1);
      const int y = std::clamp(static_cast<int>(std::lround(centre.y())) + dy, 0, image.height_px - 1);
      sum += image.data[static_cast<std::size_t>(y * image.width_px + x)];
    }
  }
  return sum / 9.0;
}

// Whether the square between the first corners is dark.
bool starts_dark(const tools::GreyImage& image, const Corners& corners, const Board& board) {
  double difference = 0;  // of squares like the first minus the others
  for (int row = 0; row + 1 < board.rows; ++row) {
    for (int column = 0; column + 1 < board.columns; ++column) {
      const Vector2 centre =
          0.25 * (corners[at(board, column, row)] + corners[at(board, column + 1, row)] +
                  corners[at(board, column, row + 1)] + corners[at(board, column + 1, row + 1)]);
      difference += ((row + column) % 2 == 0 ? 1 : -1) * level(image, centre);
    }
  }
  return difference < 0;
}

Corners in_order(const tools::GreyImage& image, Corners corners, const Board& board,
                 const Vector2& direction) {
  const Vector2 along = row_direction(corners, board);
  const Vector2 down = corners[at(board, 0, board.rows - 1)] - corners.front();
  if (along.x() * down.y() - along.y() * down.x() < 0) {  // seen from behind: a row is read backwards
    corners = reordered(corners, board, [&](int column, int row) {
      return std::pair{board.columns - 1 - column, row};
    });
  }
  if (!board.is_symmetric()) return starts_dark(image, corners, board) ? corners : half_turn(corners);
  std::vector<Corners> orders{corners, half_turn(corners)};
  if (board.columns == board.rows) {
    orders.push_back(quarter_turn(corners, board));
    orders.push_back(half_turn(orders.back()));
  }
  const auto along_wanted = [&](const Corners& order) {
    return row_direction(order, board).normalized().dot(direction);
  };
  return *std::max_element(orders.begin(), orders.end(), [&](const Corners& a, const Corners& b) {
    return along_wanted(a) < along_wanted(b);
  });
}

std::vector<cv::Point2f> detect(const cv::Mat& grey, const cv::Size& size) {
  std::vector<cv::Point2f> points;
  // Without a board the fast check says so in a tenth of the time; what it misses the second finds.
  if (cv::findChessboardCorners(
          grey, size, points,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
    return points;
  if (cv::findChessboardCornersSB(grey, size, points, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY))
    return points;
  return {};
}

}  // namespace

Vector2 row_direction(const Corners& corners, const Board& board) {
  return corners[at(board, board.columns - 1, 0)] - corners.front();
}

std::optional<Corners> find_corners(const tools::GreyImage& image, const Board& board,
                                    const Vector2& direction) {
  const cv::Mat grey(image.height_px, image.width_px, CV_8U, const_cast<std::uint8_t*>(image.data.data()));
  std::vector<cv::Point2f> points = detect(grey, {board.columns, board.rows});
  if (points.size() != board.corners()) return {};
  const auto as_corners = [&] {
    Corners corners;
    for (const cv::Point2f& point : points) corners.emplace_back(point.x, point.y);
    return corners;
  };
  // The window must not reach the neighbours; beyond ten pixels it gathers the lens's curvature and no more
  // corner.
  const double room_px = spacing(as_corners(), board);
  const int half_window = std::clamp(static_cast<int>(0.4 * room_px), 2, 10);
  cv::cornerSubPix(grey, points, {half_window, half_window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-4});
  return in_order(image, as_corners(), board, direction);
}

}  // namespace vergence::calibrate
