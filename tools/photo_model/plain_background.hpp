// The background of a photo, where there is no photo of it alone: guessed from what is around the target.
#pragma once

#include <optional>

#include "algo/target_model.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::tools {

// What lies around the rectangle, its colours continued smoothly into it: each a quadratic function of place,
// least squares. Nothing where there is too little around it, where that is not plain, or not of the hue.
[[nodiscard]] std::optional<RgbImage> plain_background(const RgbImage& photo, const Rectangle& target,
                                                       double hue_deg);

}  // namespace vergence::tools
