// A shade field finds how a surface is lit otherwise, and nothing where it is not.
#include "algo/shade_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "algo/rm_ga.hpp"

namespace vergence {
namespace {

constexpr int kPoints = 1000;

// Points over a surface of 120 x 80 mm, each of some colour.
struct Surface {
  Surface() {
    CounterRandom random(5, 0);
    const auto share = [&] { return static_cast<float>(random.next() >> 40) / 16777216.0F; };
    for (int i = 0; i < kPoints; ++i) {
      x_mm.push_back(120 * share() - 60);
      y_mm.push_back(80 * share() - 40);
      photo.push_back({160 * share() - 80, 100 * share() - 50, 100 * share() - 50, 0});
    }
    field.start(x_mm.data(), y_mm.data(), kPoints);
  }

  // As it looks where the light falls otherwise by s, seen with that gain, and fits.
  void fit(const std::function<double(double, double)>& s, double gain, double stiffness) {
    field.reset();
    for (int i = 0; i < kPoints; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double lit = gain * s(static_cast<double>(x_mm[k]), static_cast<double>(y_mm[k]));
      const std::array<float, 4>& p = photo[k];
      field.add(i, p, gain,
                {lit * static_cast<double>(p[0] + 128), lit * static_cast<double>(p[1]),
                 lit * static_cast<double>(p[2])},
                1);
    }
    field.solve(stiffness);
  }

  std::vector<float> x_mm;
  std::vector<float> y_mm;
  std::vector<std::array<float, 4>> photo;
  ShadeField field;
};

TEST(ShadeField, FindsWhatVariesSlowly) {
  const auto shading = [](double x, double y) { return 0.3 * std::sin(x / 25) + 0.002 * y; };
  for (const double gain : {0.5, 1.0, 2.0}) {
    Surface surface;
    surface.fit(shading, gain, 1);
    double squares = 0;
    for (int i = 0; i < kPoints; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double off = surface.field.shade(i) -
                         shading(static_cast<double>(surface.x_mm[k]), static_cast<double>(surface.y_mm[k]));
      squares += off * off;
    }
    EXPECT_LT(std::sqrt(squares / kPoints), 0.02) << gain;  // of 0.2
  }
}

TEST(ShadeField, LeavesThePhotoAsItIsWhereNothingHasChanged) {
  Surface surface;
  surface.fit([](double, double) { return 0.0; }, 1, 1);
  for (int i = 0; i < kPoints; ++i) {
    const auto& photo = surface.photo[static_cast<std::size_t>(i)];
    EXPECT_EQ(surface.field.relit(i, photo), photo);
  }
}

TEST(ShadeField, RelitIsWhatTheLightMakesOfThePhoto) {
  Surface surface;
  surface.fit([](double, double) { return 0.25; }, 1, 0);
  for (int i = 0; i < kPoints; ++i) {
    const auto& photo = surface.photo[static_cast<std::size_t>(i)];
    const auto relit = surface.field.relit(i, photo);
    EXPECT_NEAR(relit[0] + 128, 1.25F * (photo[0] + 128), 1e-3);
    EXPECT_NEAR(relit[1], 1.25F * photo[1], 1e-3);
    EXPECT_NEAR(relit[2], 1.25F * photo[2], 1e-3);
    EXPECT_EQ(relit[3], 0);
  }
}

TEST(ShadeField, StaysWithinItsBoundsAndGivesNothingForNothing) {
  Surface surface;
  surface.fit([](double, double) { return 9.0; }, 1, 1);
  for (int i = 0; i < kPoints; ++i) EXPECT_LE(surface.field.shade(i), 0.5 + 1e-6);
  surface.field.reset();
  surface.field.solve(1);
  for (int i = 0; i < kPoints; ++i) EXPECT_EQ(surface.field.shade(i), 0);
}

// All in one place, as of a model whose points stand in a line: no cell has a width.
TEST(ShadeField, TakesPointsWithoutExtent) {
  const std::vector<float> zeros(16, 0.0F);
  ShadeField field;
  field.start(zeros.data(), zeros.data(), 16);
  field.reset();
  for (int i = 0; i < 16; ++i) field.add(i, {10, 0, 0, 0}, 1, {13.8, 0, 0}, 1);
  field.solve(0);
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(field.shade(i), 0.1, 1e-6);
}

}  // namespace
}  // namespace vergence
