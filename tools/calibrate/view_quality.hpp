// Whether views of a board are enough, and different enough, to tell all of a camera.
#pragma once

#include <string>
#include <vector>

#include "tools/calibrate/board.hpp"

namespace vergence::calibrate {

// Share of an image's cells (8 x 6 of them) that held a corner in any of the views.
[[nodiscard]] double image_coverage(const std::vector<const Corners*>& views, int width_px, int height_px);

struct ViewOfBoard {
  int number = 0;
  Transform T_C_B;
  const Corners* corners = nullptr;
};

// What is wrong with the choice of views, in words, with what to do.
[[nodiscard]] std::vector<std::string> judge_views(const std::vector<ViewOfBoard>& views, int width_px);

// Angle between the board and the image plane.
[[nodiscard]] double tilt_deg(const Transform& T_C_B);

}  // namespace vergence::calibrate
