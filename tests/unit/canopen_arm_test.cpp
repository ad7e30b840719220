// An arm of seven simulated drives: it boots, is switched on and off, and moves as it is told.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "hal/canopen/objects.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::config_of_drives;

static_assert(Arm<CanopenArm<MemoryBus::Port>>);

TEST(CanopenArmTest, BootsEnablesStopsAndSwitchesOff) {
  CanopenRobot robot;
  robot.period();
  EXPECT_FALSE(robot.fed_back);  // until all have answered
  ASSERT_TRUE(robot.boot()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.count(DriveState::kSwitchOnDisabled), 7U);
  for (const SimulatedDrive& drive : robot.drives) EXPECT_EQ(drive.nmt(), NmtState::kOperational);

  robot.request = ArmRequest::kEnable;
  robot.period();
  robot.period();
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabling);
  ASSERT_TRUE(robot.run_until(ArmState::kEnabled, 20));
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 7U);

  robot.request = ArmRequest::kQuickStop;
  ASSERT_TRUE(robot.run_until(ArmState::kQuickStop, 2));
  EXPECT_EQ(robot.count(DriveState::kQuickStopActive), 7U);
  robot.run(50);
  EXPECT_EQ(robot.feedback.state, ArmState::kQuickStop);  // holds

  robot.request = ArmRequest::kEnable;
  EXPECT_TRUE(robot.run_until(ArmState::kEnabled, 30));
  robot.request = ArmRequest::kDisable;
  ASSERT_TRUE(robot.run_until(ArmState::kDisabled, 10));
  robot.run(3);
  EXPECT_EQ(robot.count(DriveState::kSwitchOnDisabled), 7U);
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kNone);
}

TEST(CanopenArmTest, DrivesAreSetUpFromTheConfig) {
  CanopenArmConfig config = config_of_drives();
  config.axis[4].rpdo1_cob_id = 0x301;
  config.axis[4].rpdo2_cob_id = 0x402;
  config.axis[4].tpdo1_cob_id = 0x182;
  config.axis[4].tpdo2_cob_id = 0x203;
  config.statusword_timer_ns = 80'000'000;
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.boot());
  for (std::size_t i = 0; i < 7; ++i) {
    const DriveObjects& objects = robot.drives[i].objects();
    EXPECT_EQ(objects.number(kModeDisplay, 0), kModeCyclicVelocity);
    EXPECT_EQ(objects.number(kRpdoMapping, 1), 0x60FF0020U);
    EXPECT_EQ(objects.number(kRpdoMapping, 0), 1U);
    EXPECT_EQ(objects.number(kRpdoMapping + 1, 1), 0x60400010U);
    EXPECT_EQ(objects.number(kRpdoMapping + 1, 0), 1U);
    EXPECT_EQ(objects.number(kTpdoMapping, 1), 0x60640020U);
    EXPECT_EQ(objects.number(kTpdoMapping + 1, 1), 0x60410010U);
    EXPECT_EQ(objects.number(kRpdoCommunication, 2), 1U);
    EXPECT_EQ(objects.number(kRpdoCommunication + 1, 2), 255U);
    EXPECT_EQ(objects.number(kTpdoCommunication, 2), 1U);
    EXPECT_EQ(objects.number(kTpdoCommunication + 1, 2), 255U);
    EXPECT_EQ(objects.number(kTpdoCommunication + 1, 3), 20U);  // of 0.1 ms: a SYNC period
    EXPECT_EQ(objects.number(kTpdoCommunication + 1, 5), 80U);
    EXPECT_EQ(objects.number(kAbortConnectionOption, 0), 3U);
    EXPECT_EQ(objects.number(kQuickStopOption, 0), 6U);
    EXPECT_EQ(robot.arm.master().axis(static_cast<int>(i)).objects_left_out(), 0);
  }
  EXPECT_EQ(robot.drives[4].objects().number(kRpdoCommunication, 1), 0x301U);
  EXPECT_EQ(robot.drives[4].objects().number(kTpdoCommunication + 1, 1), 0x40000203U);
  ASSERT_TRUE(robot.enable());
  EXPECT_EQ(robot.arm.master().axis(0).response_ns(), 0);  // the bus in memory takes no time
}

