// What lies behind a target. Where the silhouette of a photo-model is known, some of what its points show is
// the photo's background: the rim around the target and, at low resolution, a share of every square near its
// edge. Rarely is a target looked for before that background again. So the model's colours are composed anew
// for every pair of images: the target before what most of the images show.
#pragma once

#include <array>

#include "algo/colour.hpp"
#include "algo/colour_pyramid.hpp"
#include "algo/target_model.hpp"

namespace vergence {

// Mean of a photo's backdrop over the first `points` points, and whether its chroma varies little, at a
// quarter of the resolution: textures are of one colour.
void sum_up_backdrop(int points, PhotoBackdrop& backdrop);

// What most of a pair of images shows.
struct Backdrop {
  YCbCr colour{0, 128, 128};  // full range, as a photo's
  bool plain = false;         // most of the pixels are like it
};

// The medians of luma, cb and cr of both images at an eighth of their resolution. `limited_range`: the
// pyramids were made of YUV images.
[[nodiscard]] Backdrop find_backdrop(const ColourPyramid& left, const ColourPyramid& right,
                                     bool limited_range);

// How far a model is to be composed anew, 0 (as photographed) .. 256: by how much the chroma of the two
// backgrounds, over their luma, differs, so that more or less light makes no other background; 256 where the
// photo's is of many colours.
[[nodiscard]] int backdrop_change(const PhotoBackdrop& of_photo, const Backdrop& of_images);

// Colours of a model's S_in before another background: where a share w of a square shows the photo's,
//   c + w change / 256 (seen - photo's).
// `as_photographed` are the model's own.
void put_before(const Backdrop& backdrop, int change,
                const std::array<PointColours, kColourLevels>& as_photographed, PhotoModel& model);

// Whether the points that are not of the target, its rim, are left out of correlation: before a background of
// many colours nobody knows what is behind them.
void leave_rim_out(bool left_out, PhotoModel& model);

}  // namespace vergence
