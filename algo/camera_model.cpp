#include "algo/camera_model.hpp"

namespace vergence {

bool project(const CameraModel& camera, const Vector3& p_C_mm, Vector2& uv_px) {
  if (!(p_C_mm[2] >= kMinDepth_mm)) return false;
  const double x = p_C_mm[0] / p_C_mm[2];
  const double y = p_C_mm[1] / p_C_mm[2];
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  uv_px = {camera.fx_px * xd + camera.cx_px, camera.fy_px * yd + camera.cy_px};
  return true;
}

bool project(const CameraModel& camera, const Vector3& p_C_mm, Vector2& uv_px,
             Eigen::Matrix<double, 2, 3>& slope) {
  if (!project(camera, p_C_mm, uv_px)) return false;
  const double inverse = 1 / p_C_mm[2];
  const double x = p_C_mm[0] * inverse;
  const double y = p_C_mm[1] * inverse;
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  const double across = 2 * x * y * radial_slope + 2 * p1 * x + 2 * p2 * y;
  Eigen::Matrix2d lens;
  lens << radial + 2 * x * x * radial_slope + 2 * p1 * y + 6 * p2 * x, across,  //
      across, radial + 2 * y * y * radial_slope + 6 * p1 * y + 2 * p2 * x;
  Eigen::Matrix<double, 2, 3> ray;
  ray << inverse, 0, -x * inverse, 0, inverse, -y * inverse;
  slope = Vector2{camera.fx_px, camera.fy_px}.asDiagonal() * lens * ray;
  return true;
}

Transform target_in_camera(const CameraModel& camera, const Transform& T_H_M) {
  return camera.T_H_C.inverse() * T_H_M;
}

}  // namespace vergence
