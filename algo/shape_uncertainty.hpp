// What a photo-model's shape leaves open of its pose, however sharply the images fix it: a surface that is
// known only to a part of a millimetre may as well lie a little nearer, and be tilted a little.
#pragma once

#include <cstdint>

#include "algo/pose.hpp"

namespace vergence {

enum class ShapeKnowledge : std::uint8_t {
  kNone,         // flat, or inflated
  kYoungRelief,  // learned from few frames
  kRelief,
};

// Standard deviations of the increment [translation in mm; rotation vector in rad] in the target frame.
// `misfit` of left with right, 0 .. 1 (Alignment::pairing_cost): the worse the two fit each other on the
// model, the less of the shape is known. Measured: docs/refine.md.
[[nodiscard]] Vector6 shape_deviation(ShapeKnowledge knowledge, double misfit);

}  // namespace vergence
