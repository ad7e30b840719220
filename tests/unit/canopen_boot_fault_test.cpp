// What goes wrong before the arm was ever enabled: it says why, and whatever is asked for, no drive is
// enabled.
#include <gtest/gtest.h>

#include "hal/canopen/objects.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::config_of_drives;

// The fault comes, and in spite of what is asked for no drive is ever enabled.
void expect_never_enabled(CanopenRobot& robot, const char* words, int most_periods = 700) {
  robot.request = ArmRequest::kEnable;
  for (int i = 0; i < most_periods; ++i) {
    robot.period();
    ASSERT_EQ(robot.count(DriveState::kOperationEnabled), 0U);
  }
  EXPECT_EQ(robot.feedback.state, ArmState::kFault);
  EXPECT_STREQ(describe(robot.fault()).data(), words);
}

TEST(CanopenBootFaultTest, NeverBooted) {
  CanopenRobot robot;
  robot.drives[4].set_power(false);
  expect_never_enabled(robot, "axis 5: did not boot in time: check power, node id, bit rate");
  EXPECT_EQ(robot.fault().t_ns, 1'004'000'000);  // a period after its second, counted from the reset
}

// Switched on just before it is told to reset, a drive boots twice; but not again and again.
TEST(CanopenBootFaultTest, BootsOnceMoreAndNotAgain) {
  CanopenRobot robot;
  robot.run(20);
  robot.drives[4].restart();
  EXPECT_TRUE(robot.boot()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.drives[4].objects().number(kHeartbeatProducer, 0), 20U);  // told once more

  CanopenRobot other;
  other.run(20);
  other.drives[4].restart();
  other.run(20);
  other.drives[4].restart();
  expect_never_enabled(other, "axis 5: restarted by itself", 100);
}

TEST(CanopenBootFaultTest, SdoRefused) {
  CanopenRobot robot;
  robot.drives[1].refuse(kQuickStopDeceleration, 0, 0x06090031);
  expect_never_enabled(robot, "axis 2: a transfer was aborted (object 0x6085:00): 0x6090031, value too high");
}

TEST(CanopenBootFaultTest, SdoNotAnswered) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.bus->drop({0x58C}));
  expect_never_enabled(robot,
                       "axis 2: a transfer was aborted (object 0x1000:00): 0x5040000, no answer in time");
}

TEST(CanopenBootFaultTest, NotADriveOrNotTheOneExpected) {
  CanopenArmConfig config = config_of_drives();
  config.axis[6].vendor_id = 0x77;
  CanopenRobot robot(config);
  expect_never_enabled(robot, "axis 7: an object has not the value it must have (object 0x1018:01): 469");
}

TEST(CanopenBootFaultTest, NoProcessDataAfterTheStart) {
  CanopenRobot robot;
  robot.drives[3].set_pdo(false);
  expect_never_enabled(
      robot, "axis 4: was started and did not become operational with process data: 0x5, operational");
}

TEST(CanopenBootFaultTest, DriveIsInAFaultWhenItBoots) {
  CanopenRobot robot;
  robot.drives[3].set_state(DriveState::kFault);
  expect_never_enabled(robot, "axis 4: the drive is in a fault: 0x218, fault", 300);
  robot.request = ArmRequest::kDisable;
  robot.period();
  robot.arm.request(ArmRequest::kResetFault);
  EXPECT_TRUE(robot.run_until(ArmState::kDisabled, 20));  // only now
}

TEST(CanopenBootFaultTest, CannotBeEnabled) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.boot());
  robot.drives[3].show_statusword(std::uint16_t{0x0250});
  robot.request = ArmRequest::kEnable;
  ASSERT_TRUE(robot.run_until(ArmState::kFault, 160));
  robot.run(1);
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 0U);
  EXPECT_STREQ(describe(robot.fault()).data(),
               "axis 4: could not be enabled in time: 0x250, switch on disabled");
}

}  // namespace
}  // namespace vergence::canopen
