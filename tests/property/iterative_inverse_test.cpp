// Iterative inverse kinematics: it converges, keeps to limits, and says what stopped it.
#include "algo/iterative_inverse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "algo/pa10.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::distance_mm;
using testing::distance_rad;
using testing::RandomArm;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void expect_sane(const SerialArm& arm, const IkSolution& solution, const Transform& target) {
  for (int i = 0; i < arm.joints; ++i) {
    ASSERT_TRUE(is_within(solution.q_rad[i], arm.limits[static_cast<std::size_t>(i)])) << i;
  }
  const Transform found = forward_kinematics(arm, solution.q_rad).T_W_H;
  ASSERT_NEAR(solution.position_error_mm, distance_mm(found, target), 1e-9);
  ASSERT_NEAR(solution.rotation_error_rad, distance_rad(found, target), 1e-9);
  ASSERT_GE(solution.smallest_singular_value, 0);
  if (solution.result == IkResult::kReached) {
    ASSERT_LE(solution.position_error_mm, 1e-6);
    ASSERT_LE(solution.rotation_error_rad, 1e-9);
  }
}

TEST(IterativeInverse, ConvergesFromPerturbedStarts) {
  const SerialArm arm = pa10();
  RandomArm random(1);
  int reached = 0;
  int same = 0;
  int longest = 0;
  constexpr int kRuns = 5000;
  for (int n = 0; n < kRuns; ++n) {
    const JointVector q = random.angles(arm);
    const Transform target = forward_kinematics(arm, q).T_W_H;
    const IkSolution solution = solve_ik_damped(arm, target, random.near(arm, q, 0.3));
    ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
    ASSERT_EQ(solution.q_rad[0], 0);
    if (solution.result != IkResult::kReached) continue;
    ++reached;
    longest = std::max(longest, solution.iterations);
    // Whatever was reached, the closed form knows it.
    const Pa10Inverse inverse = inverse_pa10(arm, target, solution.q_rad);
    double nearest = 1e9;
    for (int i = 0; i < inverse.count; ++i) {
      const JointVector& branch = inverse.solutions[static_cast<std::size_t>(i)].q_rad;
      nearest = std::min(nearest, (branch - solution.q_rad).cwiseAbs().maxCoeff());
    }
    if (nearest * solution.smallest_singular_value < 1e-8) ++same;
  }
  EXPECT_GE(reached, kRuns * 998 / 1000);
  EXPECT_EQ(same, reached);
  RecordProperty("reached_of_5000", reached);
  RecordProperty("longest", longest);
}

TEST(IterativeInverse, ConvergesForArmsOfAnyMake) {
  RandomArm random(2);
  int reached = 0;
  constexpr int kRuns = 2000;
  for (int n = 0; n < kRuns; ++n) {
    const SerialArm arm = random.arm(4 + n % 4);
    const JointVector q = random.angles(arm);
    const Transform target = forward_kinematics(arm, q).T_W_H;
    const IkSolution solution = solve_ik_damped(arm, target, random.near(arm, q, 0.2));
    ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
    if (solution.result == IkResult::kReached) ++reached;
  }
  EXPECT_GE(reached, kRuns * 99 / 100);
  RecordProperty("reached_of_2000", reached);
}

TEST(IterativeInverse, LeavesASingularStart) {
  const SerialArm arm = pa10();
  // Upright, everything aligned; the target is straight below, where no joint moves the hand to first order.
  Transform target = forward_kinematics(arm, JointVector::Zero()).T_W_H;
  target.t_mm[2] -= 200;
  const IkSolution solution = solve_ik_damped(arm, target, JointVector::Zero());
  EXPECT_EQ(solution.result, IkResult::kReached) << describe(solution.result);
  expect_sane(arm, solution, target);
}

TEST(IterativeInverse, ReachesSingularPoses) {
  const SerialArm arm = pa10();
  RandomArm random(3);
  for (int n = 0; n < 200; ++n) {
    JointVector q = random.angles(arm);
    if (n % 3 != 0) q[3] = 0;  // elbow straight
    if (n % 3 != 1) q[5] = 0;  // wrist aligned
    const Transform target = forward_kinematics(arm, q).T_W_H;
    const IkSolution solution = solve_ik_damped(arm, target, random.near(arm, q, 0.05));
    ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
    ASSERT_LT(solution.position_error_mm, 0.1) << describe(solution.result);
    ASSERT_LT(solution.rotation_error_rad, 1e-3);
  }
}

