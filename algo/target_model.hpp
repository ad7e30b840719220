// What the target looks like: the ball marker [3.5, Fig. 3.6] or the photo-model [5.2], as sample points laid
// out for forward projection. Built once, before control; read only afterwards.
#pragma once

#include <array>
#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/colour.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/hue.hpp"
#include "algo/image.hpp"
#include "algo/limits.hpp"
#include "algo/status.hpp"

namespace vergence {

// ---- Marker ---------------------------------------------------------------------------------------------

struct Ball {
  Vector3 centre_mm = Vector3::Zero();  // in the target frame
  double radius_mm = 20;
  double hue_deg = 0;
  double tolerance_deg = 20;
};

struct MarkerOptions {
  int inner_samples = 36;    // of S_in, a ball and camera
  int outer_samples = 24;    // of S_out
  double outer_ratio = 1.2;  // radius of the ring S_out over the ball's
};

// A ball of radius R at depth Z projects as a disc of radius f R / Z; its samples are the patterns below, in
// units of that radius.
struct MarkerModel {
  int balls = 0;
  int inner_samples = 0;
  int outer_samples = 0;
  std::array<Ball, kMaxBalls> ball{};
  std::array<std::uint8_t, kMaxBalls> hue{};        // hue codes
  std::array<std::uint8_t, kMaxBalls> tolerance{};  // hue steps
  // Inner samples first, then outer; padded with zeros so that vectors may read past the end.
  alignas(64) std::array<float, kMaxInnerSamples + kMaxOuterSamples + 16> pattern_x{};
  alignas(64) std::array<float, kMaxInnerSamples + kMaxOuterSamples + 16> pattern_y{};

  [[nodiscard]] int samples_per_camera() const { return balls * (inner_samples + outer_samples); }
};

// Errors: kBadModel (no ball, more than kMaxBalls, radius <= 0, sample counts outside [1, limit], ratio <=
// 1).
[[nodiscard]] Status build_marker_model(const Ball* balls, int count, const MarkerOptions& options,
                                        MarkerModel& model);

// ---- Photo-model ----------------------------------------------------------------------------------------

struct Rectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Weights of Eqs. 5.17 and 5.18 in thousandths, and tolerances in degrees.
struct PhotoVotes {
  int in_match = 2000;
  int in_background = -5;
  int in_other = 0;
  int out_background = 100;
  int out_other = -500;
  double in_tolerance_deg = 30;
  double background_tolerance_deg = 30;  // of S_in points
  double out_tolerance_deg = 20;         // of S_out points
};

struct PhotoOptions {
  int points = 1000;          // about as many in all, S_in and S_out together (<= kMaxPhotoPoints)
  double strip_width = 0.06;  // of S_out, in mean side lengths of the rectangle
  PhotoVotes votes;
};

// Everything known about the photograph the model is made of.
struct PhotoSource {
  ImageView photo;                     // RGB
  const std::uint8_t* mask = nullptr;  // optional: one byte a pixel, rows packed, non-zero on the target
  // Optional, as the mask: zero where a pixel of S_in shows background after all.
  const std::uint8_t* target = nullptr;
  Rectangle roi;
  double distance_mm = 400;       // camera to target plane
  CameraModel camera;             // that took the photo (T_H_C unused)
  double background_hue_deg = 0;  // mean hue of the background, H_B
};

// Mean colour of the photo around each point (BT.601, full range), over squares of 2^level pixels: what a
// camera with that much less resolution would see. For correlation.
struct PointColours {
  alignas(64) std::array<std::uint8_t, kMaxPhotoPoints + 64> luma{};
  alignas(64) std::array<std::uint8_t, kMaxPhotoPoints + 64> cb{};
  alignas(64) std::array<std::uint8_t, kMaxPhotoPoints + 64> cr{};
};

// What a photo shows behind its target, as far as S_in does: of the square around a point, at each level, the
// share (of 255) that is not of the target, and that share's mean colour. Nothing where the silhouette is not
// known.
struct PhotoBackdrop {
  std::array<std::array<std::uint8_t, kMaxPhotoPoints + 64>, kColourLevels> share{};
  std::array<PointColours, kColourLevels> colour{};
  YCbCr mean{0, 128, 128};
  bool plain = false;  // it is of one colour
};

// Outward normals n of the surface at points P, and `reach` = n . P: an eye at C sees a point where n . C is
// more than its reach. Elsewhere the target itself is in the way.
struct SurfaceNormals {
  alignas(64) std::array<float, kMaxPhotoPoints + 16> x{};
  alignas(64) std::array<float, kMaxPhotoPoints + 16> y{};
  alignas(64) std::array<float, kMaxPhotoPoints + 16> z{};
  alignas(64) std::array<float, kMaxPhotoPoints + 16> reach_mm{};
};

// Points in the target frame (origin at the centre of the rectangle, x right, y down, z away from the
// camera), S_in first, then S_out. Within each of the two the order is such that every leading part is spread
// evenly over the target, so a coarse evaluation reads just the first few.
struct PhotoModel {
  int inner = 0;        // points of S_in
  int outer = 0;        // points of S_out
  bool masked = false;  // it is known which points of S_in show the target
  alignas(64) std::array<float, kMaxPhotoPoints + 16> x_mm{};
  alignas(64) std::array<float, kMaxPhotoPoints + 16> y_mm{};
  alignas(64) std::array<float, kMaxPhotoPoints + 16> z_mm{};  // relief; zero = the flat model of the thesis
  SurfaceNormals normals;                                      // of S_in
  alignas(64) std::array<std::uint8_t, kMaxPhotoPoints + 64> hue{};
  // 1, or 0 where a point of S_in is not of the target but background: it is to have no say in alignment.
  // Where nothing is known of that, all 1 until a relief is learned.
  alignas(64) std::array<std::uint8_t, kMaxPhotoPoints + 64> weight{};
  std::array<PointColours, kColourLevels> colour{};  // of S_in, before what is behind the target at present
  PhotoBackdrop backdrop;                            // what was behind it in the photo
  // Added to how far behind its surface an eye must be: 0, or so much that a point is left out.
  alignas(64) std::array<float, kMaxPhotoPoints + 16> left_out_mm{};
  // Where the photo was taken from, in the target frame: a point of relief z lies on the ray from here
  // through its place (x, y, 0) on the flat model.
  Vector3 optical_centre_mm = Vector3::Zero();
  std::uint8_t background_hue = kHueUndefined;
  PhotoVotes votes;

  [[nodiscard]] int points() const { return inner + outer; }
};

// Errors: kBadRoi, kBadCamera, kBadModel (distance <= 0, points outside [20, limit], strip width outside (0,
// 1]), kNoHue (fewer than a tenth of the sampled points of the target have a hue).
[[nodiscard]] Status build_photo_model(const PhotoSource& source, const PhotoOptions& options,
                                       const HueLimits& limits, PhotoModel& model);

}  // namespace vergence
