#include "tests/support/chessboard.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "algo/rotation_vector.hpp"
#include "tools/calibrate/stereo_fit.hpp"

namespace vergence::test {
namespace {

using calibrate::Board;
using tools::GreyImage;

constexpr double kDark = 30;
constexpr double kLight = 220;
constexpr double kBehind = 120;

// A square of the board's plane; squares of the pattern and of its white rim have their own.
struct Square {
  int column;
  int row;
  bool operator==(const Square&) const = default;
};

Square square_at(const Vector2& p_mm, const Board& board) {
  return {static_cast<int>(std::floor(p_mm.x() / board.square_mm)),
          static_cast<int>(std::floor(p_mm.y() / board.square_mm))};
}

double level_of(const Square& square, const Board& board) {
  const auto within = [&](int rim) {
    return square.column >= -1 - rim && square.column < board.columns + rim && square.row >= -1 - rim &&
           square.row < board.rows + rim;
  };
  if (!within(1)) return kBehind;
  if (!within(0)) return kLight;
  return (square.column + square.row) % 2 == 0 ? kDark : kLight;
}

// Mean level over the tent, from the board's points at the pixel and its eight neighbours.
double tent_level(const std::array<Vector2, 9>& points, const Board& board) {
  constexpr int kSamples = 8;  // a pixel's width
  double sum = 0;
  double weights = 0;
  for (int j = 0; j < 2 * kSamples; ++j) {
    for (int i = 0; i < 2 * kSamples; ++i) {
      const double x = (i + 0.5) / kSamples - 1;
      const double y = (j + 0.5) / kSamples - 1;
      const std::size_t first = (y < 0 ? 0 : 3) + (x < 0 ? 0 : 1);
      const double a = x < 0 ? x + 1 : x;
      const double b = y < 0 ? y + 1 : y;
      const Vector2 p = (1 - b) * ((1 - a) * points[first] + a * points[first + 1]) +
                        b * ((1 - a) * points[first + 3] + a * points[first + 4]);
      const double weight = (1 - std::abs(x)) * (1 - std::abs(y));
      sum += weight * level_of(square_at(p, board), board);
      weights += weight;
    }
  }
  return sum / weights;
}

}  // namespace

double normal(testing::Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.between(0, 1);
  return sum;
}

Vector3 normal3(testing::Random& random) {
  const double x = normal(random);
  const double y = normal(random);
  return {x, y, normal(random)};
}

Matrix3 turn_deg(double degrees, const Vector3& axis) {
  return rotation_from_vector(degrees * std::numbers::pi / 180 * axis.normalized());
}

ChessboardPainter::ChessboardPainter(const CameraModel& camera) : camera_(camera) {
  for (int y = -1; y <= camera.height_px; ++y) {
    for (int x = -1; x <= camera.width_px; ++x) rays_.push_back(calibrate::ray(camera, {x, y}));
  }
}

std::size_t ChessboardPainter::lattice(int x, int y) const {
  return static_cast<std::size_t>((y + 1) * (camera_.width_px + 2) + x + 1);
}

GreyImage ChessboardPainter::paint(const Transform& T_C_B, const Board& board, double noise,
                                   std::uint64_t seed) const {
  // The board's plane, seen along every ray. Rays that meet it behind the camera see far beyond its rim.
  const Transform T_B_C = T_C_B.inverse();
  std::vector<Vector2> points;
  for (const Vector3& ray : rays_) {
    const Vector3 d = T_B_C.R * ray;
    const double depth = -T_B_C.t_mm.z() / d.z();
    const Vector3 p = T_B_C.t_mm + depth * d;
    points.push_back(depth > 0 ? Vector2(p.head<2>()) : Vector2(1e6, 1e6));
  }
  GreyImage image{camera_.width_px, camera_.height_px, {}};
  testing::Random random(seed);
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      std::array<Vector2, 9> around;
      for (int k = 0; k < 9; ++k)
        around[static_cast<std::size_t>(k)] = points[lattice(x + k % 3 - 1, y + k / 3 - 1)];
      const Square middle = square_at(around[4], board);
      const bool flat = std::all_of(around.begin(), around.end(),
                                    [&](const Vector2& p) { return square_at(p, board) == middle; });
      const double level = flat ? level_of(middle, board) : tent_level(around, board);
      const double noisy = noise > 0 ? level + noise * normal(random) : level;
      image.data.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(noisy, 0.0, 255.0))));
    }
  }
  return image;
}

