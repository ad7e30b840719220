#include "algo/photo_confidence.hpp"

#include "algo/logistic.hpp"

namespace vergence {
namespace {

// As `vergence accuracy --fit-confidence` fitted them to poses found right and wrong.
constexpr PhotoFeatures kWeight{-3.56, 6.84, 7.10, 4.10, 1.54, 1.65, -3.40, -2.68};
// Between one frame and the next a target stays far more often than it goes.
constexpr double kFollowedBias = 1.0;

// Beyond these, more of the same says nothing more.
constexpr double kLargestCost = 0.7;  // the two see different things, or nothing
constexpr double kLikeQuarter = 0.3;
constexpr double kLargestDepth_mm = 3;
// Real photographs have finer texture than rendered ones: how well they are fixed, wrong poses too, is to say
// nothing for them.
constexpr double kSmallest_e = 0.015;
constexpr double kLargest_e = 0.05;
constexpr double kPercent = 100;

double at_most(double value, double limit) {
  return value < limit ? value : limit;
}

}  // namespace

PhotoFeatures photo_features(const PhotoEvidence& evidence) {
  const double mean = (evidence.left + evidence.right) / 2;
  const double better = evidence.left > evidence.right ? evidence.left : evidence.right;
  const double cost = evidence.left_right_cost < 1 ? at_most(evidence.left_right_cost, kLargestCost) : 0;
  const double e = evidence.e > kSmallest_e ? at_most(evidence.e, kLargest_e) : kSmallest_e;
  return {1,
          mean,
          better,
          evidence.luma,
          at_most(evidence.worst_quarter, kLikeQuarter),
          cost,
          at_most(evidence.depth_mm, kLargestDepth_mm),
          kPercent * e};
}

double photo_confidence(const PhotoEvidence& evidence, bool followed) {
  const PhotoFeatures feature = photo_features(evidence);
  double sum = followed ? kFollowedBias : 0;
  for (std::size_t i = 0; i < kPhotoFeatures; ++i) sum += kWeight[i] * feature[i];
  return logistic(sum);
}

}  // namespace vergence
