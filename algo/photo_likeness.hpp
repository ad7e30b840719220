// How alike a photo and one camera's image are, in ways that a correlation of everything does not show.
#pragma once

#include "algo/refine.hpp"
#include "algo/target_model.hpp"

namespace vergence {

// Correlations, -1 .. 1; 0 of what cannot be told.
struct PhotoLikeness {
  double luma = 0;           // of brightness alone: another thing of the same colours has none
  double worst_quarter = 0;  // of the four quarters of the target, everything in it, the one least alike
};

// Over the first `points` points, of which `samples` says what the camera sees, and `photo`, four floats a
// point, what the model has there (RefineWorkspace, after an assessment).
[[nodiscard]] PhotoLikeness photo_likeness(const PhotoModel& model, int points, const RefineSamples& samples,
                                           const float* photo);

}  // namespace vergence
