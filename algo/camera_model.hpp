// Pinhole cameras with optional lens distortion, and the stereo rig they form [Eqs. 3.8, 5.8].
#pragma once

#include <array>

#include "algo/pose.hpp"

namespace vergence {

// Camera frame: x right, y down, z forward, mm. Pixel (0,0) is the CENTRE of the first pixel.
struct CameraModel {
  int width_px = 640;
  int height_px = 480;
  double fx_px = 800;  // f / eta_x
  double fy_px = 800;  // f / eta_y
  double cx_px = 320;
  double cy_px = 240;
  std::array<double, 5> distortion{};  // k1 k2 p1 p2 k3 in OpenCV's convention; all zero = none
  Transform T_H_C;                     // pose of the camera in the hand frame

  [[nodiscard]] bool has_distortion() const {
    const auto& [k1, k2, p1, p2, k3] = distortion;
    return (k1 != 0) | (k2 != 0) | (p1 != 0) | (p2 != 0) | (k3 != 0);
  }
};

struct StereoRig {
  CameraModel left;
  CameraModel right;
};

// Nearest depth that is projected; nearer points (and those behind the camera) are not in the image.
inline constexpr double kMinDepth_mm = 1.0;

// Image coordinates (u, v) in pixels of a point in the camera frame. False, and uv untouched, where the point
// is nearer than kMinDepth_mm. Points beside the image have coordinates all the same.
[[nodiscard]] bool project(const CameraModel& camera, const Vector3& p_C_mm, Vector2& uv_px);

// The same, and how (u, v) changes with the point: px a mm.
[[nodiscard]] bool project(const CameraModel& camera, const Vector3& p_C_mm, Vector2& uv_px,
                           Eigen::Matrix<double, 2, 3>& slope);

// Transform from the target frame to a camera's: T_C_M = inv(T_H_C) * T_H_M.
[[nodiscard]] Transform target_in_camera(const CameraModel& camera, const Transform& T_H_M);

}  // namespace vergence
