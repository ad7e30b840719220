// How likely a refined pose of a photo-model is right, from how it is borne out.
#pragma once

#include <array>
#include <cstddef>

namespace vergence {

struct PhotoEvidence {
  double left = 0;   // correlation of the photo with each camera's image, -1 .. 1
  double right = 0;  //
  // Misfit of left with right at the pose, 0 .. 1 (Alignment::pairing_cost); 1: they see no points in common.
  double left_right_cost = 1;
  // PhotoLikeness of the camera that has more of each.
  double luma = 0;
  double worst_quarter = 0;
  // Standard deviations that alignment states: of depth, and of the three components of e together.
  double depth_mm = 1000;
  double e = 1;
};

// What the probability is linear in, before the logistic function; first a 1.
inline constexpr std::size_t kPhotoFeatures = 8;
using PhotoFeatures = std::array<double, kPhotoFeatures>;
inline constexpr std::array<const char*, kPhotoFeatures> kPhotoFeatureNames{
    "1", "mean", "better", "luma", "worst_quarter", "misfit", "depth", "turn"};
[[nodiscard]] PhotoFeatures photo_features(const PhotoEvidence& evidence);

// Probability, 0 to 1, that the pose is right. `followed`: the target was there in the frame before, which
// makes it likelier to be there now. Coefficients and their measurement: docs/tracker.md.
[[nodiscard]] double photo_confidence(const PhotoEvidence& evidence, bool followed);

}  // namespace vergence
