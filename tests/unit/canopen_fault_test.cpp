// Whatever goes wrong with one drive, with the bus or with the controller: all axes are braking by quick stop
// within two periods, and the record says why. And nothing moves again before it was reset and asked for.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/bytes.hpp"
#include "hal/canopen/objects.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanopenRobot;
using testing::config_of_drives;

constexpr int kSick = 2;  // the axis something is wrong with

class CanopenFaultTest : public ::testing::TestWithParam<CyclicMode> {
 protected:
  CanopenFaultTest() {
    CanopenArmConfig config = config_of_drives();
    config.mode = GetParam();
    robot = std::make_unique<CanopenRobot>(config);
  }

  SimulatedDrive& sick() { return robot->drives[kSick]; }

  // Of the drives that are not sick, every one brakes by quick stop, and nobody follows commands any more.
  void expect_all_stopped() {
    for (std::size_t i = 0; i < 7; ++i) {
      if (i == kSick) continue;
      EXPECT_EQ(robot->drives[i].state(), DriveState::kQuickStopActive) << i;
    }
    EXPECT_EQ(robot->count(DriveState::kOperationEnabled), 0U);
  }
  void expect_record(ArmFaultKind kind, int axis, const std::string& words) {
    EXPECT_EQ(robot->fault().kind, kind);
    EXPECT_EQ(robot->fault().axis, axis);
    EXPECT_EQ(describe(robot->fault()).data(), words);
    EXPECT_EQ(robot->feedback.state, ArmState::kFault);
    EXPECT_EQ(robot->feedback.fault, fault_code(robot->fault()));
    if (axis >= 0) {
      EXPECT_EQ(robot->arm.master().axis(axis).fault().t_ns, robot->fault().t_ns);
    }
  }
  // By the bus, each of the seven was told to brake, with no velocity to follow.
  void expect_quick_stop_sent() {
    std::array<int, 7> quick_stops{};
    std::array<std::uint32_t, 7> targets{};
    for (const CanFrame& frame : robot->heard()) {
      const std::size_t node = (frame.id & 0x7F) - 11U;
      if (frame.id >= 0x30B && frame.id <= 0x311) {
        EXPECT_EQ(get_number(frame.payload(), 2), 0x0002U) << node;
        ++quick_stops[node];
      }
      if (frame.id >= 0x20B && frame.id <= 0x211) targets[node] = get_number(frame.payload(), 4);
    }
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_GE(quick_stops[i], 1) << i;
      if (GetParam() == CyclicMode::kVelocity) {
        EXPECT_EQ(targets[i], 0U) << i;
      }
    }
  }
  // Of a fault that is to be noticed at once.
  void expect_stop(ArmFaultKind kind, int axis, const std::string& words) {
    const std::int64_t injected_ns = robot->t_ns;
    (void)robot->heard();
    robot->run(2);
    expect_quick_stop_sent();
    expect_all_stopped();
    expect_record(kind, axis, words);
    EXPECT_GT(robot->fault().t_ns, injected_ns);
    EXPECT_LE(robot->fault().t_ns, injected_ns + 2 * robot->config.sync_period_ns);
  }
  // Of a fault that takes its time to be one: two periods from then.
  void expect_stop_once_noticed(ArmFaultKind kind, int axis, const std::string& words, int most_periods) {
    const std::int64_t injected_ns = robot->t_ns;
    int periods = 0;
    while (robot->fault().kind == ArmFaultKind::kNone && periods++ < most_periods) {
      (void)robot->heard();
      robot->period();
    }
    expect_quick_stop_sent();  // in the period in which it was noticed
    EXPECT_LE(robot->fault().t_ns, injected_ns + most_periods * robot->config.sync_period_ns);
    robot->run(1);
    expect_all_stopped();
    expect_record(kind, axis, words);
  }
  // Back to moving, by what an operator does.
  void expect_recovery() {
    robot->velocity_rad_per_s.fill(0);
    robot->request = ArmRequest::kDisable;
    robot->run(100);
    EXPECT_EQ(robot->feedback.state, ArmState::kFault);
    robot->arm.request(ArmRequest::kResetFault);
    ASSERT_TRUE(robot->run_until(ArmState::kDisabled, 600)) << describe(robot->fault()).data();
    EXPECT_EQ(robot->feedback.fault, 0U);
    ASSERT_TRUE(robot->enable()) << describe(robot->fault()).data();
    EXPECT_EQ(robot->count(DriveState::kOperationEnabled), 7U);
  }

  std::unique_ptr<CanopenRobot> robot;
};

