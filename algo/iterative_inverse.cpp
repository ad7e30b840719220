#include "algo/iterative_inverse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vergence {
namespace {

unsigned bit(int joint) {
  return 1U << static_cast<unsigned>(joint);
}

// The farthest the hand can be from where joint 2's frame begins, whatever the angles.
double reach_mm(const SerialArm& arm) {
  double reach = std::fabs(arm.dh[0].a_mm) + arm.T_flange_hand.t_mm.norm();
  for (int i = 1; i < arm.joints; ++i) {
    const DhRow& row = arm.dh[static_cast<std::size_t>(i)];
    reach += std::sqrt(row.a_mm * row.a_mm + row.d_mm * row.d_mm);
  }
  return reach;
}

class IkSearch {
 public:
  IkSearch(const SerialArm& arm, const Transform& T_W_H, const JointVector& q_start_rad,
           const IkOptions& options)
      : arm_(arm), target_(T_W_H), options_(options), q_(q_start_rad) {
    for (int i = arm.joints; i < kMaxJoints; ++i) q_[i] = 0;
    keep_within_limits();
    const Vector3 shoulder = arm.T_W_base * Vector3{0, 0, arm.dh[0].d_mm};
    is_beyond_reach_ = (T_W_H.t_mm - shoulder).norm() > reach_mm(arm) + options.position_tolerance_mm;
  }

  IkSolution run() {
    int nudges = 0;
    int iteration = 0;
    double reference = std::numeric_limits<double>::infinity();
    int since_reference = 0;
    bool has_stalled = false;
    for (;; ++iteration) {
      if (look()) return answer(IkResult::kReached, iteration);
      if (iteration == options_.iterations) break;
      step();
      if (++since_reference < kWindow) continue;
      if (!(recent_error_ < kProgress * reference)) {
        if (is_beyond_reach_ || nudges == kNudges) {
          has_stalled = true;
          break;
        }
        nudge(nudges++);
        reference = std::numeric_limits<double>::infinity();
      } else {
        reference = recent_error_;
      }
      recent_error_ = std::numeric_limits<double>::infinity();
      since_reference = 0;
    }
    return answer(why_not(has_stalled || nudges > 0), iteration);
  }

 private:
  static constexpr int kWindow = 15;  // iterations in which the error must fall
  static constexpr double kProgress = 0.95;
  static constexpr int kNudges = 3;
  static constexpr double kLargestStep_rad = 0.5;

  // Where the hand is now; true where that is where it should be.
  bool look() {
    frames_ = forward_kinematics(arm_, q_);
    error_ = pose_difference(frames_.T_W_H, target_);
    const double position = error_.head<3>().norm();
    const double rotation = error_.tail<3>().norm();
    error_.head<3>() /= options_.damping.length_mm;
    const double size = error_.norm();
    recent_error_ = std::min(recent_error_, size);
    if (size < best_error_) {
      best_error_ = size;
      best_ = {IkResult::kNotConverged, q_, position, rotation, 0, 0};
    }
    return position <= options_.position_tolerance_mm && rotation <= options_.rotation_tolerance_rad;
  }

  void step() {
    const ArmJacobian J = geometric_jacobian(arm_, frames_);
    // A far target pulls no harder than one a length away.
    const double size = error_.norm();
    const Vector6 pull = size > 1 ? Vector6(error_ / size) : error_;
    const double damping = 0.5 * pull.squaredNorm() + kLeastDamping;
    unsigned held = arm_.held;
    JointVector move = JointVector::Zero();
    for (int pass = 0; pass < arm_.joints; ++pass) {
      const ScaledJacobian scaled = scale(arm_, J, held, options_.damping.length_mm);
      move = inverse_step(scaled, pull, scaled.eigen.values.cwiseMax(0.0).array() + damping);
      const unsigned pushing = pushing_outwards(move) & ~held;
      if (pushing == 0) break;
      held |= pushing;
      for (int i = 0; i < arm_.joints; ++i) {
        if ((held & bit(i)) != 0) move[i] = 0;
      }
    }
    is_at_limit_ = held != arm_.held;
    const double largest = move.cwiseAbs().maxCoeff();
    if (largest > kLargestStep_rad) move *= kLargestStep_rad / largest;
    q_ += move;
    keep_within_limits();
  }

