// The weights of photo_confidence(), fitted to poses that were found right and wrong.
#pragma once

#include <vector>

#include "algo/photo_confidence.hpp"

namespace vergence::accuracy {

struct JudgedPose {
  PhotoFeatures feature{};
  bool right = false;
  double counts = 1;  // as so many poses
};

// Logistic regression by iteratively reweighted least squares. `ridge` draws every weight but the first
// towards 0, so that poses that can be told apart without fail do not drive them to infinity.
[[nodiscard]] PhotoFeatures fit_confidence(const std::vector<JudgedPose>& poses, double ridge);

}  // namespace vergence::accuracy