StereoRig true_rig() {
  StereoRig rig;
  rig.left = {640, 480, 702.5, 700.1, 322.3, 236.8, {-0.21, 0.11, 0.0008, -0.0006, 0}, {}};
  rig.right = {640, 480, 695.8, 694.2, 315.6, 243.1, {-0.19, 0.08, -0.0005, 0.0009, 0}, {}};
  rig.left.T_H_C = {turn_deg(5.2, {0.05, 1, 0.03}), {-50.3, -99.2, 21.0}};
  rig.right.T_H_C = {turn_deg(-4.6, {-0.04, 1, 0.06}), {49.9, -100.7, 19.5}};
  return rig;
}

bool sees_board(const CameraModel& camera, const Transform& T_H_B, const Board& board) {
  constexpr double kMargin_px = 3;
  const Transform T_C_B = camera.T_H_C.inverse() * T_H_B;
  for (const double column : {-1.5, 0.5 * board.columns, board.columns + 0.5}) {
    for (const double row : {-1.5, 0.5 * board.rows, board.rows + 0.5}) {
      Vector2 uv;
      if (!project(camera, T_C_B * Vector3(board.square_mm * column, board.square_mm * row, 0), uv))
        return false;
      if (uv.x() < kMargin_px || uv.x() > camera.width_px - 1 - kMargin_px || uv.y() < kMargin_px ||
          uv.y() > camera.height_px - 1 - kMargin_px)
        return false;
    }
  }
  return true;
}

std::vector<Transform> board_poses(const StereoRig& rig, const Board& board, int count, std::uint64_t seed) {
  std::vector<Transform> poses;
  testing::Random random(seed);
  while (static_cast<int>(poses.size()) < count) {
    const double direction = random.between(0, 2 * std::numbers::pi);
    const Vector3 axis{std::cos(direction), std::sin(direction), 0};
    const double tilt = random.between(15, 40);
    const Matrix3 roll = turn_deg(random.between(-25, 25), {0, 0, 1});
    const double x = random.between(-160, 160);
    const double y = random.between(-120, 120);
    const Vector3 centre{x, y - 100, random.between(400, 800)};
    Transform T_H_B{turn_deg(tilt, axis) * roll, {}};
    T_H_B.t_mm = centre - T_H_B.R * board.centre_mm();
    if (sees_board(rig.left, T_H_B, board) && sees_board(rig.right, T_H_B, board)) poses.push_back(T_H_B);
  }
  return poses;
}

void write_board_pictures(const std::filesystem::path& directory, const StereoRig& rig,
                          const std::vector<Transform>& T_H_B, const Board& board, double noise,
                          std::uint64_t seed) {
  for (const bool left : {true, false}) {
    const CameraModel& camera = left ? rig.left : rig.right;
    const ChessboardPainter painter(camera);
    const std::filesystem::path folder = directory / (left ? "left" : "right");
    std::filesystem::create_directories(folder);
    for (std::size_t i = 0; i < T_H_B.size(); ++i) {
      std::string name = std::to_string(i);
      name.insert(0, 6 - name.size(), '0');
      write_png(folder / (name + ".png"), painter.paint(camera.T_H_C.inverse() * T_H_B[i], board, noise,
                                                        2 * (1000 * seed + i) + (left ? 1 : 0)));
    }
  }
}

}  // namespace vergence::test
