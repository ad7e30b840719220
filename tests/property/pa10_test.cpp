// The PA-10's inverse kinematics in closed form: every branch, at singular poses, out of reach.
#include "algo/pa10.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "algo/damped_velocity.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::distance_mm;
using testing::distance_rad;
using testing::RandomArm;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where the thesis's hand stands at first [4.1].
Transform start_pose() {
  Transform T;
  T.R << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  T.t_mm = {-690, 0, 485};
  return T;
}

JointVector start_angles() {
  JointVector q;
  q << 0, 0.5, 0, 1.6, 0, -0.5, 0;
  return q;
}

struct Worst {
  double position_mm = 0;
  double rotation_rad = 0;
};

// Each solution puts the hand there, is told rightly to be within limits or not, and has S1 = 0.
void expect_exact(const SerialArm& arm, const Pa10Inverse& inverse, const Transform& T, Worst& worst) {
  ASSERT_EQ(inverse.reach, Pa10Reach::kReachable);
  ASSERT_GE(inverse.count, 2);
  for (int i = 0; i < inverse.count; ++i) {
    const auto& [q, is_within_limits] = inverse.solutions[static_cast<std::size_t>(i)];
    const Transform found = forward_kinematics(arm, q).T_W_H;
    ASSERT_LT(distance_mm(found, T), 1e-9) << i;
    ASSERT_LT(distance_rad(found, T), 1e-12) << i;
    worst.position_mm = std::max(worst.position_mm, distance_mm(found, T));
    worst.rotation_rad = std::max(worst.rotation_rad, distance_rad(found, T));
    ASSERT_EQ(q[0], 0);
    bool is_inside = true;
    for (int j = 0; j < 7; ++j) {
      is_inside = is_inside && is_within(q[j], arm.limits[static_cast<std::size_t>(j)]);
    }
    ASSERT_EQ(is_inside, is_within_limits);
  }
}

void record(const Worst& worst) {
  ::testing::Test::RecordProperty("worst_fm", std::to_string(worst.position_mm * 1e12));
  ::testing::Test::RecordProperty("worst_frad", std::to_string(worst.rotation_rad * 1e15));
}

double distance_to_nearest(const Pa10Inverse& inverse, const JointVector& q) {
  double nearest = 1e9;
  for (int i = 0; i < inverse.count; ++i) {
    const JointVector& branch = inverse.solutions[static_cast<std::size_t>(i)].q_rad;
    nearest = std::min(nearest, (branch - q).cwiseAbs().maxCoeff());
  }
  return nearest;
}

// At random angles the original is one of eight.
TEST(Pa10, EveryBranchIsExactAndTheOriginalIsAmongThem) {
  const SerialArm arm = pa10();
  RandomArm random(1);
  Worst worst;
  double worst_angle = 0;
  for (int n = 0; n < 100000; ++n) {
    const JointVector q = random.angles(arm);
    const ArmFrames frames = forward_kinematics(arm, q);
    const Pa10Inverse inverse = inverse_pa10(arm, frames.T_W_H, random.near(arm, q, 0.5));
    ASSERT_NO_FATAL_FAILURE(expect_exact(arm, inverse, frames.T_W_H, worst)) << q.transpose();
    ASSERT_EQ(inverse.count, 8);
    // Angles are as good as the pose allows: rounding over the smallest singular value.
    const double smallest = scale(arm, geometric_jacobian(arm, frames), arm.held, 300).smallest();
    const double angle = distance_to_nearest(inverse, q) * smallest;
    worst_angle = std::max(worst_angle, angle);
    ASSERT_LT(angle, 1e-13) << q.transpose();
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < i; ++j) {  // and no two are one
        const JointVector apart = inverse.solutions[static_cast<std::size_t>(i)].q_rad -
                                  inverse.solutions[static_cast<std::size_t>(j)].q_rad;
        ASSERT_GT(apart.cwiseAbs().maxCoeff(), 1e-9);
      }
    }
  }
  record(worst);
  RecordProperty("worst_angle_times_singular_value_frad", std::to_string(worst_angle * 1e15));
}

TEST(Pa10, TheThesisStartAndItsLateralRangeAreReachedWithMargin) {
  const SerialArm arm = pa10();
  JointVector q = start_angles();
  Worst worst;
  for (int y = 0; y <= 3000; ++y) {
    // 0, +300, -300, 0 mm: twice the range of the lateral experiments, in steps of at most 0.6 mm.
    const double phase = 2 * kPi * y / 3000;
    Transform T = start_pose();
    T.t_mm[1] = 300 * std::sin(phase);
    const Pa10Inverse inverse = inverse_pa10(arm, T, q);
    ASSERT_NO_FATAL_FAILURE(expect_exact(arm, inverse, T, worst));
    const auto next = nearest_solution(arm, inverse, q);
    ASSERT_TRUE(next.has_value());
    if (y > 0) {
      ASSERT_LT((*next - q).cwiseAbs().maxCoeff(), 0.004);
    }
    q = *next;
    for (int j = 1; j < 7; ++j) {
      ASSERT_LT(std::fabs(q[j]), arm.limits[static_cast<std::size_t>(j)].max_rad - 44 * kPi / 180) << j;
    }
    const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
    ASSERT_GT(scale(arm, J, arm.held, 300).smallest(), 0.25);
  }
}

