// Polish of a photo-model's pose below the plateau of the votes: dense alignment of luma and chroma by
// Gauss-Newton, robust, with a fixed number of steps on a fixed number of points, so its work is bounded and
// does not depend on the image.
//
// Three pairings are aligned at once: photo with left image, photo with right image, and left with right. The
// third needs no photo: it fixes depth and tilt even where the photo was taken under another light. Each
// pairing has a gain and, per channel, an offset of its own, eliminated from the normal equations.
#pragma once

#include <array>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/limits.hpp"
#include "algo/target_model.hpp"

namespace vergence {

// One pass: `iterations` steps on the first `points` points of S_in at a level of the pyramids. Points are
// taken in fours, and kMaxRefinePoints at most.
struct RefinePass {
  int level;
  int points;
  int iterations;
};

// What one camera sees at the points: four floats a point (luma, 2 cb, 2 cr, centred on 128; and 0), their
// change a pixel to the right and down, and a weight (0: not in the image, or not of the target).
struct RefineSamples {
  alignas(64) std::array<float, 4 * kMaxRefinePoints> value;
  alignas(64) std::array<float, 4 * kMaxRefinePoints> slope_u;
  alignas(64) std::array<float, 4 * kMaxRefinePoints> slope_v;
  alignas(64) std::array<float, kMaxRefinePoints> weight;
};

struct RefineWorkspace {
  RefineSamples left;
  RefineSamples right;
  alignas(64) std::array<float, 4 * kMaxRefinePoints> photo;
};

// Improves T_H_M. The pose increment is [translation in mm; rotation vector] in the target frame; one step
// moves no more than 15 mm and 0.15 rad.
void refine_photo_pose(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                       const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                       Transform& T_H_M);

// How badly a pose explains the images, and how well it is fixed by them.
struct Alignment {
  // For each pairing the mean absolute residual over the spread of the colours, summed over the three; 0 is
  // perfect, 3 no better than any other place. The measure that refinement must never make worse.
  double cost = 3;
  std::array<double, 3> pairing_cost{1, 1, 1};  // of photo with left, photo with right, left with right
  // Covariance of [x y z e1 e2 e3] of T_H_M (mm, 1), from the normal equations and the residuals; large, not
  // infinite, where the images fix nothing.
  Matrix6 covariance = Matrix6::Zero();
};

[[nodiscard]] double alignment_cost(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                                    const ColourPyramid& right, const RefinePass& pass,
                                    RefineWorkspace& workspace, const Transform& T_H_M);

[[nodiscard]] Alignment assess_alignment(const PhotoModel& model, const StereoRig& rig,
                                         const ColourPyramid& left, const ColourPyramid& right,
                                         const RefinePass& pass, RefineWorkspace& workspace,
                                         const Transform& T_H_M);

}  // namespace vergence
