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

// Distance of a corner to its nearest neighbour, in pixels.
double room_px(const std::vector<cv::Point2f>& points, const Board& board, int column, int row) {
  const cv::Point2f& here = points[at(board, column, row)];
  double least = HUGE_VAL;
  const auto look = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= board.columns || y >= board.rows) return;
    least = std::min(least, cv::norm(points[at(board, x, y)] - here));
  };
  look(column - 1, row);
  look(column + 1, row);
  look(column, row - 1);
  look(column, row + 1);
  return least;
}

// Each corner in a window of its own size: as large as it may be without reaching another edge (more pixels,
// less noise), and no larger than the edges are straight.
void refine(const cv::Mat& grey, const Board& board, std::vector<cv::Point2f>& points) {
  constexpr double kShare = 0.3;
  constexpr int kLargest = 10;
  const std::vector<cv::Point2f> found = points;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const int half = std::clamp(static_cast<int>(kShare * room_px(found, board, column, row)), 2, kLargest);
      std::vector<cv::Point2f> one{points[at(board, column, row)]};
      cv::cornerSubPix(grey, one, {half, half}, {-1, -1},
                       {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-4});
      points[at(board, column, row)] = one[0];
    }
  }
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
  // cornerSubPix takes slopes from neighbouring pixels, which sharp edges fool: blurred ones halve its error.
  constexpr double kBlur_px = 1.5;
  cv::Mat soft;
  cv::GaussianBlur(grey, soft, {}, kBlur_px);
  refine(soft, board, points);
  Corners corners;
  for (const cv::Point2f& point : points) corners.emplace_back(point.x, point.y);
  return in_order(image, std::move(corners), board, direction);
}

}  // namespace vergence::calibrate