TEST(Pa10, AtZeroItStandsUpright) {
  const ArmFrames frames = forward_kinematics(pa10(), JointVector::Zero());
  EXPECT_LT((frames.T_W_H.t_mm - Vector3{0, 0, 317 + 450 + 480 + 70}).norm(), 1e-12);
  JointVector q = JointVector::Zero();
  q[1] = kPi / 2;  // S2 leans it the way the base faces
  EXPECT_LT((forward_kinematics(pa10(), q).T_W_H.t_mm - Vector3{-1000, 0, 317}).norm(), 1e-12);
}

// Ever nearer to, and at, every combination of straight elbow, aligned wrist and shoulder: exact all the
// same, and where the arm already is, it stays.
TEST(Pa10, SingularPosesAreAnsweredWhereTheArmIs) {
  const SerialArm arm = pa10();
  RandomArm random(2);
  int singular = 0;
  Worst worst;
  for (int n = 0; n < 40000; ++n) {
    JointVector q = random.angles(arm);
    const int power = n / 8 % 60;
    const auto tiny = [&] { return power == 0 ? 0.0 : std::ldexp(random.between(-1, 1), -power); };
    if ((n & 1) != 0) q[3] = tiny();
    if ((n & 2) != 0) q[5] = tiny();
    if ((n & 4) != 0) q[2] = (random.between(-1, 1) < 0 ? -kPi / 2 : kPi / 2) + tiny();
    const Transform T = forward_kinematics(arm, q).T_W_H;
    const Pa10Inverse inverse = inverse_pa10(arm, T, q);
    ASSERT_NO_FATAL_FAILURE(expect_exact(arm, inverse, T, worst)) << q.transpose();
    if (power != 0) continue;
    if (inverse.is_elbow_singular || inverse.is_wrist_singular) ++singular;
    if ((n & 1) != 0) {
      ASSERT_TRUE(inverse.is_elbow_singular);
    }
    // Where rounding decides S3 and E1, it decides the wrist too.
    const bool is_elbow_straight = (n & 1) != 0;
    if (!is_elbow_straight && std::fabs(std::sin(q[3]) * std::cos(q[2])) < 0.05) continue;
    ASSERT_EQ(inverse.is_elbow_singular, is_elbow_straight);
    if (!is_elbow_straight && (n & 2) != 0) {
      ASSERT_TRUE(inverse.is_wrist_singular);
    }
    ASSERT_LT(distance_to_nearest(inverse, q), 1e-7) << q.transpose();
  }
  EXPECT_GT(singular, 300);
  record(worst);
}

TEST(Pa10, AnAlignedWristSharesTheTurn) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.5, 0.2, 1.5, 0.7, 0, -0.3;
  JointVector turned = q;
  turned[6] += 0.2;
  const Transform T = forward_kinematics(arm, turned).T_W_H;
  const Pa10Inverse inverse = inverse_pa10(arm, T, q);
  ASSERT_TRUE(inverse.is_wrist_singular);
  const auto next = nearest_solution(arm, inverse, q);
  ASSERT_TRUE(next.has_value());
  EXPECT_NEAR((*next)[4], 0.8, 1e-9);
  EXPECT_NEAR((*next)[6], -0.2, 1e-9);
}

TEST(Pa10, AWristOnTheShouldersAxisLeavesS2WhereItWas) {
  SerialArm arm = pa10();
  for (JointLimits& limits : arm.limits)
    limits = {-7, 7, 1, 1, 1};  // past the maker's, where E1 folds enough
  RandomArm random(3);
  Worst worst;
  for (int n = 0; n < 2000; ++n) {
    JointVector q = random.angles(arm);
    q[3] = std::acos(-450.0 / 480.0);
    q[2] = n % 2 == 0 ? kPi / 2 : -kPi / 2;
    if (n % 3 != 0) q[3] += std::ldexp(random.between(-1, 1), -n % 61);
    const Transform T = forward_kinematics(arm, q).T_W_H;
    const Pa10Inverse inverse = inverse_pa10(arm, T, q);
    ASSERT_NO_FATAL_FAILURE(expect_exact(arm, inverse, T, worst)) << n;
    if (n % 3 != 0) continue;
    ASSERT_TRUE(inverse.is_shoulder_singular);
    for (int i = 0; i < inverse.count; ++i) {
      ASSERT_EQ(inverse.solutions[static_cast<std::size_t>(i)].q_rad[1], q[1]);
    }
  }
}

