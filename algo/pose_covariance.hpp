// How uncertain a pose is: from what is known of a small increment of it, [translation in mm; rotation vector
// in rad] in the target frame.
#pragma once

#include "algo/pose.hpp"

namespace vergence {

// Covariance of [x y z e1 e2 e3] (mm, 1) of T_H_M: J inv(information) J^T, exactly symmetric. `information`
// is the inverse covariance of the increment, positive definite.
[[nodiscard]] Matrix6 pose_covariance(const Matrix6& information, const Transform& T_H_M);

// The same where the increment's six numbers are independent, of such standard deviations.
[[nodiscard]] Matrix6 pose_covariance(const Vector6& deviation, const Transform& T_H_M);

}  // namespace vergence
