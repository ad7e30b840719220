// Our sine and cosine against libm's.
#include "algo/trigonometry.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vergence {
namespace {

TEST(Trigonometry, AgreesWithLibmTo1e14) {
  for (int i = -400000; i <= 400000; ++i) {
    const double angle = i * 0.00025 + 1e-7;
    const auto [sine, cosine] = sin_cos(angle);
    ASSERT_NEAR(sine, std::sin(angle), 1e-14) << angle;
    ASSERT_NEAR(cosine, std::cos(angle), 1e-14) << angle;
  }
}

}  // namespace
}  // namespace vergence
