// The estimated model drawn over both images, side by side: what a person looks at to believe a pose.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "tools/io/dataset.hpp"
#include "tools/io/image_file.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::tools {

// Left and right image side by side; over each, in magenta, the outline of the balls, or of the photo's
// rectangle and (thin) of S_in as it is posed, relief included; the balls' centres or some points of S_in,
// coloured by their relief with a legend, or by their hues where the model is flat; the target's axes (x red,
// y green, z blue), and a line of text. The true outline, where it is known, is thin and white.
struct Overlay {
  const Target& target;
  const PhotoModel* photo_model = nullptr;  // of a photo-model, as it is known by now
  std::array<CameraModel, 2> cameras;       // left and right, where they were in the hand at the frame
  Pose T_H_M;
  std::optional<Pose> true_T_H_M;
  std::string text;
};
[[nodiscard]] RgbImage draw_overlay(const Overlay& overlay, const RgbImage& left, const RgbImage& right);

// Of a frame of a data set.
[[nodiscard]] RgbImage draw_overlay(const Dataset& dataset, const Estimator& estimator,
                                    const FrameResult& result, const RgbImage& left, const RgbImage& right);

// "frame 7  tracking  confidence ...", as it stands below the pictures.
[[nodiscard]] std::string overlay_text(std::uint64_t frame, const Estimate& estimate);

// S_in (dots in the colour of the photo's hue, black where there is none, grey in the rim around the target)
// and S_out (white) over the photo.
[[nodiscard]] RgbImage draw_photo_model(const RgbImage& photo, const PhotoSource& source,
                                        const PhotoModel& model);

}  // namespace vergence::tools