TEST_P(CanopenFaultTest, HeartbeatMissing) {
  ASSERT_TRUE(robot->move());
  sick().set_heartbeat(false);
  expect_stop_once_noticed(ArmFaultKind::kHeartbeatLost, kSick, "axis 3: its heartbeat stopped", 27);
  EXPECT_EQ(sick().state(), DriveState::kQuickStopActive);  // it still hears
  sick().set_heartbeat(true);
  expect_recovery();
}

TEST_P(CanopenFaultTest, PdoMissing) {
  ASSERT_TRUE(robot->move());
  sick().set_pdo(false);
  expect_stop(ArmFaultKind::kPdoMissing, kSick, "axis 3: sent no process data: 1");
  EXPECT_EQ(sick().state(), DriveState::kQuickStopActive);
  sick().set_pdo(true);
  expect_recovery();
}

TEST_P(CanopenFaultTest, StatuswordMissing) {
  ASSERT_TRUE(robot->move(0.2));
  ASSERT_TRUE(robot->bus->drop({0x28D}));
  // 2.5 event timers of 100 ms after the last one, which is up to one timer old.
  expect_stop_once_noticed(ArmFaultKind::kStatusMissing, kSick, "axis 3: sent no statusword, for ms: 252",
                           126);
  EXPECT_EQ(sick().state(), DriveState::kQuickStopActive);
  robot->bus->clear_faults();
  expect_recovery();
}

TEST_P(CanopenFaultTest, PowerLost) {
  ASSERT_TRUE(robot->move());
  sick().set_power(false);
  expect_stop(ArmFaultKind::kPdoMissing, kSick, "axis 3: sent no process data: 1");
  robot->run(30);
  EXPECT_EQ(robot->fault().kind, ArmFaultKind::kPdoMissing);  // the first cause stays
  sick().set_power(true);
  expect_recovery();
}

TEST_P(CanopenFaultTest, Emergency) {
  ASSERT_TRUE(robot->move());
  sick().emergency(0x7305);
  expect_stop(ArmFaultKind::kEmergency, kSick, "axis 3: emergency: 0x7305, incremental encoder 1 at fault");
  EXPECT_EQ(sick().state(), DriveState::kQuickStopActive);
  EXPECT_EQ(robot->arm.master().axis(kSick).last_emergency().code, 0x7305);
  expect_recovery();
}

TEST_P(CanopenFaultTest, EmergencyWithFaultReaction) {
  ASSERT_TRUE(robot->move());
  sick().fail(0x4310);
  expect_stop(ArmFaultKind::kEmergency, kSick, "axis 3: emergency: 0x4310, drive too hot");
  robot->run(100);
  EXPECT_EQ(sick().state(), DriveState::kFault);
  expect_recovery();
}

TEST_P(CanopenFaultTest, EmergencyThatIsOverIsNone) {
  ASSERT_TRUE(robot->move());
  sick().emergency(0x0000);
  robot->run(3);
  EXPECT_EQ(robot->feedback.state, ArmState::kEnabled);
}

