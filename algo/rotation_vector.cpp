#include "algo/rotation_vector.hpp"

#include <algorithm>
#include <cmath>

#include "algo/trigonometry.hpp"

namespace vergence {

Matrix3 rotation_from_vector(const Vector3& vector_rad) {
  const double angle = vector_rad.norm();
  const auto [sine, cosine] = sin_cos(angle);
  // (1 - cos) / angle^2 as sin^2 / (angle^2 (1 + cos)) keeps its digits where the angle is small.
  const double s = angle > 0 ? sine / angle : 1.0;
  const double c = cosine > 0 ? s * s / (1 + cosine) : (1 - cosine) / (angle * angle);
  Matrix3 S;
  S << 0, -vector_rad[2], vector_rad[1], vector_rad[2], 0, -vector_rad[0], -vector_rad[1], vector_rad[0], 0;
  return Matrix3::Identity() + s * S + c * (S * S);
}

Vector3 vector_from_rotation(const Matrix3& R) {
  const Vector3 e = quaternion_vector_from_rotation(R);
  const double squared = e.squaredNorm();
  const double sine = std::sqrt(squared);
  // The angle over its half's sine, which is 2 where the angle vanishes.
  const double ratio = sine > 0 ? 2 * arc_tangent2(sine, std::sqrt(std::max(1 - squared, 0.0))) / sine : 2.0;
  return ratio * e;
}

}  // namespace vergence
