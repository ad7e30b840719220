// How alike a posed photo-model and the images are, beyond votes of hue: normalized cross-correlation of luma
// and chroma. It does not mind gain and offset of the light, needs few points, and falls off smoothly around
// the true pose, which is what evolution from nowhere needs; see docs/correlation.md for how it compares with
// votes.
#pragma once

#include <array>
#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/limits.hpp"
#include "algo/target_model.hpp"

namespace vergence {

// What becomes of points whose surface faces away from a camera: the target itself hides them.
enum class HiddenPoints : std::uint8_t {
  kTakenAlong,  // as if they were seen: quicker
  kLeftOut,
};

// The first `points` points of S_in at one pyramid level, laid out for the kernel, with their sums.
struct CorrelationModel {
  int level = 0;
  int points = 0;
  HiddenPoints hidden = HiddenPoints::kTakenAlong;
  // Pairs of 16-bit numbers as the kernel meets them: (luma, 2 cr) and (2 cb, 0), all centred on 128 before.
  alignas(64) std::array<std::int16_t, 2 * kMaxPhotoPoints + 64> luma_cr{};
  alignas(64) std::array<std::int16_t, 2 * kMaxPhotoPoints + 64> cb{};
  std::int64_t sum_luma = 0;
  std::int64_t sum_cb = 0;
  std::int64_t sum_cr = 0;
  std::int64_t sum_squares = 0;
  double deviation = 0;  // root of what stands under the root for the model, times the points
};

// `points` is limited to the model's S_in and rounded down to a multiple of 16 (whole vectors on every
// machine; at least 16, repeating none).
void build_correlation_model(const PhotoModel& photo, int level, int points, HiddenPoints hidden,
                             CorrelationModel& model);

// Sums of one camera's image over the points, in the weights of the model.
struct CorrelationSums {
  std::int64_t luma = 0;
  std::int64_t cb = 0;
  std::int64_t cr = 0;
  std::int64_t squares = 0;
  std::int64_t products = 0;  // image times model
  std::int64_t facing = 0;    // points that are not left out
  std::int64_t seen = 0;      // those of them in the image
  // Of the model, over those.
  std::int64_t model_luma = 0;
  std::int64_t model_cb = 0;
  std::int64_t model_cr = 0;
};

inline constexpr std::int64_t kCorrelationOne = 1'000'000;

// Correlation of one camera, -1 .. 1 in millionths:
//   sum_c cov_c(image, model) / sqrt(sum_c var_c(image) sum_c var_c(model)),  c = luma, 2 cb, 2 cr,
// with a small constant added to both variances, so that noise on a bare wall does not count as likeness.
// Points beside the image, or behind the camera, are taken to see the mean of what the others see, and the
// whole counts by the share that is seen: a target that is half beside the image is likely where it is, and
// half of one anywhere is not. Points left out are as if they were not of the model, but for its variance,
// which is that of all points. `camera_at_level` is the camera scaled to the level of the model
// (camera_at_level()).
[[nodiscard]] std::int64_t correlation(const CorrelationModel& model, const PhotoModel& photo,
                                       const CameraModel& camera_at_level, const ColourLevel& image,
                                       const Transform& T_C_M);

}  // namespace vergence
