#include "algo/eye_mount.hpp"

#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

Matrix3 about_x(double angle_rad) {
  const auto [s, c] = sin_cos(angle_rad);
  Matrix3 R;
  R << 1, 0, 0, 0, c, -s, 0, s, c;
  return R;
}

Matrix3 about_y(double angle_rad) {
  const auto [s, c] = sin_cos(angle_rad);
  Matrix3 R;
  R << c, 0, s, 0, 1, 0, -s, 0, c;
  return R;
}

Transform turned(const Transform& T, double tilt_rad, double turn_about_y_rad) {
  // y points down, so looking down is a negative turn about x.
  return {T.R * about_x(-tilt_rad) * about_y(turn_about_y_rad), T.t_mm};
}

}  // namespace

Transform left_eye_in_hand(const Transform& T_H_C_at_zero, const EyeAngles& angles) {
  return turned(T_H_C_at_zero, angles.tilt_rad, angles.pan_left_rad);
}

Transform right_eye_in_hand(const Transform& T_H_C_at_zero, const EyeAngles& angles) {
  return turned(T_H_C_at_zero, angles.tilt_rad, -angles.pan_right_rad);
}

}  // namespace vergence
