// Which pixels of a photo show its target, where that is known, and the rim around them.
#pragma once

#include <optional>

#include "algo/target_model.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::tools {

// Both of the photo's size, non-zero where it is so, and nothing beside the rectangle.
struct Silhouette {
  GreyImage target;
  GreyImage with_rim;  // a rim of background, whose contrast with the target is worth seeing
};

[[nodiscard]] Silhouette with_rim(const GreyImage& target, const Rectangle& roi);

// What differs from a photo of the bare background. Nothing where that is so little of the rectangle, or all
// of it, that the two photos are no pair.
[[nodiscard]] std::optional<Silhouette> silhouette_before(const RgbImage& background, const RgbImage& photo,
                                                          const Rectangle& roi);

// What differs from the surroundings of the rectangle, where these are plain and of that hue; nothing else.
[[nodiscard]] std::optional<Silhouette> silhouette_before_plain(double hue_deg, const RgbImage& photo,
                                                                const Rectangle& roi);

}  // namespace vergence::tools