TEST(CanopenArmTest, WhatADriveDoesNotHaveAndNeedNotIsLeftOut) {
  CanopenRobot robot;
  robot.drives[2].refuse(kInterpolationPeriod, 1, kAbortNoObject);
  robot.drives[2].refuse(kInterpolationPeriod, 2, kAbortNoSubIndex);
  ASSERT_TRUE(robot.boot());
  EXPECT_EQ(robot.arm.master().axis(2).objects_left_out(), 2);
}

TEST(CanopenArmTest, AnArmOfFewerAxesLeavesTheOthersAlone) {
  CanopenArmConfig config = config_of_drives();
  config.axes = 3;
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.boot());
  ASSERT_TRUE(robot.enable());
  robot.velocity_rad_per_s.fill(0.5);
  robot.run(50);
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 3U);
  EXPECT_EQ(robot.drives[3].nmt(), NmtState::kPreOperational);
  EXPECT_EQ(robot.feedback.position_rad[3], 0);
}

// In both modes: what is commanded in rad/s is what the drive turns with in its own counts, and what it
// reports in counts comes back in radians.
class CanopenMotionTest : public ::testing::TestWithParam<CyclicMode> {};

TEST_P(CanopenMotionTest, VelocitiesArriveInScaleAndSign) {
  CanopenArmConfig config = config_of_drives();
  config.mode = GetParam();
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.boot());
  for (const double q : robot.feedback.position_rad) EXPECT_EQ(q, 0);
  ASSERT_TRUE(robot.enable());
  for (std::size_t i = 0; i < 7; ++i) robot.velocity_rad_per_s[i] = 0.1 * (static_cast<double>(i) - 2.5);
  robot.run(100);
  const ArmFeedback before = robot.feedback;
  robot.run(400);
  ASSERT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
  EXPECT_EQ(robot.feedback.stamp_ns - before.stamp_ns, 400 * config.sync_period_ns);
  EXPECT_EQ(robot.feedback.stamp_ns, robot.t_ns - config.sync_period_ns);  // the SYNC before
  for (std::size_t i = 0; i < 7; ++i) {
    const double wanted = robot.velocity_rad_per_s[i];
    const double count_rad = 1 / std::abs(config.axis[i].counts_per_rad);
    EXPECT_NEAR(robot.drives[i].velocity_counts_per_s(), wanted * config.axis[i].counts_per_rad, 20) << i;
    EXPECT_NEAR(robot.feedback.position_rad[i] - before.position_rad[i], wanted * 0.8, 0.8 * 20 * count_rad)
        << i;
    EXPECT_NEAR(robot.feedback.velocity_rad_per_s[i], wanted, 520 * count_rad) << i;
    const double shown =
        (robot.drives[i].position_counts() - config.axis[i].zero_counts) / config.axis[i].counts_per_rad;
    EXPECT_NEAR(robot.feedback.position_rad[i], shown, std::abs(wanted) * 0.0021 + count_rad) << i;
  }
}

TEST_P(CanopenMotionTest, CommandsAreClampedAndNumbersThatAreNoneAreRest) {
  CanopenArmConfig config = config_of_drives();
  config.mode = GetParam();
  for (CanopenAxisConfig& axis : config.axis) axis.following_error_rad = 10;
  config.axis[0].max_velocity_rad_per_s = 0.25;
  config.axis[1].max_rad = 0.02;
  config.axis[2].min_rad = -0.02;
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.boot());
  ASSERT_TRUE(robot.enable());
  robot.velocity_rad_per_s = {100, 0.5, -0.5, std::nan(""), INFINITY, -INFINITY, 0.1};
  robot.run(300);
  ASSERT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
  const auto& q = robot.feedback.position_rad;
  EXPECT_NEAR(robot.feedback.velocity_rad_per_s[0], 0.25, 0.006);
  EXPECT_GE(q[1], 0.02);
  EXPECT_LE(q[1], 0.03);  // braked behind its end, where no velocity leads on
  EXPECT_LE(q[2], -0.02);
  EXPECT_GE(q[2], -0.03);
  for (const std::size_t i : {3U, 4U, 5U}) EXPECT_EQ(q[i], 0) << i;
  robot.velocity_rad_per_s[1] = -0.5;
  robot.run(60);
  EXPECT_LT(q[1], 0.02);  // back is free
}

