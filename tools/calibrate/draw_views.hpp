// A pair of pictures with the corners that were found, and by how much each misses its place.
#pragma once

#include <array>

#include "tools/calibrate/stereo.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::calibrate {

// How many times its length an error is drawn.
inline constexpr double kErrorMagnified = 50;

// Side by side: corners as green rings, the first one red, with their errors, magnified, as magenta lines;
// red frame where the view was left out.
[[nodiscard]] tools::RgbImage draw_view(const std::array<tools::GreyImage, 2>& images,
                                        const Sighting& sighting, const StereoView& view,
                                        const StereoCalibration& calibration, const Board& board);

}  // namespace vergence::calibrate
