// The thesis's arm, Mitsubishi Heavy Industries PA-10-7C: links, limits and mounting, and its inverse
// kinematics in closed form with the first joint held at zero [3.30].
//
// Joints S1 S2 S3 E1 E2 W1 W2. At zero the arm stands upright; S2, E1 and W1 bend it about the base's y axis,
// the others roll it. W is on the floor, z up, at the foot of the arm, which faces -x (T_W_base is half a
// turn about z). The hand's origin is the flange's centre; with z along the flange's axis, it is turned by
// -pi/2 about it, so that x is right and y down where W2 is zero and the hand looks ahead.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "algo/arm_kinematics.hpp"

namespace vergence {

// Lengths and limits with their sources: docs/arm_kinematics.md. Joint 1 is held.
[[nodiscard]] SerialArm pa10();

enum class Pa10Reach : std::uint8_t {
  kReachable,
  kTooFar,    // the wrist's centre is farther than the arm stretches from where S2 can take the elbow
  kTooNear,   // it is nearer to all of that than the arm folds
  kBadInput,  // arm of another make, pose not rigid to 1e-9, or an angle not finite
};

struct Pa10Solution {
  JointVector q_rad = JointVector::Zero();
  bool is_within_limits = false;
};

struct Pa10Inverse {
  Pa10Reach reach = Pa10Reach::kBadInput;
  int count = 0;
  std::array<Pa10Solution, kMaxArmSolutions> solutions{};
  double beyond_mm = 0;  // distance of the wrist's centre from what it can reach; limits do not count
  bool is_shoulder_singular = false;  // wrist's centre on S2's axis: S2 is free, and stays as it was
  bool is_elbow_singular = false;     // straight or folded: S3 is free, and stays as it was
  bool is_wrist_singular = false;     // of one solution or more: E2 and W2 share their turn evenly
};

// Every joint vector with S1 = 0 that puts the hand there: elbow to either side (E1), shoulder rolled to
// either side (S3), wrist flipped or not (E2). Eight, or fewer where the elbow is singular and branches are
// one. Each angle is the copy, modulo a full turn, nearest to q_previous_rad within the joint's limits. Reads
// lengths, limits and mounting from arm, which must have the joint axes of pa10().
[[nodiscard]] Pa10Inverse inverse_pa10(const SerialArm& arm, const Transform& T_W_H,
                                       const JointVector& q_previous_rad);

// Of those within limits, the one that takes the least time from q_previous_rad, as the root of the sum of
// squares of joint travel over joint speed. Nothing where none is within limits.
[[nodiscard]] std::optional<JointVector> nearest_solution(const SerialArm& arm, const Pa10Inverse& inverse,
                                                          const JointVector& q_previous_rad);

}  // namespace vergence
