#include "algo/inflation.hpp"

#include <cmath>
#include <cstddef>

namespace vergence {
namespace {

// Points lie on a grid of whole pixels, and thus not evenly: the equation is solved on an even one about
// them, whose border lies beside the target.
constexpr int kSide = 64;
constexpr int kRounds = 300;  // of successive over-relaxation
constexpr double kOverRelaxation = 1.9;

class Grid {
 public:
  Grid(int points, const std::array<double, kMaxReliefPoints>& x_mm,
       const std::array<double, kMaxReliefPoints>& y_mm) {
    double right_mm = left_mm_ = x_mm[0];
    double bottom_mm = top_mm_ = y_mm[0];
    for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
      left_mm_ = std::fmin(left_mm_, x_mm[i]);
      right_mm = std::fmax(right_mm, x_mm[i]);
      top_mm_ = std::fmin(top_mm_, y_mm[i]);
      bottom_mm = std::fmax(bottom_mm, y_mm[i]);
    }
    step_mm_ = std::fmax(std::fmax(right_mm - left_mm_, bottom_mm - top_mm_), 1e-3) / (kSide - 3);
  }

  // A cell is of the target where the point nearest to it is.
  void take_silhouette(int points, const std::array<double, kMaxReliefPoints>& x_mm,
                       const std::array<double, kMaxReliefPoints>& y_mm,
                       const std::array<double, kMaxReliefPoints>& is_target) {
    for (int row = 1; row < kSide - 1; ++row) {
      for (int column = 1; column < kSide - 1; ++column) {
        const double x = left_mm_ + step_mm_ * (column - 1);
        const double y = top_mm_ + step_mm_ * (row - 1);
        double least = 1e30;
        for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
          const double squared = (x_mm[i] - x) * (x_mm[i] - x) + (y_mm[i] - y) * (y_mm[i] - y);
          if (squared >= least) continue;
          least = squared;
          inside_[at(row, column)] = is_target[i];
        }
        // The rectangle of the points may be narrower than the grid.
        if (least > 4 * step_mm_ * step_mm_ + kFar_mm * kFar_mm) inside_[at(row, column)] = 0;
      }
    }
  }

  void solve() {
    for (int round = 0; round < kRounds; ++round) {
      for (int row = 1; row < kSide - 1; ++row) {
        for (int column = 1; column < kSide - 1; ++column) {
          const std::size_t i = at(row, column);
          const double sum = h_[i - 1] + h_[i + 1] + h_[i - kSide] + h_[i + kSide];
          const double relaxed = 0.25 * sum + step_mm_ * step_mm_;
          h_[i] = inside_[i] * (h_[i] + kOverRelaxation * (relaxed - h_[i]));
        }
      }
    }
  }

  // Between the cells.
  [[nodiscard]] double h(double x_mm, double y_mm) const {
    const double column = 1 + (x_mm - left_mm_) / step_mm_;
    const double row = 1 + (y_mm - top_mm_) / step_mm_;
    const double u = column - std::floor(column);
    const double v = row - std::floor(row);
    const std::size_t i = at(static_cast<int>(row), static_cast<int>(column));
    const double above = h_[i] + u * (h_[i + 1] - h_[i]);
    const double below = h_[i + kSide] + u * (h_[i + kSide + 1] - h_[i + kSide]);
    return above + v * (below - above);
  }

 private:
  static constexpr double kFar_mm = 5;
  static std::size_t at(int row, int column) { return static_cast<std::size_t>(row * kSide + column); }

  double left_mm_;
  double top_mm_;
  double step_mm_;
  std::array<double, std::size_t{kSide} * kSide> inside_{};
  std::array<double, std::size_t{kSide} * kSide> h_{};
};

}  // namespace

void inflate(int points, const std::array<double, kMaxReliefPoints>& x_mm,
             const std::array<double, kMaxReliefPoints>& y_mm,
             const std::array<double, kMaxReliefPoints>& is_target,
             std::array<double, kMaxReliefPoints>& z_mm) {
  Grid grid(points, x_mm, y_mm);
  grid.take_silhouette(points, x_mm, y_mm, is_target);
  grid.solve();
  double sum = 0;
  double weight = 1e-9;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
    z_mm[i] = -is_target[i] * std::sqrt(std::fmax(grid.h(x_mm[i], y_mm[i]), 0));
    sum += is_target[i] * z_mm[i];
    weight += is_target[i];
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) z_mm[i] -= sum / weight;
}

}  // namespace vergence
