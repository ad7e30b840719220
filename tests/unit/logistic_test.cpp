// The logistic function against libm's, and its order.
#include "algo/logistic.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace vergence {
namespace {

TEST(Logistic, IsThatOfLibm) {
  for (double x = -45; x <= 45; x += 0.01) EXPECT_NEAR(logistic(x), 1 / (1 + std::exp(-x)), 1e-7) << x;
  EXPECT_EQ(logistic(0), 0.5);
  EXPECT_EQ(logistic(std::nan("")), 0);
  EXPECT_EQ(logistic(-INFINITY), 0);
  EXPECT_EQ(logistic(INFINITY), 1);
}

TEST(Logistic, NeverFalls) {
  for (double x = -41; x <= 41; x += 0.001) EXPECT_LE(logistic(x), logistic(x + 0.001)) << x;
}

}  // namespace
}  // namespace vergence
