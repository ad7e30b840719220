// Rigid poses: the six-vector [x y z e1 e2 e3] the genes encode, the transform it stands for, and
// their algebra (spec: position in mm, vector part of the unit quaternion with eta >= 0).
//
// Only + - * / and sqrt are used, so results are the same bits on every IEEE machine.
#pragma once

#include <Eigen/Core>

namespace vergence {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Pose of a frame B in a frame A as the method writes it [Eqs. 3.16-3.18].
struct Pose {
  Vector3 position_mm = Vector3::Zero();
  Vector3 e = Vector3::Zero();  // vector part of the unit quaternion; |e| <= 1, eta = +sqrt(1 - e.e)
};

// T_A_B: p_A = R * p_B + t_mm.
struct Transform {
  Matrix3 R = Matrix3::Identity();
  Vector3 t_mm = Vector3::Zero();

  [[nodiscard]] Vector3 operator*(const Vector3& p_mm) const { return R * p_mm + t_mm; }
  [[nodiscard]] Transform operator*(const Transform& other) const;
  [[nodiscard]] Transform inverse() const;
};

// Rotation matrix of the quaternion (eta, e) [Eq. 3.18]. Where |e| > 1, e is scaled to length 1 (a half
// turn).
[[nodiscard]] Matrix3 rotation_from_quaternion_vector(const Vector3& e);

// Vector part of the quaternion of a rotation matrix, with eta >= 0. Exact inverse of the above up to
// rounding.
[[nodiscard]] Vector3 quaternion_vector_from_rotation(const Matrix3& R);

// Vector part of the quaternion product a * b, sign chosen so that eta >= 0.
[[nodiscard]] Vector3 multiply_quaternion_vectors(const Vector3& a, const Vector3& b);

[[nodiscard]] Transform to_transform(const Pose& pose);
[[nodiscard]] Pose to_pose(const Transform& T);

// How a pose's six numbers [x y z e1 e2 e3] change with an increment [translation in mm; rotation vector in
// rad] in the target frame: T_H_M * {exp(w), t}. To first order; turns covariances of increments into those
// of poses, J C J^T.
[[nodiscard]] Matrix6 pose_jacobian(const Transform& T_H_M);

// True where every component is finite and |e| <= 1.
[[nodiscard]] bool is_valid(const Pose& pose);

}  // namespace vergence
