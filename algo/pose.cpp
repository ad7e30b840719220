#include "algo/pose.hpp"

#include <cmath>

namespace vergence {
namespace {

// Quaternion (eta, e) with eta >= 0 from its vector part; e longer than 1 is scaled to 1.
struct Quaternion {
  double eta;
  Vector3 e;
};

Quaternion complete(const Vector3& e) {
  const double squared = e.squaredNorm();
  if (squared >= 1.0) return {0.0, e / std::sqrt(squared)};
  return {std::sqrt(1.0 - squared), e};
}

}  // namespace

Transform Transform::operator*(const Transform& other) const {
  return {R * other.R, R * other.t_mm + t_mm};
}

Transform Transform::inverse() const {
  const Matrix3 Rt = R.transpose();
  return {Rt, -(Rt * t_mm)};
}

Matrix3 rotation_from_quaternion_vector(const Vector3& e_in) {
  const auto [eta, e] = complete(e_in);
  const double e1 = e[0];
  const double e2 = e[1];
  const double e3 = e[2];
  Matrix3 R;
  R << 1 - 2 * e2 * e2 - 2 * e3 * e3, 2 * (e1 * e2 - eta * e3), 2 * (e1 * e3 + eta * e2),  //
      2 * (e1 * e2 + eta * e3), 1 - 2 * e1 * e1 - 2 * e3 * e3, 2 * (e2 * e3 - eta * e1),   //
      2 * (e1 * e3 - eta * e2), 2 * (e2 * e3 + eta * e1), 1 - 2 * e1 * e1 - 2 * e2 * e2;
  return R;
}

Vector3 quaternion_vector_from_rotation(const Matrix3& R) {
  // Shepperd's method: divide by the largest of the four components, so that no small number is divided by.
  const double trace = R.trace();
  if (trace > R(0, 0) && trace > R(1, 1) && trace > R(2, 2)) {
    const double s = 2 * std::sqrt(std::fmax(0.0, 1 + trace));  // 4 eta
    return Vector3{R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1)} / s;
  }
  int i = 0;
  if (R(1, 1) > R(i, i)) i = 1;
  if (R(2, 2) > R(i, i)) i = 2;
  const int j = (i + 1) % 3;
  const int k = (i + 2) % 3;
  const double s = 2 * std::sqrt(std::fmax(0.0, 1 + R(i, i) - R(j, j) - R(k, k)));  // 4 |e_i|
  if (s == 0.0) return Vector3::Zero();
  Vector3 e;
  e[i] = s / 4;
  e[j] = (R(j, i) + R(i, j)) / s;
  e[k] = (R(k, i) + R(i, k)) / s;
  const double eta = (R(k, j) - R(j, k)) / s;
  return eta < 0 ? Vector3(-e) : e;
}

Vector3 multiply_quaternion_vectors(const Vector3& a_in, const Vector3& b_in) {
  const auto [eta_a, a] = complete(a_in);
  const auto [eta_b, b] = complete(b_in);
  const Vector3 cross{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const Vector3 e = eta_a * b + eta_b * a + cross;
  const double eta = eta_a * eta_b - a.dot(b);
  return eta < 0 ? Vector3(-e) : e;
}

Transform to_transform(const Pose& pose) {
  return {rotation_from_quaternion_vector(pose.e), pose.position_mm};
}

Pose to_pose(const Transform& T) {
  return {T.t_mm, quaternion_vector_from_rotation(T.R)};
}

Matrix6 pose_jacobian(const Transform& T_H_M) {
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = T_H_M.R;
  // q (1, w / 2) has the vector part e + (eta w + e x w) / 2.
  const Vector3 e = quaternion_vector_from_rotation(T_H_M.R);
  const double rest = 1 - e.squaredNorm();
  const double eta = std::sqrt(rest > 0 ? rest : 0);
  Matrix3 cross;
  cross << 0, -e[2], e[1], e[2], 0, -e[0], -e[1], e[0], 0;
  J.bottomRightCorner<3, 3>() = 0.5 * (eta * Matrix3::Identity() + cross);
  return J;
}

bool is_valid(const Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(pose.position_mm[i]) || !std::isfinite(pose.e[i])) return false;
  }
  return pose.e.squaredNorm() <= 1.0;
}

}  // namespace vergence
