// Polish of a photo-model's pose below the plateau of the votes: dense alignment of luma and chroma by
// Gauss-Newton, robust, with a fixed number of steps on a fixed number of points, so its work is bounded and
// does not depend on the image.
//
// Three pairings are aligned at once: photo with left image, photo with right image, and left with right. The
// third needs no photo: it fixes depth and tilt even where the photo was taken under another light. Each
// pairing has a gain and, per channel, an offset of its own, eliminated from the normal equations.
#pragma once

#include <array>
#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/limits.hpp"
#include "algo/target_model.hpp"

namespace vergence {

inline constexpr int kMaxRefinePoints = 1024;

// One pass: `iterations` steps on the first `points` points of S_in at a level of the pyramids.
struct RefinePass {
  int level;
  int points;
  int iterations;
};

// What a step needs to know of each point and camera.
struct RefineSample {
  Vector3 value;                   // luma, 2 cb, 2 cr, centred on 128
  Vector3 slope_u;                 // their change a pixel to the right
  Vector3 slope_v;                 // and down
  Eigen::Matrix<double, 6, 1> du;  // change of the pixel coordinates with the pose increment
  Eigen::Matrix<double, 6, 1> dv;
  bool visible = false;
};

struct RefineWorkspace {
  std::array<RefineSample, kMaxRefinePoints> left;
  std::array<RefineSample, kMaxRefinePoints> right;
};

// Improves T_H_M. The pose increment is [translation in mm; rotation vector] in the target frame; one step
// moves no more than 15 mm and 0.15 rad.
void refine_photo_pose(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                       const ColourPyramid& right, const RefinePass& pass, RefineWorkspace& workspace,
                       Transform& T_H_M);

// How badly the pose explains the images at a level: for each pairing the mean absolute residual over the
// spread of the colours, summed over the three; 0 is perfect, 3 no better than any other place. The measure
// that refinement must never make worse.
[[nodiscard]] double alignment_cost(const PhotoModel& model, const StereoRig& rig, const ColourPyramid& left,
                                    const ColourPyramid& right, int level, int points,
                                    RefineWorkspace& workspace, const Transform& T_H_M);

}  // namespace vergence
