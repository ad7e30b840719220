// Random poses, arms and joint angles, the same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>

#include "algo/arm_kinematics.hpp"

namespace vergence::testing {

class RandomArm {
 public:
  explicit RandomArm(std::uint64_t seed) : state_(seed) {}

  double between(double low, double high) {  // SplitMix64
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) / 9007199254740992.0);
  }

  Vector3 vector(double largest) {
    const double x = between(-largest, largest);
    const double y = between(-largest, largest);
    return {x, y, between(-largest, largest)};
  }

  Transform transform(double largest_mm) {
    const Matrix3 R = rotation_from_quaternion_vector(vector(0.57));
    return {R, vector(largest_mm)};
  }

  SerialArm arm(int joints) {
    SerialArm arm;
    arm.joints = joints;
    for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i) {
      arm.dh[i].a_mm = between(-400, 400);
      arm.dh[i].alpha_rad = between(-3.2, 3.2);
      arm.dh[i].d_mm = between(-400, 400);
      arm.dh[i].theta_offset_rad = between(-3.2, 3.2);
      const double range = between(1, 4);
      arm.limits[i] = {-range, range, between(1, 6), 10, 100};
    }
    arm.T_W_base = transform(500);
    arm.T_flange_hand = transform(200);
    return arm;
  }

  // Within the limits; zero where held.
  JointVector angles(const SerialArm& arm) {
    JointVector q = JointVector::Zero();
    for (int i = 0; i < arm.joints; ++i) {
      const JointLimits& limits = arm.limits[static_cast<std::size_t>(i)];
      const double angle = between(limits.min_rad, limits.max_rad);
      if ((arm.held >> static_cast<unsigned>(i) & 1U) == 0) q[i] = angle;
    }
    return q;
  }

  JointVector near(const SerialArm& arm, const JointVector& q, double most_rad) {
    JointVector moved = q;
    for (int i = 0; i < arm.joints; ++i) {
      const double by = between(-most_rad, most_rad);
      if ((arm.held >> static_cast<unsigned>(i) & 1U) == 0) moved[i] += by;
    }
    return moved;
  }

 private:
  std::uint64_t state_;
};

// How far apart two poses are, in mm and rad.
inline double distance_mm(const Transform& a, const Transform& b) {
  return pose_difference(a, b).head<3>().norm();
}
inline double distance_rad(const Transform& a, const Transform& b) {
  return pose_difference(a, b).tail<3>().norm();
}

}  // namespace vergence::testing
