// Where the target is in a photo, by what differs from a photo of the bare background.
#pragma once

#include "algo/target_model.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::tools {

struct FoundTarget {
  GreyImage mask;  // 255 on the target
  Rectangle roi;   // around it
  int pixels = 0;
  int parts = 0;                // separate pieces
  bool touches_border = false;  // or nearly: part of it may be missing
};

// Both images of one size. A pixel belongs to the target where its luma and chroma differ from the
// background's by far more than the noise seen in the outer part of the picture, and not merely as a shadow
// does; then specks go, gaps close, holes fill, and the largest pieces stay. Nothing found: pixels = 0.
[[nodiscard]] FoundTarget find_target(const RgbImage& photo, const RgbImage& background);

// The rectangle around the non-zero pixels of a mask; width 0 where there are none.
[[nodiscard]] Rectangle bounding_rectangle(const GreyImage& mask);

}  // namespace vergence::tools
