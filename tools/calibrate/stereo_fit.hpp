// Both cameras, the pose between them and the board's pose in every view, fitted together to all corners.
//
// Together, because each camera then also profits from what the other saw: the board has one pose in both.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "algo/camera_model.hpp"
#include "tools/calibrate/board.hpp"

namespace vergence::calibrate {

using CornerPair = std::array<Corners, 2>;  // of left and right, of the same view

struct StereoFit {
  std::array<CameraModel, 2> cameras;  // T_H_C is not used
  std::array<bool, 2> with_k3{true, true};
  Transform T_CR_CL;
  std::vector<Transform> T_CL_B;  // one a view

  double squares_px2 = 0;      // sum of squared distances, both cameras
  Eigen::MatrixXd covariance;  // of the intrinsics of both (kIntrinsics each), T_CR_CL, and T_CL_B by views
};

// What is given is where the fit starts. Throws std::runtime_error where the views do not determine the
// cameras.
void fit_stereo(const std::vector<CornerPair>& views, const Board& board, StereoFit& fit);

// A camera by itself, then the pose between both: where to start. Throws std::runtime_error as above.
[[nodiscard]] StereoFit start_stereo(const std::vector<CornerPair>& views, const Board& board, int width_px,
                                     int height_px);

// Root mean square distance between the corners and where the board at T_C_B has them.
[[nodiscard]] double reprojection_rms_px(const CameraModel& camera, const Transform& T_C_B,
                                         const Board& board, const Corners& corners);

// Distances of the corners from the epipolar lines of their partners, in both images; undistorted, in pixels.
struct EpipolarError {
  double rms_px = 0;
  double largest_px = 0;
};
[[nodiscard]] EpipolarError epipolar_error(const std::array<CameraModel, 2>& cameras,
                                           const Transform& T_CR_CL, const std::vector<CornerPair>& views);

// The direction (x, y, 1) that a camera sees at a pixel.
[[nodiscard]] Vector3 ray(const CameraModel& camera, const Vector2& uv_px);

}  // namespace vergence::calibrate
