// Polish of a marker's pose below the plateau of the votes: the outlines of its balls, found to a fraction of
// a pixel in both images, fitted by Gauss-Newton. A fixed number of steps on a fixed number of contour
// points, so its work is bounded and does not depend on the image.
//
// A sphere's outline is a circle in space (where the cone of sight touches it) and so an ellipse in the
// image. Along the normals of the predicted ellipse the edge is where the share of the background passes one
// half, in linear light. Each ball has in each camera one radial offset of its own, eliminated from the
// normal equations: blur, and a camera's curve that is not quite sRGB, make all balls look a little larger or
// smaller. Depth comes from the disparity of the centres.
#pragma once

#include <array>

#include "algo/camera_model.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/hue.hpp"
#include "algo/light_follower.hpp"
#include "algo/target_model.hpp"

namespace vergence {

inline constexpr int kContourPoints = 24;  // of each ball in each camera

// What one camera sees.
struct MarkerSight {
  const CameraModel* camera = nullptr;
  const HuePlane* hue = nullptr;
  ColourLevel colour;  // of make_raw_colour(): luma cb cr where
  bool yuv = false;    // the camera delivers YUV, r g b otherwise
};

struct MarkerEvidence {
  double cost = 1;  // mean over the contour points: 0 an edge just there, 1 none within reach or none clear
  // The share of contour points with a clear edge, to within about a pixel, of balls of about the right size:
  // over everything, of each ball over both cameras, and of the ball that has least (of those in the images).
  double share = 0;
  std::array<double, kMaxBalls> ball{};
  double least_ball = 0;
};

// How well the outlines at a pose are borne out by the images: the measure that a fit must never make worse.
[[nodiscard]] MarkerEvidence marker_evidence(const MarkerModel& model, const MarkerSight& left,
                                             const MarkerSight& right, const Transform& T_H_M);

struct MarkerFit {
  Transform T_H_M;
  MarkerEvidence evidence;
  // Normal equations of the increment [translation in mm; rotation vector] in the target frame over the
  // variance of the residuals: the inverse of its covariance.
  Matrix6 information = Matrix6::Zero();
};

// From a guess (some 10 mm, 20 mm in depth and 0.15 in e off) first to about a pixel, by the hue along rays
// from the centre of each disc, then to a fraction of a pixel by the edges of colour. Never worse than the
// guess by marker_evidence().cost.
[[nodiscard]] MarkerFit fit_marker(const MarkerModel& model, const MarkerSight& left,
                                   const MarkerSight& right, const Transform& guess);

// Shows the follower the hues of the pixels well inside each ball that is borne out, one channel a ball.
// `configured`: hue codes of the model as it was built.
void observe_light(const MarkerModel& model, const std::array<std::uint8_t, kMaxBalls>& configured,
                   const MarkerSight& left, const MarkerSight& right, const MarkerFit& fit,
                   LightFollower& light);

}  // namespace vergence