INSTANTIATE_TEST_SUITE_P(Modes, CanopenMotionTest,
                         ::testing::Values(CyclicMode::kVelocity, CyclicMode::kPosition),
                         [](const auto& mode) {
                           return mode.param == CyclicMode::kVelocity ? "Velocity" : "Position";
                         });

TEST(CanopenArmTest, EnablingMovesNothing) {
  for (const CyclicMode mode : {CyclicMode::kVelocity, CyclicMode::kPosition}) {
    CanopenArmConfig config = config_of_drives();
    config.mode = mode;
    for (CanopenAxisConfig& axis : config.axis) axis.zero_counts = -5000;
    CanopenRobot robot(config);
    ASSERT_TRUE(robot.boot());
    ASSERT_TRUE(robot.enable());
    robot.run(100);
    for (const SimulatedDrive& drive : robot.drives) EXPECT_EQ(drive.position_counts(), -5000);
  }
}

TEST(CanopenArmTest, AMovingArmIsStoppedBeforeItIsSwitchedOff) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move(1));
  robot.request = ArmRequest::kDisable;
  robot.period();
  robot.period();
  EXPECT_EQ(robot.count(DriveState::kQuickStopActive), 7U);
  double fastest = 1;
  for (int i = 0; i < 100 && robot.count(DriveState::kSwitchOnDisabled) == 0; ++i) {
    fastest = 0;
    for (const double v : robot.feedback.velocity_rad_per_s) fastest = std::max(fastest, std::abs(v));
    robot.period();
  }
  EXPECT_EQ(robot.count(DriveState::kSwitchOnDisabled), 7U);
  EXPECT_LT(fastest, 0.05);
}

TEST(CanopenArmTest, HomingIsReadBackAndCanBeDemanded) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.boot());
  for (int i = 0; i < 7; ++i) EXPECT_EQ(robot.arm.master().axis(i).homing(), HomingState::kDone);

  CanopenArmConfig config = config_of_drives();
  config.must_be_homed = true;
  CanopenRobot strict(config);
  SimulatedDriveOptions options;
  options.node_id = config.axis[5].node_id;
  options.is_homed = false;
  strict.drives[5].init(options, 0);
  ASSERT_TRUE(strict.run_until(ArmState::kFault, 500));
  EXPECT_STREQ(describe(strict.fault()).data(),
               "axis 6: is not homed (object 0x6041:00): 0x2, not started, or interrupted");
}

TEST(CanopenArmTest, ADriveSwitchedOnLateIsWaitedFor) {
  CanopenRobot robot;
  robot.drives[3].set_power(false);
  robot.run(200);
  robot.drives[3].set_power(true);
  EXPECT_TRUE(robot.boot()) << describe(robot.fault()).data();
  EXPECT_TRUE(robot.enable());
}

TEST(CanopenArmTest, AWrongConfigIsRefusedBeforeAnythingIsSent) {
  CanopenArmConfig config = config_of_drives();
  config.axis[3].node_id = config.axis[2].node_id;
  MemoryBus bus;
  CanopenArm<MemoryBus::Port> arm(bus.port(0));
  const ConfigResult result = arm.init(config, 0);
  EXPECT_EQ(result.finding, ConfigFinding::kNodeIdTwice);
  EXPECT_EQ(result.axis, 3);
  CanFrame frame;
  EXPECT_FALSE(bus.port(1).receive(frame));
}

}  // namespace
}  // namespace vergence::canopen
