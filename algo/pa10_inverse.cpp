// Closed-form inverse kinematics of the PA-10 with S1 = 0. In the shoulder's frame, axes as the base's,
//   T = Ry(q2) Tz(d3) Rz(q3) Ry(q4) Tz(d5) Rz(q5) Ry(q6) Rz(q7) Tz(d7).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "algo/pa10.hpp"
#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

constexpr double kPi = std::numbers::pi;

// Farther out of reach than this is out of reach; nearer is rounding, and the nearest pose is answered.
constexpr double kReachTolerance_mm = 1e-9;
// Lever arms below which the angle about an axis is free: what rounding leaves of none, well below the
// accuracy that is promised.
constexpr double kShoulderLever_mm = 1e-10;
constexpr double kElbowLever_mm = 1e-4;  // error of second order, 5e-12 mm
constexpr double kOutOfPlane_mm = 1e-10;
constexpr double kWristLever = 5e-13;

Matrix3 about_y(double angle_rad) {
  const auto [s, c] = sin_cos(angle_rad);
  Matrix3 R;
  R << c, 0, s, 0, 1, 0, -s, 0, c;
  return R;
}

Matrix3 about_z(double angle_rad) {
  const auto [s, c] = sin_cos(angle_rad);
  Matrix3 R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

double wrapped(double angle_rad) {
  return angle_rad - 2 * kPi * std::floor(angle_rad / (2 * kPi) + 0.5);
}

bool is_pa10(const SerialArm& arm) {
  if (arm.joints != 7 || validate(arm) != Status::kOk) return false;
  constexpr double kTwists[] = {-kPi / 2, kPi / 2, -kPi / 2, kPi / 2, -kPi / 2, kPi / 2, 0};
  for (std::size_t i = 0; i < arm.dh.size(); ++i) {
    const DhRow& row = arm.dh[i];
    if (std::fabs(row.alpha_rad - kTwists[i]) > 1e-12 || row.a_mm != 0 || row.theta_offset_rad != 0)
      return false;
    if (i % 2 == 1 && row.d_mm != 0) return false;
  }
  return arm.dh[2].d_mm >= 1 && arm.dh[4].d_mm >= 1;
}

class Solver {
 public:
  Solver(const SerialArm& arm, const Transform& T_W_H, const JointVector& q_previous_rad)
      : arm_(arm), previous_(q_previous_rad), upper_mm_(arm.dh[2].d_mm), fore_mm_(arm.dh[4].d_mm) {
    const Transform T_base_flange = arm.T_W_base.inverse() * T_W_H * arm.T_flange_hand.inverse();
    R_ = T_base_flange.R;
    wrist_mm_ = T_base_flange.t_mm - arm.dh[6].d_mm * R_.col(2) - Vector3{0, 0, arm.dh[0].d_mm};
    radius_mm_ = std::sqrt(wrist_mm_[0] * wrist_mm_[0] + wrist_mm_[2] * wrist_mm_[2]);
  }

  Pa10Inverse run() {
    if (!judge_reach()) return answer_;
    const double squared = wrist_mm_.squaredNorm();
    double c4 = (squared - upper_mm_ * upper_mm_ - fore_mm_ * fore_mm_) / (2 * upper_mm_ * fore_mm_);
    c4 = std::clamp(c4, -1.0, 1.0);
    double s4 = std::sqrt((1 - c4) * (1 + c4));
    const double y = wrist_mm_[1];
    // Nearly straight, the cosine cannot tell how much the elbow must bend to come out of S2's plane.
    if (fore_mm_ * s4 < std::fabs(y)) {
      s4 = std::min(std::fabs(y) / fore_mm_, 1.0);
      c4 = std::copysign(std::sqrt((1 - s4) * (1 + s4)), c4);
    }
    if (fore_mm_ * s4 < kElbowLever_mm && std::fabs(y) < kOutOfPlane_mm) {
      answer_.is_elbow_singular = true;
      const double q4 = c4 > 0 ? 0 : kPi;
      with_shoulder(previous_[2], q4, 0, upper_mm_ + fore_mm_ * (c4 > 0 ? 1 : -1));
      return answer_;
    }
    // What the forearm reaches along and across the upper arm, in S2's plane.
    const double along = upper_mm_ + fore_mm_ * c4;
    const double lever = fore_mm_ * s4;
    const double across_squared = radius_mm_ < lever
                                      ? (radius_mm_ - std::fabs(along)) * (radius_mm_ + std::fabs(along))
                                      : (lever - std::fabs(y)) * (lever + std::fabs(y));
    const double across = std::sqrt(std::max(across_squared, 0.0));
    const double q4 = arc_tangent2(s4, c4);
    for (const double elbow : {1.0, -1.0}) {
      for (const double side : {1.0, -1.0}) {
        with_shoulder(arc_tangent2(elbow * y, elbow * side * across), elbow * q4, side * across, along);
      }
    }
    return answer_;
  }

 private:
  // The elbow moves on a circle about S2; the wrist's centre can be as near to it, and as far, as the forearm
  // is long.
  bool judge_reach() {
    const double y = wrist_mm_[1];
    const double nearest = std::sqrt((radius_mm_ - upper_mm_) * (radius_mm_ - upper_mm_) + y * y);
    const double farthest = std::sqrt((radius_mm_ + upper_mm_) * (radius_mm_ + upper_mm_) + y * y);
    answer_.reach = Pa10Reach::kReachable;
    if (nearest > fore_mm_ + kReachTolerance_mm) {
      answer_.reach = Pa10Reach::kTooFar;
      answer_.beyond_mm = nearest - fore_mm_;
    } else if (farthest < fore_mm_ - kReachTolerance_mm) {
      answer_.reach = Pa10Reach::kTooNear;
      answer_.beyond_mm = fore_mm_ - farthest;
    }
    return answer_.reach == Pa10Reach::kReachable;
  }

  // S2 turns (across, along), in its plane, onto the wrist's centre.
  void with_shoulder(double q3, double q4, double across_mm, double along_mm) {
    double q2 = previous_[1];
    if (radius_mm_ < kShoulderLever_mm) {
      answer_.is_shoulder_singular = true;
    } else {
      q2 = wrapped(arc_tangent2(wrist_mm_[0], wrist_mm_[2]) - arc_tangent2(across_mm, along_mm));
    }
    with_wrist(q2, q3, q4);
  }

  // R_4_7 = Rz(q5) Ry(q6) Rz(q7).
  void with_wrist(double q2, double q3, double q4) {
    const Matrix3 R = (about_y(q2) * about_z(q3) * about_y(q4)).transpose() * R_;
    const double lever = std::sqrt(R(0, 2) * R(0, 2) + R(1, 2) * R(1, 2));
    double q5 = 0;
    if (lever < kWristLever) {
      answer_.is_wrist_singular = true;
      // All that is asked of W2 if E2 stays; then half of it for each.
      const double change = wrapped(last_joint(R, previous_[4]) - previous_[6]);
      q5 = previous_[4] + (R(2, 2) > 0 ? 0.5 : -0.5) * change;
    } else {
      q5 = arc_tangent2(R(1, 2), R(0, 2));
    }
    for (const double flip : {0.0, kPi}) {
      const auto [s5, c5] = sin_cos(q5 + flip);
      const double q6 = arc_tangent2(c5 * R(0, 2) + s5 * R(1, 2), R(2, 2));
      add({q2, q3, q4, q5 + flip, q6, last_joint(R, q5 + flip)});
    }
  }

  static double last_joint(const Matrix3& R, double q5) {
    const auto [s, c] = sin_cos(q5);
    return arc_tangent2(c * R(1, 0) - s * R(0, 0), c * R(1, 1) - s * R(0, 1));
  }

  void add(const std::array<double, 6>& q2_to_q7) {
    Pa10Solution solution;
    solution.is_within_limits = is_within(0, arm_.limits[0]);
    for (std::size_t i = 1; i < kMaxJoints; ++i) {
      const auto joint = static_cast<int>(i);
      const double q = nearest_turn(q2_to_q7[i - 1], previous_[joint], arm_.limits[i]);
      solution.q_rad[joint] = q;
      solution.is_within_limits = solution.is_within_limits && is_within(q, arm_.limits[i]);
    }
    answer_.solutions[static_cast<std::size_t>(answer_.count++)] = solution;
  }

  const SerialArm& arm_;
  const JointVector& previous_;
  double upper_mm_;
  double fore_mm_;
  Matrix3 R_;         // of the flange in the base
  Vector3 wrist_mm_;  // its centre, from the shoulder
  double radius_mm_;  // of that from S2's axis
  Pa10Inverse answer_;
};

}  // namespace

Pa10Inverse inverse_pa10(const SerialArm& arm, const Transform& T_W_H, const JointVector& q_previous_rad) {
  if (!is_pa10(arm) || !is_rigid(T_W_H, 1e-9) || !are_joint_angles(arm, q_previous_rad)) return {};
  return Solver(arm, T_W_H, q_previous_rad).run();
}

std::optional<JointVector> nearest_solution(const SerialArm& arm, const Pa10Inverse& inverse,
                                            const JointVector& q_previous_rad) {
  std::optional<JointVector> nearest;
  double least = 0;
  for (int i = 0; i < inverse.count; ++i) {
    const Pa10Solution& solution = inverse.solutions[static_cast<std::size_t>(i)];
    if (!solution.is_within_limits) continue;
    double squared = 0;
    for (int joint = 0; joint < kMaxJoints; ++joint) {
      const double seconds = (solution.q_rad[joint] - q_previous_rad[joint]) /
                             arm.limits[static_cast<std::size_t>(joint)].velocity_rad_per_s;
      squared += seconds * seconds;
    }
    if (nearest && !(squared < least)) continue;
    nearest = solution.q_rad;
    least = squared;
  }
  return nearest;
}

}  // namespace vergence