TEST_P(CanopenFaultTest, Jammed) {
  ASSERT_TRUE(robot->move());
  sick().jam(true);
  // 0.1 rad behind at 0.5 rad/s: after some 0.2 s, less what the lag has used up already.
  int periods = 0;
  while (robot->fault().kind == ArmFaultKind::kNone && periods++ < 130) {
    (void)robot->heard();
    robot->period();
  }
  expect_quick_stop_sent();
  robot->run(1);
  expect_all_stopped();
  const std::string behind = std::to_string(robot->fault().detail);
  EXPECT_GE(robot->fault().detail, 100'000U);
  EXPECT_LT(robot->fault().detail, 102'000U);
  expect_record(ArmFaultKind::kFollowingError, kSick,
                "axis 3: following error: " + behind + ", microradians");
  sick().jam(false);
  expect_recovery();
}

TEST_P(CanopenFaultTest, FollowingErrorReportedByTheDrive) {
  ASSERT_TRUE(robot->move());
  sick().show_statusword(0x3237);
  if (GetParam() == CyclicMode::kPosition) {
    expect_stop(ArmFaultKind::kFollowingError, kSick, "axis 3: following error: 0, reported by the drive");
  } else {
    robot->run(3);
    EXPECT_EQ(robot->feedback.state, ArmState::kEnabled);  // the bit has no meaning in velocity mode
  }
}

TEST_P(CanopenFaultTest, StatuswordWithoutMeaning) {
  ASSERT_TRUE(robot->move());
  sick().show_statusword(0x0225);
  expect_stop(ArmFaultKind::kBadStatusword, kSick,
              "axis 3: its statusword has no meaning in CiA 402: 0x225, no state of CiA 402");
  sick().show_statusword(std::nullopt);
  expect_recovery();
}

TEST_P(CanopenFaultTest, DriveInFaultWithoutEmergency) {
  ASSERT_TRUE(robot->move());
  sick().set_state(DriveState::kFault);
  expect_stop(ArmFaultKind::kDriveFault, kSick, "axis 3: the drive is in a fault: 0x218, fault");
  expect_recovery();
}

TEST_P(CanopenFaultTest, DriveLeavesOperation) {
  ASSERT_TRUE(robot->move());
  sick().set_state(DriveState::kSwitchOnDisabled);
  expect_stop(ArmFaultKind::kLeftEnabled, kSick,
              "axis 3: is not enabled any more: 0x250, switch on disabled");
  expect_recovery();
}

TEST_P(CanopenFaultTest, DriveRestarts) {
  ASSERT_TRUE(robot->move());
  sick().restart();
  expect_stop(ArmFaultKind::kRebooted, kSick, "axis 3: restarted by itself");
  expect_recovery();
}

TEST_P(CanopenFaultTest, NodeLeavesOperational) {
  ASSERT_TRUE(robot->move());
  ASSERT_TRUE(robot->free_port().send(can_frame(0x70D, {0x04})));
  expect_stop(ArmFaultKind::kLeftOperational, kSick, "axis 3: left the state operational: 0x4, stopped");
  expect_recovery();
}

TEST_P(CanopenFaultTest, BusOff) {
  ASSERT_TRUE(robot->move());
  robot->master_port().set_off(true);
  // Nothing can be sent: the drives notice that SYNC is missing.
  robot->run(2);
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
  expect_record(ArmFaultKind::kBusOff, -1, "the bus cannot be used: 0x3, bus off");
  robot->run(50);
  robot->master_port().set_off(false);
  robot->run(2);
  EXPECT_EQ(robot->fault().kind, ArmFaultKind::kBusOff);
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
  expect_recovery();
}

TEST_P(CanopenFaultTest, QueueStaysFull) {
  ASSERT_TRUE(robot->move());
  robot->master_port().set_full(true);
  robot->run(3);
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
  EXPECT_EQ(robot->fault().kind, ArmFaultKind::kTransmitFull);
  EXPECT_GT(robot->master_port().health().tx_refused, 0U);
  robot->master_port().set_full(false);
  expect_recovery();
}

TEST_P(CanopenFaultTest, CommandsThatWereRefusedAreSentAgain) {
  ASSERT_TRUE(robot->move());
  robot->commands = false;
  robot->period();
  robot->master_port().set_full(true);
  robot->arm.command({-0.5, -0.5, -0.5, -0.5, -0.5, -0.5, -0.5});
  robot->master_port().set_full(false);
  robot->run(2);  // one period without a command of its own
  EXPECT_EQ(robot->master_port().health().tx_refused, 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    const DriveObjects& objects = robot->drives[i].objects();
    const double units = static_cast<std::int32_t>(objects.number(kTargetVelocity, 0));
    if (GetParam() == CyclicMode::kVelocity) {
      EXPECT_NEAR(units, -0.5 * robot->config.axis[i].velocity_units_per_rad_per_s, 1) << i;
    }
  }
  EXPECT_EQ(robot->feedback.state, ArmState::kEnabled);
}

// A queue that is full in the middle of them: the others are sent again, and those that went out are not.
TEST_P(CanopenFaultTest, OfCommandsTheRefusedOnesAreSentAgain) {
  ASSERT_TRUE(robot->move());
  robot->commands = false;
  robot->period();
  robot->master_port().set_room(3);
  robot->arm.command({-0.5, -0.5, -0.5, -0.5, -0.5, -0.5, -0.5});
  EXPECT_EQ(robot->master_port().health().tx_refused, 4U);
  robot->master_port().set_full(false);
  (void)robot->heard();
  robot->run(1);
  std::array<int, 7> sent{};
  for (const CanFrame& frame : robot->heard()) {
    for (std::size_t i = 0; i < 7; ++i) {
      if (frame.id == axis_pdos(robot->config, static_cast<int>(i)).target.cob_id) ++sent[i];
    }
  }
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(sent[i], i < 3 ? 0 : 1) << i;
  EXPECT_EQ(robot->master_port().health().tx_refused, 4U);
  EXPECT_EQ(robot->feedback.state, ArmState::kEnabled);
}

TEST_P(CanopenFaultTest, ControllerSendsNoCommands) {
  ASSERT_TRUE(robot->move());
  robot->commands = false;
  robot->run(robot->config.most_missed_commands);
  (void)robot->heard();
  robot->run(2);
  expect_quick_stop_sent();
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
  expect_record(ArmFaultKind::kNoCommand, -1, "the controller sent no command: 3");
  robot->commands = true;
  expect_recovery();
}

TEST_P(CanopenFaultTest, ControllerIsDead) {
  ASSERT_TRUE(robot->move());
  robot->master_runs = false;
  robot->run(2);
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
}

TEST_P(CanopenFaultTest, ControllerIsDeadAndDrivesDoNotWatchSync) {
  for (SimulatedDrive& drive : robot->drives) drive.refuse(kCyclePeriod, 0, kAbortNoObject);
  ASSERT_TRUE(robot->move());
  robot->master_runs = false;
  robot->run(10);
  EXPECT_EQ(robot->count(DriveState::kOperationEnabled), 7U);
  robot->run(17);  // 50 ms after the master's last heartbeat
  EXPECT_EQ(robot->count(DriveState::kQuickStopActive), 7U);
}

TEST_P(CanopenFaultTest, TheQuickStopIsARampAndHoldsUntilTheArmIsSwitchedOff) {
  ASSERT_TRUE(robot->move(1));
  sick().emergency(0x7305);
  const std::array<double, 7> before = robot->feedback.position_rad;
  robot->run(60);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(robot->feedback.velocity_rad_per_s[i], 0) << i;
    // v^2 / 2a = 25 mm per m, and two periods at full speed.
    EXPECT_NEAR(robot->feedback.position_rad[i] - before[i], 0.025 + 0.002, 0.003) << i;
  }
  robot->run(100);
  expect_all_stopped();  // enabling is still asked for
  robot->request = ArmRequest::kDisable;
  robot->run(4);
  EXPECT_EQ(robot->count(DriveState::kSwitchOnDisabled), 7U);
  EXPECT_EQ(robot->feedback.state, ArmState::kFault);
}

TEST_P(CanopenFaultTest, NothingMovesAgainBeforeItWasResetAndAskedFor) {
  ASSERT_TRUE(robot->move());
  sick().emergency(0x7305);
  robot->run(100);
  robot->arm.request(ArmRequest::kResetFault);
  ASSERT_TRUE(robot->run_until(ArmState::kDisabled, 600));
  robot->run(50);  // enabling is asked for all the time, as before the fault
  EXPECT_EQ(robot->count(DriveState::kOperationEnabled), 0U);
  robot->request = ArmRequest::kDisable;
  robot->run(1);
  EXPECT_TRUE(robot->enable());
}

TEST_P(CanopenFaultTest, AResetWaitsUntilTheArmHasStopped) {
  ASSERT_TRUE(robot->move(1));
  sick().emergency(0x7305);
  robot->run(2);
  robot->arm.request(ArmRequest::kResetFault);
  robot->run(3);
  EXPECT_EQ(robot->fault().kind, ArmFaultKind::kEmergency);
  expect_all_stopped();
  EXPECT_TRUE(robot->run_until(ArmState::kDisabled, 60));
}

TEST_P(CanopenFaultTest, AResetOfWhatIsStillBrokenFails) {
  ASSERT_TRUE(robot->move());
  sick().set_power(false);
  robot->request = ArmRequest::kDisable;
  robot->run(50);
  robot->arm.request(ArmRequest::kResetFault);
  robot->run(600);
  EXPECT_EQ(robot->feedback.state, ArmState::kFault);
  EXPECT_STREQ(describe(robot->fault()).data(),
               "axis 3: did not boot in time: check power, node id, bit rate");
  sick().set_power(true);
  expect_recovery();
}

TEST_P(CanopenFaultTest, EachAxisKeepsItsOwnRecord) {
  ASSERT_TRUE(robot->move());
  robot->drives[1].emergency(0x2310);
  robot->drives[5].emergency(0x4310);
  robot->run(2);
  EXPECT_EQ(robot->fault().axis, 1);
  EXPECT_EQ(robot->arm.master().axis(1).fault().detail, 0x2310U);
  EXPECT_EQ(robot->arm.master().axis(5).fault().detail, 0x4310U);
  EXPECT_EQ(robot->arm.master().axis(3).fault().kind, ArmFaultKind::kNone);
}

INSTANTIATE_TEST_SUITE_P(Modes, CanopenFaultTest,
                         ::testing::Values(CyclicMode::kVelocity, CyclicMode::kPosition),
                         [](const auto& mode) {
                           return mode.param == CyclicMode::kVelocity ? "Velocity" : "Position";
                         });

}  // namespace
}  // namespace vergence::canopen
