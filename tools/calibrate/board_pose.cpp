#include "tools/calibrate/board_pose.hpp"

#include <limits>

#include "tools/calibrate/least_squares.hpp"
#include "tools/calibrate/opencv_types.hpp"
#include "tools/calibrate/slopes.hpp"

namespace vergence::calibrate {

Transform board_in_camera(const CameraModel& camera, const Board& board, const Corners& corners) {
  cv::Mat rotation;
  cv::Mat translation;
  cv::solvePnP(board_points(board), image_points(corners), camera_matrix(camera), distortion_of(camera),
               rotation, translation);
  return transform_of(rotation, translation);
}

Transform board_in_left(const std::array<CameraModel, 2>& cameras, const Transform& T_CR_CL,
                        const Board& board, const CornerPair& corners) {
  const auto evaluate = [&](const Transform& T_CL_B, NormalEquations* equations) {
    double squares = 0;
    for (std::size_t i = 0; i < board.corners(); ++i) {
      const Vector3 p_B = board.corner_mm(i);
      const Vector3 p_L = T_CL_B * p_B;
      for (std::size_t side = 0; side < 2; ++side) {
        Vector2 uv;
        Eigen::Matrix<double, 2, 3> by_point;
        if (!project(cameras[side], side == 0 ? p_L : T_CR_CL * p_L, uv, by_point))
          return std::numeric_limits<double>::infinity();
        const Vector2 r = uv - corners[side][i];
        squares += r.squaredNorm();
        if (equations == nullptr) continue;
        if (side == 1) by_point *= T_CR_CL.R;
        const Eigen::Matrix<double, 2, 6> J = by_point * pose_slope(T_CL_B, p_B);
        equations->JtJ += J.transpose() * J;
        equations->Jtr += J.transpose() * r;
      }
    }
    return squares;
  };
  Transform T_CL_B = board_in_camera(cameras[0], board, corners[0]);
  minimise(T_CL_B, 6, evaluate, [](const Transform& T, const Eigen::VectorXd& increment) {
    return moved(T, increment.head<6>());
  });
  return T_CL_B;
}

}  // namespace vergence::calibrate
