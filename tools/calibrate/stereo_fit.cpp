#include "tools/calibrate/stereo_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tools/calibrate/least_squares.hpp"
#include "tools/calibrate/opencv_types.hpp"
#include "tools/calibrate/slopes.hpp"

namespace vergence::calibrate {
namespace {

// Where the parameters are.
constexpr int kBetween = 2 * kIntrinsics;  // T_CR_CL
constexpr int kViews = kBetween + 6;       // T_CL_B of the first view
constexpr int kK3 = kIntrinsics - 1;

constexpr const char* kUndetermined = "the views do not determine the cameras";

// What one view depends on: the shared parameters, then its own pose.
constexpr int kOfView = kViews + 6;
struct ViewEquations {
  Eigen::Matrix<double, kOfView, kOfView> JtJ = Eigen::Matrix<double, kOfView, kOfView>::Zero();
  Eigen::Matrix<double, kOfView, 1> Jtr = Eigen::Matrix<double, kOfView, 1>::Zero();
  double squares = 0;

  void add(const Eigen::Matrix<double, 2, kOfView>& J, const Vector2& r, bool with_slopes) {
    squares += r.squaredNorm();
    if (!with_slopes) return;
    JtJ.noalias() += J.transpose() * J;
    Jtr.noalias() += J.transpose() * r;
  }
};

// False where a corner is not in front of a camera.
bool add_view(const StereoFit& fit, const Transform& T_CL_B, const Board& board, const CornerPair& corners,
              bool with_slopes, ViewEquations& equations) {
  for (std::size_t i = 0; i < board.corners(); ++i) {
    const Vector3 p_B = board.corner_mm(i);
    const Vector3 p_L = T_CL_B * p_B;
    const Vector3 p_R = fit.T_CR_CL * p_L;
    const Slope3x6 by_view = pose_slope(T_CL_B, p_B);
    for (std::size_t side = 0; side < 2; ++side) {
      const bool is_left = side == 0;
      const Vector3& p_C = is_left ? p_L : p_R;
      Vector2 uv;
      Eigen::Matrix<double, 2, 3> by_point;
      if (!project(fit.cameras[side], p_C, uv, by_point)) return false;
      Eigen::Matrix<double, 2, kOfView> J = Eigen::Matrix<double, 2, kOfView>::Zero();
      const int first = static_cast<int>(side) * kIntrinsics;
      J.middleCols<kIntrinsics>(first) = intrinsic_slope(fit.cameras[side], p_C, uv);
      if (!fit.with_k3[side]) J.col(first + kK3).setZero();
      if (is_left) {
        J.rightCols<6>() = by_point * by_view;
      } else {
        J.middleCols<6>(kBetween) = by_point * pose_slope(fit.T_CR_CL, p_L);
        J.rightCols<6>() = by_point * fit.T_CR_CL.R * by_view;
      }
      equations.add(J, uv - corners[side][i], with_slopes);
    }
  }
  return true;
}

double evaluate(const StereoFit& fit, const Board& board, const std::vector<CornerPair>& views,
                NormalEquations* all) {
  double squares = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    ViewEquations of_view;
    if (!add_view(fit, fit.T_CL_B[v], board, views[v], all != nullptr, of_view))
      return std::numeric_limits<double>::infinity();
    squares += of_view.squares;
    if (all == nullptr) continue;
    const auto own = kViews + 6 * static_cast<Eigen::Index>(v);
    all->JtJ.topLeftCorner<kViews, kViews>() += of_view.JtJ.topLeftCorner<kViews, kViews>();
    all->JtJ.block<kViews, 6>(0, own) = of_view.JtJ.topRightCorner<kViews, 6>();
    all->JtJ.block<6, kViews>(own, 0) = of_view.JtJ.bottomLeftCorner<6, kViews>();
    all->JtJ.block<6, 6>(own, own) = of_view.JtJ.bottomRightCorner<6, 6>();
    all->Jtr.head<kViews>() += of_view.Jtr.head<kViews>();
    all->Jtr.segment<6>(own) = of_view.Jtr.tail<6>();
  }
  return squares;
}

StereoFit plus(StereoFit fit, const Eigen::VectorXd& increments) {
  add_to_intrinsics(fit.cameras[0], increments.head<kIntrinsics>());
  add_to_intrinsics(fit.cameras[1], increments.segment<kIntrinsics>(kIntrinsics));
  fit.T_CR_CL = moved(fit.T_CR_CL, increments.segment<6>(kBetween));
  for (std::size_t v = 0; v < fit.T_CL_B.size(); ++v)
    fit.T_CL_B[v] = moved(fit.T_CL_B[v], increments.segment<6>(kViews + 6 * static_cast<Eigen::Index>(v)));
  return fit;
}

}  // namespace

