// Our sine, cosine and their inverses against libm's.
#include "algo/trigonometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace vergence {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Trigonometry, AgreesWithLibmTo1e14) {
  for (int i = -400000; i < 400000; ++i) {
    const double angle = i * 0.00025 + 1e-7;
    const auto [sine, cosine] = sin_cos(angle);
    ASSERT_NEAR(sine, std::sin(angle), 1e-14) << angle;
    ASSERT_NEAR(cosine, std::cos(angle), 1e-14) << angle;
  }
}

TEST(Trigonometry, HasNoSineOfWhatIsNoAngle) {
  for (const double angle : {100.5, -100.5, 1e300, kInfinity, -kInfinity, kNaN}) {
    EXPECT_TRUE(std::isnan(sin_cos(angle).sine)) << angle;
    EXPECT_TRUE(std::isnan(sin_cos(angle).cosine)) << angle;
  }
}

TEST(Trigonometry, ArcTangentAgreesWithLibm) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> side(-1, 1);
  std::uniform_int_distribution<int> exponent(-300, 300);
  for (int i = 0; i < 2000000; ++i) {
    const double y = side(random);
    const double x = side(random);
    ASSERT_NEAR(arc_tangent2(y, x), std::atan2(y, x), 1e-15) << y << " " << x;
    // Over all magnitudes, and small angles to their own precision.
    const double wide_y = std::ldexp(y, exponent(random));
    const double wide_x = std::ldexp(x, exponent(random));
    const double libm = std::atan2(wide_y, wide_x);
    ASSERT_NEAR(arc_tangent2(wide_y, wide_x), libm, 1e-15 * std::fabs(libm) + 1e-320)
        << wide_y << " " << wide_x;
  }
}

TEST(Trigonometry, ArcTangentAtTheEdges) {
  const double edges[] = {0.0,  -0.0, 1.0,       -1.0,       5e-324, -5e-324, 2.2e-308, 1e-17,
                          1e17, 0.1,  kInfinity, -kInfinity, 1e308,  -1e308,  1.7e308,  1.0 / 16};
  for (const double y : edges) {
    for (const double x : edges) {
      const double libm = std::atan2(y, x);
      EXPECT_NEAR(arc_tangent2(y, x), libm, 1e-15) << y << " " << x;
      EXPECT_EQ(std::signbit(arc_tangent2(y, x)), std::signbit(libm)) << y << " " << x;
    }
    EXPECT_TRUE(std::isnan(arc_tangent2(y, kNaN)));
    EXPECT_TRUE(std::isnan(arc_tangent2(kNaN, y)));
  }
}

TEST(Trigonometry, ArcTangentUndoesSineAndCosine) {
  for (int i = -31415; i <= 31415; ++i) {
    const double angle = i * 1e-4;
    const auto [sine, cosine] = sin_cos(angle);
    ASSERT_NEAR(arc_tangent2(sine, cosine), angle, 1e-15);
  }
}

TEST(Trigonometry, ArcSineAndCosineAgreeWithLibm) {
  for (int i = -1000000; i <= 1000000; ++i) {
    const double x = i * 1e-6;
    ASSERT_NEAR(arc_sine(x), std::asin(x), 1e-14) << x;
    ASSERT_NEAR(arc_cosine(x), std::acos(x), 1e-14) << x;
  }
  for (int k = 1; k <= 52; ++k) {  // towards the ends, where both turn steep
    const double x = 1 - std::ldexp(1, -k);
    ASSERT_NEAR(arc_sine(x), std::asin(x), 1e-14) << x;
    ASSERT_NEAR(arc_cosine(x), std::acos(x), 1e-14) << x;
    ASSERT_NEAR(arc_cosine(-x), std::acos(-x), 1e-14) << x;
  }
}

TEST(Trigonometry, ArcSineAndCosineAreClamped) {
  for (const double beyond : {1.0, 1.0000000000000002, 2.0, 1e300, kInfinity}) {
    EXPECT_EQ(arc_sine(beyond), kPi / 2);
    EXPECT_EQ(arc_sine(-beyond), -kPi / 2);
    EXPECT_EQ(arc_cosine(beyond), 0);
    EXPECT_EQ(arc_cosine(-beyond), kPi);
  }
  EXPECT_TRUE(std::isnan(arc_sine(kNaN)));
  EXPECT_TRUE(std::isnan(arc_cosine(kNaN)));
  EXPECT_TRUE(std::signbit(arc_sine(-0.0)));
}

}  // namespace
}  // namespace vergence
