// Rotation vectors: axis times angle in rad, the form in which small turns add up and rates are steady.
#pragma once

#include "algo/pose.hpp"

namespace vergence {

// exp of a vector of any direction, up to 100 rad long. NaN where it is longer or not finite.
[[nodiscard]] Matrix3 rotation_from_vector(const Vector3& vector_rad);

// log of a rotation matrix, at most pi long; inverse of the above for turns below half a turn.
[[nodiscard]] Vector3 vector_from_rotation(const Matrix3& R);

}  // namespace vergence
