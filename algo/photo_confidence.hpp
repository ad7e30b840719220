// How likely a refined pose of a photo-model is right, from how it is borne out.
#pragma once

namespace vergence {

struct PhotoEvidence {
  double left = 0;   // correlation of the photo with each camera's image, -1 .. 1
  double right = 0;  //
  // Misfit of left with right at the pose, 0 .. 1 (Alignment::pairing_cost); 1: they see no points in common.
  double left_right_cost = 1;
};

// Probability, 0 to 1, that the pose is right. `followed`: the target was there in the frame before, which
// makes it likelier to be there now. Coefficients and their measurement: docs/tracker.md.
[[nodiscard]] double photo_confidence(const PhotoEvidence& evidence, bool followed);

}  // namespace vergence
