// How well a pose explains the two images: votes of hue samples [Eqs. 3.20-3.22, 5.17-5.20].
//
// Votes are integers and their sum does not depend on order, so every instruction set gives the same number.
// Projection is in single precision, the same operations in the same order everywhere. A sample beside the
// image, or nearer than kMinDepth_mm, sees kHueOutside, which matches nothing: it votes "otherwise".
#pragma once

#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/hue.hpp"
#include "algo/target_model.hpp"

namespace vergence {

// Votes of one camera for the marker: sum_in p - sum_out p [Eq. 3.22].
// T_C_M: pose of the target in the camera (target_in_camera).
[[nodiscard]] std::int32_t marker_votes(const MarkerModel& model, const CameraModel& camera,
                                        const HuePlane& plane, const Transform& T_C_M);

// F of both cameras: (votes_left + votes_right) / (2 n_in), n_in = balls * inner samples.
[[nodiscard]] double marker_fitness(const MarkerModel& model, std::int64_t votes_left_and_right);

// Votes of one camera for the photo-model, in thousandths: sum_in p + sum_out p [Eqs. 5.17, 5.18].
[[nodiscard]] std::int32_t photo_votes(const PhotoModel& model, const CameraModel& camera,
                                       const HuePlane& plane, const Transform& T_C_M);

// F of both cameras: (votes_left + votes_right) / (2 N) [Eq. 5.19].
[[nodiscard]] double photo_fitness(const PhotoModel& model, std::int64_t votes_left_and_right);

}  // namespace vergence
