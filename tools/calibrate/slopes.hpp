// How points and pixels change with poses and cameras: the pieces that the fits' Jacobians are made of.
//
// Poses change by increments [translation in mm; rotation vector in rad] in their own frame, T * {exp(w), t},
// as in pose_jacobian().
#pragma once

#include "algo/camera_model.hpp"
#include "algo/rotation_vector.hpp"

namespace vergence::calibrate {

using Slope3x6 = Eigen::Matrix<double, 3, 6>;

// fx fy cx cy k1 k2 p1 p2 k3, in this order.
inline constexpr int kIntrinsics = 9;

[[nodiscard]] inline Transform moved(const Transform& T, const Vector6& increment) {
  return T * Transform{rotation_from_vector(increment.tail<3>()), increment.head<3>()};
}

[[nodiscard]] inline Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 S;
  S << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return S;
}

// Of T * p by T's increment.
[[nodiscard]] inline Slope3x6 pose_slope(const Transform& T, const Vector3& p) {
  Slope3x6 slope;
  slope << T.R, -T.R * cross_matrix(p);
  return slope;
}

// Of q = inverse(T) * p by T's increment.
[[nodiscard]] inline Slope3x6 inverse_pose_slope(const Vector3& q) {
  Slope3x6 slope;
  slope << -Matrix3::Identity(), cross_matrix(q);
  return slope;
}

// Of a point's pixel by the camera's intrinsics.
[[nodiscard]] inline Eigen::Matrix<double, 2, kIntrinsics> intrinsic_slope(const CameraModel& camera,
                                                                           const Vector3& p_C,
                                                                           const Vector2& uv) {
  const double x = p_C[0] / p_C[2];
  const double y = p_C[1] / p_C[2];
  const double r2 = x * x + y * y;
  const double fx = camera.fx_px;
  const double fy = camera.fy_px;
  Eigen::Matrix<double, 2, kIntrinsics> slope;
  slope << (uv[0] - camera.cx_px) / fx, 0, 1, 0, fx * x * r2, fx * x * r2 * r2, 2 * fx * x * y,
      fx * (r2 + 2 * x * x), fx * x * r2 * r2 * r2,  //
      0, (uv[1] - camera.cy_px) / fy, 0, 1, fy * y * r2, fy * y * r2 * r2, fy * (r2 + 2 * y * y),
      2 * fy * x * y, fy * y * r2 * r2 * r2;
  return slope;
}

inline void add_to_intrinsics(CameraModel& camera, const Eigen::Matrix<double, kIntrinsics, 1>& increment) {
  camera.fx_px += increment[0];
  camera.fy_px += increment[1];
  camera.cx_px += increment[2];
  camera.cy_px += increment[3];
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    camera.distortion[i] += increment[4 + static_cast<Eigen::Index>(i)];
}

}  // namespace vergence::calibrate
