#include "tools/calibrate/view_quality.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>

namespace vergence::calibrate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kCellColumns = 8;
constexpr int kCellRows = 6;
constexpr std::size_t kEnoughViews = 12;

double angle_deg(const Transform& a, const Transform& b) {
  return std::acos(std::clamp(a.R.col(2).dot(b.R.col(2)), -1.0, 1.0)) / kDegree;
}

double mean_distance_px(const Corners& a, const Corners& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).norm();
  return sum / static_cast<double>(a.size());
}

// Pairs that hardly differ, and so count as one.
std::string similar_views(const std::vector<ViewOfBoard>& views, int width_px) {
  constexpr double kSameTilt_deg = 4;
  constexpr double kSamePlace = 0.03;  // of the image's width
  std::string pairs;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      if (angle_deg(views[i].T_C_B, views[j].T_C_B) > kSameTilt_deg) continue;
      if (mean_distance_px(*views[i].corners, *views[j].corners) > kSamePlace * width_px) continue;
      pairs += (pairs.empty() ? "" : ", ") + std::to_string(views[i].number) + " and " +
               std::to_string(views[j].number);
    }
  }
  return pairs;
}

}  // namespace

double tilt_deg(const Transform& T_C_B) {
  return std::acos(std::clamp(std::abs(T_C_B.R(2, 2)), 0.0, 1.0)) / kDegree;
}

double image_coverage(const std::vector<const Corners*>& views, int width_px, int height_px) {
  std::set<int> cells;
  for (const Corners* corners : views) {
    for (const Vector2& uv : *corners) {
      const int column =
          std::clamp(static_cast<int>((uv.x() + 0.5) * kCellColumns / width_px), 0, kCellColumns - 1);
      const int row = std::clamp(static_cast<int>((uv.y() + 0.5) * kCellRows / height_px), 0, kCellRows - 1);
      cells.insert(row * kCellColumns + column);
    }
  }
  return static_cast<double>(cells.size()) / (kCellColumns * kCellRows);
}

std::vector<std::string> judge_views(const std::vector<ViewOfBoard>& views, int width_px) {
  std::vector<std::string> warnings;
  if (views.size() < kEnoughViews) {
    warnings.push_back("only " + std::to_string(views.size()) + " views; take " +
                       std::to_string(kEnoughViews) + " to 30");
  }
  // How the board's normal wanders: a board that never tilts tells no focal length, and one that tilts about
  // one axis only leaves the principal point weak along it.
  constexpr double kHardlyTilted = 0.10;  // sine of the tilt, RMS
  constexpr double kOneAxis = 0.05;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const ViewOfBoard& view : views) {
    const Vector2 normal = view.T_C_B.R.col(2).head<2>();
    scatter += normal * normal.transpose() / static_cast<double>(views.size());
  }
  const Vector2 spread =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues().cwiseMax(0).cwiseSqrt();
  if (spread[1] < kHardlyTilted) {
    warnings.emplace_back(
        "the board is hardly tilted in any view; tilt it by 20 to 40 degrees, about both axes");
  } else if (spread[0] < kOneAxis) {
    warnings.emplace_back("the board is tilted about one axis only; tilt it about the other one too");
  }
  if (const std::string pairs = similar_views(views, width_px); !pairs.empty())
    warnings.push_back("nearly the same views: " + pairs + "; they count as one");
  return warnings;
}

}  // namespace vergence::calibrate