TEST(IterativeInverse, ComesAsNearAsItCanOutOfReach) {
  const SerialArm arm = pa10();
  JointVector start;
  start << 0, 0.5, 0.1, 1.6, 0.1, -0.5, 0;
  Transform target = forward_kinematics(arm, start).T_W_H;
  for (const double away_mm : {1300.0, 5000.0, 1e6, 1e9}) {
    target.t_mm = {-away_mm, 0, 317};
    const IkSolution solution = solve_ik_damped(arm, target, start);
    EXPECT_EQ(solution.result, IkResult::kUnreachable) << describe(solution.result);
    ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
    EXPECT_GT(solution.position_error_mm, away_mm - 1000 - 1e-6);
    EXPECT_LT(solution.position_error_mm, away_mm - 900);  // stretched, give or take its share of the turn
  }
}

TEST(IterativeInverse, SaysThatLimitsAreInTheWay) {
  const SerialArm arm = pa10();
  JointVector beyond;
  beyond << 0, 1.2, 0, 2.6, 0, 0.5, 0;  // E1 past its 137 degrees; the other elbow needs S2 past its 91
  const Transform target = forward_kinematics(arm, beyond).T_W_H;
  const IkSolution solution = solve_ik_damped(arm, target, JointVector(beyond * 0.8));
  EXPECT_EQ(solution.result, IkResult::kAtLimit) << describe(solution.result);
  expect_sane(arm, solution, target);
}

TEST(IterativeInverse, SaysThatItsJointsAreTooFew) {
  RandomArm random(4);
  int told = 0;
  for (int n = 0; n < 100; ++n) {
    SerialArm arm = random.arm(4);
    for (JointLimits& limits : arm.limits) limits = {-40, 40, 1, 1, 1};
    const JointVector q = random.near(arm, JointVector::Zero(), 1);
    Transform target = forward_kinematics(arm, q).T_W_H;
    target.R = target.R * rotation_from_quaternion_vector(random.vector(0.1));
    target.t_mm += random.vector(20);
    const IkSolution solution = solve_ik_damped(arm, target, q);
    ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
    ASSERT_NE(solution.result, IkResult::kReached);
    if (solution.result == IkResult::kUnreachable) ++told;
  }
  EXPECT_GT(told, 70);
}

TEST(IterativeInverse, TakesAStartBesideTheLimitsToThem) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.5, 0.1, 1.6, 0.1, -0.5, 0;
  const Transform target = forward_kinematics(arm, q).T_W_H;
  q[1] = 3;
  q[4] = -6;
  const IkSolution solution = solve_ik_damped(arm, target, q, {1, 1e-6, 1e-9, {}});
  ASSERT_NO_FATAL_FAILURE(expect_sane(arm, solution, target));
  EXPECT_EQ(solution.result, IkResult::kNotConverged);
  EXPECT_EQ(solution.iterations, 1);
}

TEST(IterativeInverse, RefusesWhatIsNotUsable) {
  const SerialArm arm = pa10();
  const Transform good = forward_kinematics(arm, JointVector::Zero()).T_W_H;
  const auto refused = [&](const SerialArm& an_arm, const Transform& T, const JointVector& q,
                           const IkOptions& options) {
    const IkSolution solution = solve_ik_damped(an_arm, T, q, options);
    EXPECT_TRUE(are_joint_angles(arm, solution.q_rad));
    return solution.result == IkResult::kBadInput;
  };
  for (const double bad : {kNaN, kInfinity, -kInfinity, 1e300}) {
    for (int i = 0; i < 3; ++i) {
      Transform T = good;
      T.t_mm[i] = bad;
      EXPECT_TRUE(refused(arm, T, JointVector::Zero(), {}));
      T = good;
      T.R(i, 1) = bad;
      EXPECT_TRUE(refused(arm, T, JointVector::Zero(), {}));
    }
    for (int i = 0; i < 7; ++i) {
      JointVector q = JointVector::Zero();
      q[i] = bad;
      EXPECT_TRUE(refused(arm, good, q, {}));
    }
    EXPECT_TRUE(refused(arm, good, JointVector::Zero(), {200, bad, 1e-9, {}}));
    EXPECT_TRUE(refused(arm, good, JointVector::Zero(), {200, 1e-6, bad, {}}));
  }
  EXPECT_TRUE(refused(arm, good, JointVector::Zero(), {0, 1e-6, 1e-9, {}}));
  EXPECT_TRUE(refused(arm, good, JointVector::Zero(), {kMaxIkIterations + 1, 1e-6, 1e-9, {}}));
  EXPECT_TRUE(refused(SerialArm{}, good, JointVector::Zero(), {}));
}

}  // namespace
}  // namespace vergence
