#include "algo/photo_confidence.hpp"

#include "algo/logistic.hpp"

namespace vergence {
namespace {

// A logistic regression over poses found right and wrong. The better of the two cameras says most: a solid
// seen obliquely by one of them looks little like its photo there. That left and right disagree speaks FOR a
// pose: wrong ones settle on smooth places, where everything agrees with everything.
constexpr double kBias = -20.5;
constexpr double kMean = 11.7;
constexpr double kBetter = 13.0;
constexpr double kLeftRightCost = 16.3;
constexpr double kLargestCost = 0.7;  // beyond it, the two see different things, or nothing
// Between one frame and the next a target stays far more often than it goes.
constexpr double kFollowedBias = 1.0;

}  // namespace

double photo_confidence(const PhotoEvidence& evidence, bool followed) {
  const double mean = (evidence.left + evidence.right) / 2;
  const double better = evidence.left > evidence.right ? evidence.left : evidence.right;
  const double cost = evidence.left_right_cost < kLargestCost ? evidence.left_right_cost
                      : evidence.left_right_cost < 1          ? kLargestCost
                                                              : 0;
  return logistic(kBias + kMean * mean + kBetter * better + kLeftRightCost * cost +
                  (followed ? kFollowedBias : 0));
}

}  // namespace vergence
