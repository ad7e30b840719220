#include "algo/inflation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "algo/limits.hpp"

namespace vergence {
namespace {

// 32 x 32 points, each with its four neighbours on the grid.
class Grid {
 public:
  static constexpr int kSide = 32;
  static constexpr double kStep_mm = 2;

  template <class Silhouette>
  void inflate_silhouette(Silhouette is_inside) {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const std::size_t i = index(row, column);
        x_mm_[i] = x_mm(column);
        y_mm_[i] = x_mm(row);
        is_target_[i] = is_inside(x_mm_[i], y_mm_[i]) ? 1 : 0;
      }
    }
    inflate(kSide * kSide, x_mm_, y_mm_, is_target_, z_mm_);
  }

  // Above the border of the silhouette, as depths are told from their mean only.
  [[nodiscard]] double height_mm(int row, int column) const {
    return z_mm_[index(0, 0)] - z_mm_[index(row, column)];
  }
  [[nodiscard]] double mean_mm() const {
    double sum = 0;
    for (std::size_t i = 0; i < kSide * kSide; ++i) sum += is_target_[i] * z_mm_[i];
    return sum / (kSide * kSide);
  }
  [[nodiscard]] static double x_mm(int column) { return kStep_mm * (column - 0.5 * (kSide - 1)); }

 private:
  static std::size_t index(int row, int column) { return static_cast<std::size_t>(row * kSide + column); }

  using Points = std::array<double, kMaxReliefPoints>;
  Points x_mm_{};
  Points y_mm_{};
  Points is_target_{};
  Points z_mm_{};
};

TEST(Inflation, MakesADiscAHemisphere) {
  constexpr double kRadius_mm = 25;
  const auto grid = std::make_unique<Grid>();
  grid->inflate_silhouette([](double x, double y) { return x * x + y * y < kRadius_mm * kRadius_mm; });
  for (int row = 0; row < Grid::kSide; ++row) {
    for (int column = 0; column < Grid::kSide; ++column) {
      const double x = Grid::x_mm(column);
      const double y = Grid::x_mm(row);
      const double squared = kRadius_mm * kRadius_mm - x * x - y * y;
      if (squared < 0) continue;
      // The silhouette's edge lies up to a step beside where the grid has it: most where it is steepest.
      const double sphere_mm = std::sqrt(squared);
      EXPECT_NEAR(grid->height_mm(row, column), sphere_mm, sphere_mm > 10 ? 1.6 : 4.0) << x << " " << y;
    }
  }
}

TEST(Inflation, MakesAStripATube) {
  constexpr double kHalf_mm = 10;
  constexpr double kBorder_mm = 10.5;  // between the last points within it and the first beside it
  const auto grid = std::make_unique<Grid>();
  grid->inflate_silhouette([](double, double y) { return std::abs(y) < kHalf_mm; });
  const int middle = Grid::kSide / 2;
  EXPECT_NEAR(grid->height_mm(middle, middle), std::sqrt(2.0) * kBorder_mm, 0.3);
  EXPECT_DOUBLE_EQ(grid->height_mm(Grid::kSide - 1, middle), 0);
}

TEST(Inflation, HasAMeanOfZero) {
  const auto grid = std::make_unique<Grid>();
  grid->inflate_silhouette([](double x, double y) { return x > -20 && x < 5 + 0.5 * y; });
  EXPECT_NEAR(grid->mean_mm(), 0, 1e-9);
  EXPECT_GT(grid->height_mm(16, 8), 5);
}

TEST(Inflation, LeavesNothingFlat) {
  const auto grid = std::make_unique<Grid>();
  grid->inflate_silhouette([](double, double) { return false; });
  EXPECT_DOUBLE_EQ(grid->height_mm(16, 16), 0);
}

}  // namespace
}  // namespace vergence
