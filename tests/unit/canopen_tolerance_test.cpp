// What is no fault: a missing frame that is tolerated, a small difference of speed, a period that comes too
// soon.
#include <gtest/gtest.h>

#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::config_of_drives;

TEST(CanopenToleranceTest, OneMissingPdoMayBeTolerated) {
  CanopenArmConfig config = config_of_drives();
  config.tolerated_missing_pdos = 1;
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.move());
  ASSERT_TRUE(robot.bus->drop({0x18D}, 1));
  robot.run(5);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
  robot.bus->clear_faults();
  ASSERT_TRUE(robot.bus->drop({0x18D}));
  robot.run(3);  // the first that misses is asked for by the first SYNC: two periods from that
  EXPECT_EQ(robot.count(DriveState::kQuickStopActive), 7U);
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kPdoMissing);
}

// Of the velocity mode's own measure: what a joint was behind is forgotten, over a second and by enabling.
TEST(CanopenToleranceTest, ADriveThatTurnsALittleTooFastIsNoFollowingError) {
  CanopenArmConfig config = config_of_drives();
  for (CanopenAxisConfig& axis : config.axis) {
    axis.velocity_units_per_rad_per_s *= 1.02;
    axis.max_rad = 100;
  }
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.move());
  robot.run(10'000);  // 20 s at 0.01 rad/s too fast would be 0.2 rad
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
}

TEST(CanopenToleranceTest, EnablingBeginsWithoutAFollowingError) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  robot.drives[2].jam(true);
  ASSERT_TRUE(robot.run_until(ArmState::kFault, 130));
  robot.drives[2].jam(false);
  robot.request = ArmRequest::kDisable;
  robot.run(20);
  robot.arm.request(ArmRequest::kResetFault);
  ASSERT_TRUE(robot.run_until(ArmState::kDisabled, 5));
  ASSERT_TRUE(robot.enable());
  robot.velocity_rad_per_s.fill(1.9);
  robot.run(30);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
}

// A task that was late and hurries to catch up has not given the drives time to answer.
TEST(CanopenToleranceTest, APeriodThatComesTooSoonIsLeftOut) {
  for (const CyclicMode mode : {CyclicMode::kVelocity, CyclicMode::kPosition}) {
    CanopenArmConfig config = config_of_drives();
    config.mode = mode;
    CanopenRobot robot(config);
    ASSERT_TRUE(robot.move());
    for (int i = 0; i < 10; ++i) {
      robot.period();
      const double before = robot.feedback.position_rad[0];
      robot.arm.process(robot.t_ns + 100'000);
      ArmFeedback feedback;
      EXPECT_FALSE(robot.arm.read(feedback));
      robot.arm.command(robot.velocity_rad_per_s);
      robot.period();
      EXPECT_NEAR(robot.feedback.position_rad[0] - before, 0.5 * 0.002, 2e-5);
    }
    EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
  }
}

}  // namespace
}  // namespace vergence::canopen