  [[nodiscard]] unsigned pushing_outwards(const JointVector& move) const {
    unsigned pushing = 0;
    for (int i = 0; i < arm_.joints; ++i) {
      const JointLimits& limits = arm_.limits[static_cast<std::size_t>(i)];
      const bool up = q_[i] >= limits.max_rad && move[i] > 0;
      const bool down = q_[i] <= limits.min_rad && move[i] < 0;
      if (up || down) pushing |= bit(i);
    }
    return pushing;
  }

  // Off a pose where every joint turns the hand across the way it should go. From the best so far; a little
  // more each time, and differently for each joint.
  void nudge(int nudges) {
    constexpr double kNudge_rad = 0.1;
    q_ = best_.q_rad;
    for (int i = 0; i < arm_.joints; ++i) {
      if ((arm_.held & bit(i)) != 0) continue;
      const double sign = ((i >> nudges) & 1) == 0 ? 1 : -1;
      q_[i] += sign * kNudge_rad * (1 + 2 * nudges) * (1 + 0.1 * i);
    }
    keep_within_limits();
  }

  void keep_within_limits() {
    for (int i = 0; i < arm_.joints; ++i) {
      if ((arm_.held & bit(i)) != 0) continue;
      const JointLimits& limits = arm_.limits[static_cast<std::size_t>(i)];
      q_[i] = std::clamp(q_[i], limits.min_rad, limits.max_rad);
    }
  }

  [[nodiscard]] IkResult why_not(bool has_stalled) const {
    if (is_beyond_reach_) return IkResult::kUnreachable;
    if (!has_stalled) return IkResult::kNotConverged;
    if (is_at_limit_) return IkResult::kAtLimit;
    return smallest_singular_value() < options_.damping.singular_value_floor ? IkResult::kSingular
                                                                             : IkResult::kUnreachable;
  }

  [[nodiscard]] double smallest_singular_value() const {
    const ArmJacobian J = geometric_jacobian(arm_, forward_kinematics(arm_, best_.q_rad));
    return scale(arm_, J, arm_.held, options_.damping.length_mm).smallest();
  }

  [[nodiscard]] IkSolution answer(IkResult result, int iterations) const {
    IkSolution solution = best_;
    solution.result = result;
    solution.iterations = iterations;
    solution.smallest_singular_value = smallest_singular_value();
    return solution;
  }

  static constexpr double kLeastDamping = 1e-12;

  const SerialArm& arm_;
  const Transform& target_;
  const IkOptions& options_;
  JointVector q_;
  ArmFrames frames_;
  Vector6 error_ = Vector6::Zero();  // in units of the length and rad
  double recent_error_ = std::numeric_limits<double>::infinity();
  double best_error_ = std::numeric_limits<double>::infinity();
  IkSolution best_;
  bool is_beyond_reach_ = false;
  bool is_at_limit_ = false;
};

bool is_sensible(const IkOptions& options) {
  return options.iterations >= 1 && options.iterations <= kMaxIkIterations && is_sensible(options.damping) &&
         options.position_tolerance_mm > 0 && options.position_tolerance_mm <= 1e9 &&
         options.rotation_tolerance_rad > 0 && options.rotation_tolerance_rad <= 1e9;
}

}  // namespace

const char* describe(IkResult result) {
  switch (result) {
    case IkResult::kReached: return "reached";
    case IkResult::kUnreachable: return "out of the arm's reach";
    case IkResult::kAtLimit: return "joint limits are in the way";
    case IkResult::kSingular: return "stuck at a singular pose of the arm";
    case IkResult::kNotConverged: return "not reached within the iterations";
    case IkResult::kBadInput: return "the arm, pose, joint angles or options are not usable";
  }
  return "unknown result";
}

IkSolution solve_ik_damped(const SerialArm& arm, const Transform& T_W_H, const JointVector& q_start_rad,
                           const IkOptions& options) {
  IkSolution refused;
  if (validate(arm) != Status::kOk || !are_joint_angles(arm, q_start_rad)) return refused;
  refused.q_rad.head(arm.joints) = q_start_rad.head(arm.joints);
  if (!is_rigid(T_W_H, 1e-6) || !is_sensible(options)) return refused;
  return IkSearch(arm, T_W_H, q_start_rad, options).run();
}

}  // namespace vergence