// Out of reach by a known distance: as far back as it says, and it is reached.
TEST(Pa10, TellsHowFarBeyondReachAPoseIs) {
  const SerialArm arm = pa10();
  RandomArm random(4);
  for (int n = 0; n < 20000; ++n) {
    const Matrix3 R = rotation_from_quaternion_vector(random.vector(0.57));
    const Vector3 hub{0, 0, 317};  // S2's axis is W's y axis there
    Vector3 wrist = n % 4 == 0 ? Vector3(hub + random.vector(25)) : Vector3(hub + random.vector(1500));
    const auto inverse_at = [&](const Vector3& p) {
      return inverse_pa10(arm, {R, p + 70 * R.col(2)}, start_angles());
    };
    const Pa10Inverse inverse = inverse_at(wrist);
    if (inverse.reach == Pa10Reach::kReachable) {
      ASSERT_EQ(inverse.beyond_mm, 0);
      continue;
    }
    ASSERT_EQ(inverse.count, 0);
    ASSERT_GT(inverse.beyond_mm, 0);
    // Towards, or away from, the elbow that is nearest, or farthest.
    const Vector3 from_hub = wrist - hub;
    const double radius = std::sqrt(from_hub[0] * from_hub[0] + from_hub[2] * from_hub[2]);
    const bool is_far = inverse.reach == Pa10Reach::kTooFar;
    const double side = (is_far ? 450 : -450) / radius;
    const Vector3 elbow = hub + Vector3{side * from_hub[0], 0, side * from_hub[2]};
    const Vector3 out = (is_far ? 1 : -1) * (wrist - elbow).normalized();
    ASSERT_EQ(inverse_at(wrist - (inverse.beyond_mm + 1e-6) * out).reach, Pa10Reach::kReachable) << n;
    ASSERT_NE(inverse_at(wrist - (inverse.beyond_mm - 1e-6) * out).reach, Pa10Reach::kReachable) << n;
  }
}

TEST(Pa10, JointsThatTurnFartherThanOnceGoOn) {
  const SerialArm arm = pa10();
  JointVector q = start_angles();
  q[6] = 3.0;
  JointVector on = q;
  on[6] = 3.3;  // past half a turn, within the 255 degrees of W2
  const Transform T = forward_kinematics(arm, on).T_W_H;
  const auto next = nearest_solution(arm, inverse_pa10(arm, T, q), q);
  ASSERT_TRUE(next.has_value());
  EXPECT_LT((*next - on).cwiseAbs().maxCoeff(), 1e-9);
  on[6] = 4.6;  // past the limit: back by a full turn
  const auto back = nearest_solution(arm, inverse_pa10(arm, forward_kinematics(arm, on).T_W_H, q), q);
  ASSERT_TRUE(back.has_value());
  for (int j = 0; j < 7; ++j) EXPECT_TRUE(is_within((*back)[j], arm.limits[static_cast<std::size_t>(j)]));
}

TEST(Pa10, NothingWithinLimitsIsToldApart) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.5, 0, 2.6, 0, 0.3, 0;  // E1 past its 137 degrees
  const Pa10Inverse inverse = inverse_pa10(arm, forward_kinematics(arm, q).T_W_H, q);
  EXPECT_EQ(inverse.reach, Pa10Reach::kReachable);
  EXPECT_FALSE(nearest_solution(arm, inverse, q).has_value());
}

TEST(Pa10, RefusesWhatIsNotUsable) {
  const SerialArm arm = pa10();
  const auto refused = [](const SerialArm& an_arm, const Transform& T, const JointVector& q) {
    const Pa10Inverse inverse = inverse_pa10(an_arm, T, q);
    return inverse.reach == Pa10Reach::kBadInput && inverse.count == 0;
  };
  EXPECT_FALSE(refused(arm, start_pose(), start_angles()));
  for (const double bad : {kNaN, kInfinity, -kInfinity, 1e300}) {
    for (int i = 0; i < 3; ++i) {
      Transform T = start_pose();
      T.t_mm[i] = bad;
      EXPECT_TRUE(refused(arm, T, start_angles()));
      T = start_pose();
      T.R(1, i) = bad;
      EXPECT_TRUE(refused(arm, T, start_angles()));
    }
    for (int i = 0; i < 7; ++i) {
      JointVector q = start_angles();
      q[i] = bad;
      EXPECT_TRUE(refused(arm, start_pose(), q));
    }
  }
  SerialArm other = arm;
  other.dh[3].alpha_rad = 0;
  EXPECT_TRUE(refused(other, start_pose(), start_angles()));
  other = arm;
  other.dh[3].a_mm = 10;
  EXPECT_TRUE(refused(other, start_pose(), start_angles()));
  other = arm;
  other.joints = 6;
  EXPECT_TRUE(refused(other, start_pose(), start_angles()));
}

}  // namespace
}  // namespace vergence
