// Joint angles for a pose of the hand, for any serial arm, by a bounded number of iterations.
#pragma once

#include <cstdint>

#include "algo/damped_velocity.hpp"

namespace vergence {

enum class IkResult : std::uint8_t {
  kReached,       // within both tolerances
  kUnreachable,   // beyond the stretched arm, or its joints are too few for the pose; q is as near as was
                  // found
  kAtLimit,       // joint limits keep the arm from coming nearer
  kSingular,      // stuck where the arm has lost a direction
  kNotConverged,  // the iterations are used up and it was still getting nearer
  kBadInput,  // arm not valid, pose not rigid, angles or options out of range; q is the start where finite
};

// What happened, in words, for people.
[[nodiscard]] const char* describe(IkResult result);

struct IkOptions {
  int iterations = 200;  // 1 to kMaxIkIterations
  double position_tolerance_mm = 1e-6;
  double rotation_tolerance_rad = 1e-9;
  Damping damping;
};

struct IkSolution {
  IkResult result = IkResult::kBadInput;
  JointVector q_rad = JointVector::Zero();  // within the limits, held joints as at the start
  double position_error_mm = 0;
  double rotation_error_rad = 0;
  double smallest_singular_value = 0;
  int iterations = 0;
};

// Levenberg-Marquardt from q_start_rad, the damping half the squared error [Sugihara 2011], so that poses out
// of reach are approached instead of chased; joints at a limit leave the game while they push outwards. Where
// it stalls, the arm is nudged, three times at most. A start outside the limits is taken to the nearest one.
[[nodiscard]] IkSolution solve_ik_damped(const SerialArm& arm, const Transform& T_W_H,
                                         const JointVector& q_start_rad, const IkOptions& options = {});

}  // namespace vergence
