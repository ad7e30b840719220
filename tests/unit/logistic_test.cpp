// The logistic function against libm's, and its order.
#include "algo/logistic.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "algo/photo_confidence.hpp"

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

TEST(PhotoConfidence, RisesWithLikenessAndWhereTheTargetWasFollowed) {
  for (double likeness = 0.1; likeness < 1; likeness += 0.05) {
    const PhotoEvidence less{likeness, likeness - 0.1, 0.3};
    const PhotoEvidence more{likeness + 0.04, likeness - 0.1, 0.3};
    EXPECT_LT(photo_confidence(less, false), photo_confidence(more, false)) << likeness;
    EXPECT_LT(photo_confidence(less, false), photo_confidence(less, true)) << likeness;
  }
  EXPECT_GT(photo_confidence({0.95, 0.95, 0.15}, false), 0.95);
  EXPECT_LT(photo_confidence({0.6, 0.6, 0.1}, false), 0.05);
}

}  // namespace
}  // namespace vergence