void fit_stereo(const std::vector<CornerPair>& views, const Board& board, StereoFit& fit) {
  const auto parameters = kViews + 6 * static_cast<Eigen::Index>(views.size());
  const auto residuals = [&](const StereoFit& f, NormalEquations* equations) {
    return evaluate(f, board, views, equations);
  };
  fit.covariance.resize(0, 0);  // not carried along while it is improved
  for (std::size_t side = 0; side < 2; ++side) {
    if (!fit.with_k3[side]) fit.cameras[side].distortion[4] = 0;
  }
  fit.squares_px2 = minimise(fit, parameters, residuals, plus);
  NormalEquations equations(parameters);
  evaluate(fit, board, views, &equations);
  const auto inverted = inverse(equations.JtJ);
  if (!std::isfinite(fit.squares_px2) || !inverted) throw std::runtime_error(kUndetermined);
  const double left_over =
      static_cast<double>(4 * board.corners() * views.size()) - static_cast<double>(parameters);
  fit.covariance = *inverted * (fit.squares_px2 / left_over);
}

StereoFit start_stereo(const std::vector<CornerPair>& views, const Board& board, int width_px,
                       int height_px) {
  const cv::Size size(width_px, height_px);
  const std::vector<std::vector<cv::Point3f>> objects(views.size(), board_points(board));
  std::array<std::vector<std::vector<cv::Point2f>>, 2> images;
  for (const CornerPair& view : views) {
    for (std::size_t side = 0; side < 2; ++side) images[side].push_back(image_points(view[side]));
  }
  StereoFit fit;
  try {
    std::array<cv::Mat, 2> K;
    std::array<cv::Mat, 2> k;
    std::array<std::vector<cv::Mat>, 2> rotations;
    std::array<std::vector<cv::Mat>, 2> translations;
    for (std::size_t side = 0; side < 2; ++side) {
      // Without k3: of few views it would lead astray.
      cv::calibrateCamera(objects, images[side], size, K[side], k[side], rotations[side], translations[side],
                          cv::CALIB_FIX_K3);
      fit.cameras[side] = camera_of(K[side], k[side], size);
    }
    cv::Mat R;
    cv::Mat t;
    cv::Mat essential;
    cv::Mat fundamental;
    cv::stereoCalibrate(objects, images[0], images[1], K[0], k[0], K[1], k[1], size, R, t, essential,
                        fundamental, cv::CALIB_FIX_INTRINSIC);
    fit.T_CR_CL = transform_of(R, t);
    for (std::size_t v = 0; v < views.size(); ++v)
      fit.T_CL_B.push_back(transform_of(rotations[0][v], translations[0][v]));
  } catch (const cv::Exception&) {
    throw std::runtime_error(kUndetermined);
  }
  return fit;
}

double reprojection_rms_px(const CameraModel& camera, const Transform& T_C_B, const Board& board,
                           const Corners& corners) {
  double squares = 0;
  for (std::size_t i = 0; i < board.corners(); ++i) {
    Vector2 uv;
    if (!project(camera, T_C_B * board.corner_mm(i), uv)) return HUGE_VAL;
    squares += (uv - corners[i]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(board.corners()));
}

Vector3 ray(const CameraModel& camera, const Vector2& uv_px) {
  constexpr int kSteps = 20;
  constexpr double kScale_mm = 1000;  // of the point that is projected
  Vector3 p{(uv_px[0] - camera.cx_px) / camera.fx_px * kScale_mm,
            (uv_px[1] - camera.cy_px) / camera.fy_px * kScale_mm, kScale_mm};
  for (int step = 0; step < kSteps; ++step) {
    Vector2 uv;
    Eigen::Matrix<double, 2, 3> slope;
    if (!project(camera, p, uv, slope)) break;
    const Vector2 correction = slope.leftCols<2>().inverse() * (uv - uv_px);
    p.head<2>() -= correction;
    if (correction.norm() < 1e-10 * kScale_mm) break;
  }
  return p / kScale_mm;
}

EpipolarError epipolar_error(const std::array<CameraModel, 2>& cameras, const Transform& T_CR_CL,
                             const std::vector<CornerPair>& views) {
  const Matrix3 E = cross_matrix(T_CR_CL.t_mm) * T_CR_CL.R;
  const auto distance_px = [](const CameraModel& camera, const Vector3& line, const Vector3& point) {
    // Along the line's normal a pixel is 1 / fx to 1 / fy wide.
    const Vector2 normal{line[0] / camera.fx_px, line[1] / camera.fy_px};
    return std::abs(line.dot(point)) / normal.norm();
  };
  EpipolarError error;
  std::size_t count = 0;
  for (const CornerPair& view : views) {
    for (std::size_t i = 0; i < view[0].size(); ++i) {
      const Vector3 left = ray(cameras[0], view[0][i]);
      const Vector3 right = ray(cameras[1], view[1][i]);
      const double d_right = distance_px(cameras[1], E * left, right);
      const double d_left = distance_px(cameras[0], E.transpose() * right, left);
      error.rms_px += d_left * d_left + d_right * d_right;
      error.largest_px = std::max({error.largest_px, d_left, d_right});
      count += 2;
    }
  }
  error.rms_px = count > 0 ? std::sqrt(error.rms_px / static_cast<double>(count)) : 0;
  return error;
}

}  // namespace vergence::calibrate
