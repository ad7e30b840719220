// Where a board of known corners is, from pictures by cameras that are known.
#pragma once

#include <array>

#include "algo/camera_model.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/stereo_fit.hpp"

namespace vergence::calibrate {

// T_C_B by one picture.
[[nodiscard]] Transform board_in_camera(const CameraModel& camera, const Board& board,
                                        const Corners& corners);

// T_CL_B by both.
[[nodiscard]] Transform board_in_left(const std::array<CameraModel, 2>& cameras, const Transform& T_CR_CL,
                                      const Board& board, const CornerPair& corners);

}  // namespace vergence::calibrate
