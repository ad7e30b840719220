// Where the tool can get to while its joints brake: never elsewhere.
#include "algo/stopping_room.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>

#include "algo/pa10.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

constexpr double kPeriod_s = 0.002;

struct State {
  SerialArm arm = pa10();
  Vector3 tool_mm = Vector3::Zero();  // in the hand
  std::array<JointMotion, kMaxJoints> motion{};

  [[nodiscard]] ArmFrames frames() const {
    JointVector q;
    for (int i = 0; i < kMaxJoints; ++i) q[i] = motion[static_cast<std::size_t>(i)].position_rad;
    return forward_kinematics(arm, q);
  }
  [[nodiscard]] Vector3 tool() const { return frames().T_W_H * tool_mm; }
  [[nodiscard]] ToolRoom room() const {
    const ArmFrames now = frames();
    ArmJacobian J = geometric_jacobian(arm, now);
    const Vector3 arm_mm = now.T_W_H.R * tool_mm;
    for (int i = 0; i < arm.joints; ++i) J.col(i).head<3>() += Vector3(J.col(i).tail<3>()).cross(arm_mm);
    return stopping_room(arm, J, tool(), motion, kPeriod_s);
  }
};

State random_state(testing::Random& random) {
  State state;
  state.tool_mm = {random.between(-50, 50), random.between(-50, 50), random.between(0, 150)};
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const JointLimits& limits = state.arm.limits[i];
    JointMotion& m = state.motion[i];
    m.position_rad = random.between(limits.min_rad / 2, limits.max_rad / 2);
    if (random.below(4) != 0) m.velocity_rad_per_s = random.between(-1, 1) * limits.velocity_rad_per_s / 2;
    m.acceleration_rad_per_s2 = random.between(-1, 1) * limits.acceleration_rad_per_s2 / 2;
  }
  return state;
}

TEST(StoppingRoom, HoldsTheWholeWayToRest) {
  testing::Random random(5);
  double tightest_mm = 1e9;
  for (int run = 0; run < 2000; ++run) {
    State state = random_state(random);
    const ToolRoom room = state.room();
    for (bool moves = true; moves;) {
      moves = false;
      for (std::size_t i = 0; i < kMaxJoints; ++i) {
        state.motion[i] = brake_motion(state.arm.limits[i], kPeriod_s, state.motion[i]).motion;
        moves = moves || state.motion[i].velocity_rad_per_s != 0;
      }
      const Vector3 tool = state.tool();
      const double inside_mm = std::min((tool - room.min_mm).minCoeff(), (room.max_mm - tool).minCoeff());
      ASSERT_GT(inside_mm, -1e-6) << run;
      tightest_mm = std::min(tightest_mm, inside_mm);
    }
  }
  EXPECT_LT(tightest_mm, 1);  // the bound is met, not far off
}

TEST(StoppingRoom, OfAnArmAtRestIsItsTool) {
  testing::Random random(6);
  State state = random_state(random);
  for (JointMotion& motion : state.motion) motion.velocity_rad_per_s = motion.acceleration_rad_per_s2 = 0;
  const ToolRoom room = state.room();
  EXPECT_EQ(room.min_mm, room.max_mm);
  EXPECT_EQ(room.min_mm, state.tool());
}

// The joints before and behind the wrist's turn fast and against each other there, and the tool hardly moves.
TEST(StoppingRoom, OfAWristThatPassesItsSingularPoseIsSmall) {
  State state;
  state.motion[1].position_rad = 0.5;
  state.motion[3].position_rad = 1.6;
  state.motion[5].position_rad = -0.19;
  state.motion[4].velocity_rad_per_s = -3.1;
  state.motion[6].velocity_rad_per_s = 3.1;
  const ToolRoom room = state.room();
  EXPECT_LT((room.max_mm - room.min_mm).maxCoeff(), 20);
}

TEST(StoppingRoom, OfASlowHandIsLittleMoreThanItsWay) {
  testing::Random random(7);
  State state = random_state(random);
  for (JointMotion& motion : state.motion) {
    motion.velocity_rad_per_s = 0.05;
    motion.acceleration_rad_per_s2 = 0;
  }
  const ToolRoom room = state.room();
  EXPECT_LT((room.max_mm - room.min_mm).maxCoeff(), 20);
}

}  // namespace
}  // namespace vergence
