// The words of the state machine travel as they change: none is missed, none is sent for nothing, and what is
// lost is made good.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/objects.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanopenRobot;
using testing::config_of_drives;

constexpr std::uint32_t kControlwords = 0x300;
constexpr std::uint32_t kStatuswords = 0x280;
constexpr std::uint32_t kSickNode = 13;  // of axis 3

std::vector<std::uint32_t> words_to(const std::vector<CanFrame>& frames, std::uint32_t node) {
  std::vector<std::uint32_t> words;
  for (const CanFrame& frame : frames) {
    if (frame.id == kControlwords + node) words.push_back(get_number(frame.payload(), 2));
  }
  return words;
}

using Words = std::vector<std::uint32_t>;

// SYNC comes before all else, so that nothing delays it.
TEST(CanopenWordsTest, SteadyMotionIsSyncPositionsAndTargetsAlone) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  (void)robot.heard();
  int controlwords = 0;
  int statuswords = 0;
  for (int period = 0; period < 1000; ++period) {
    robot.period();
    std::vector<std::uint32_t> ids;
    for (const CanFrame& frame : robot.heard()) {
      const std::uint32_t function = frame.id & 0x780;
      controlwords += function == kControlwords ? 1 : 0;
      statuswords += function == kStatuswords ? 1 : 0;
      if (function != kStatuswords && function != kHeartbeatCobId) ids.push_back(frame.id);
    }
    ASSERT_EQ(ids.size(), 15U);
    ASSERT_EQ(ids[0], 0x080U);
    for (std::uint32_t i = 0; i < 7; ++i) {
      ASSERT_EQ(ids[1 + i], 0x18BU + i);
      ASSERT_EQ(ids[8 + i], 0x20BU + i);
    }
  }
  EXPECT_EQ(controlwords, 0);
  EXPECT_EQ(statuswords, 7 * 20);  // each 100 ms of 2 s
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
}

TEST(CanopenWordsTest, EnablingIsOneWordAStep) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.boot());
  (void)robot.heard();
  robot.request = ArmRequest::kEnable;
  Words words;
  for (int i = 0; i < 30; ++i) {
    robot.period();
    for (const std::uint32_t word : words_to(robot.heard(), kSickNode)) words.push_back(word);
  }
  EXPECT_EQ(words, (Words{0x06, 0x07, 0x0F}));
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
}

// Before the word that enables, the drive has taken a target at which it stands, whatever it was told before.
TEST(CanopenWordsTest, EnablingFindsATargetAtRest) {
  for (const CyclicMode mode : {CyclicMode::kVelocity, CyclicMode::kPosition}) {
    CanopenArmConfig config = config_of_drives();
    config.mode = mode;
    CanopenRobot robot(config);
    ASSERT_TRUE(robot.move());
    robot.drives[2].set_state(DriveState::kSwitchOnDisabled);  // at speed, and the brakes close
    robot.run(60);
    robot.request = ArmRequest::kDisable;
    robot.run(2);
    robot.arm.request(ArmRequest::kResetFault);
    ASSERT_TRUE(robot.run_until(ArmState::kDisabled, 50));
    robot.request = ArmRequest::kEnable;
    robot.velocity_rad_per_s = {};
    std::array<double, 7> before{};
    for (std::size_t i = 0; i < 7; ++i) before[i] = robot.drives[i].position_counts();
    for (int period = 0; period < 30; ++period) {
      robot.period();
      for (std::size_t i = 0; i < 7; ++i) {
        if (robot.drives[i].state() != DriveState::kOperationEnabled) continue;
        const DriveObjects& objects = robot.drives[i].objects();
        if (mode == CyclicMode::kVelocity) {
          ASSERT_EQ(objects.number(kTargetVelocity, 0), 0U);
        } else {
          ASSERT_NEAR(static_cast<std::int32_t>(objects.number(kTargetPosition, 0)), before[i], 1);
        }
      }
    }
    EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(robot.drives[i].position_counts(), before[i], 1);
  }
}

TEST(CanopenWordsTest, AStatusThatChangesBetweenSyncsIsSeenInTheNextPeriod) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  robot.drives[2].set_state(DriveState::kSwitchOnDisabled);
  robot.run_drives(1'000'000);
  robot.period();
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kLeftEnabled);
  EXPECT_EQ(robot.fault().t_ns, robot.t_ns);
  EXPECT_EQ(robot.count(DriveState::kQuickStopActive), 6U);  // and stopped in the same
}

TEST(CanopenWordsTest, AStatusThatWasLostShowsWithTheEventTimer) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  ASSERT_TRUE(robot.bus->drop({kStatuswords + kSickNode}, 1));
  robot.drives[2].set_state(DriveState::kSwitchOnDisabled);
  robot.run(4);
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kNone);  // nobody can know
  ASSERT_TRUE(robot.run_until(ArmState::kFault, 50));
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kLeftEnabled);
  EXPECT_EQ(robot.fault().axis, 2);
}

// One that says nothing new may be lost as well.
TEST(CanopenWordsTest, OneLostStatuswordIsNoFault) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move(0.2));
  ASSERT_TRUE(robot.bus->drop({kStatuswords + kSickNode}, 1));
  robot.run(300);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
}

TEST(CanopenWordsTest, ADriveWithoutEventTimerIsAsked) {
  CanopenRobot robot;
  robot.drives[2].refuse(kTpdoCommunication + 1, kPdoTimerSub, kAbortNoSubIndex);
  robot.drives[2].refuse(kTpdoCommunication + 1, kPdoInhibitSub, kAbortNoSubIndex);
  ASSERT_TRUE(robot.bus->drop({kStatuswords + kSickNode}));  // not even the first one
  ASSERT_TRUE(robot.boot()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.arm.master().axis(2).objects_left_out(), 2);
  robot.bus->clear_faults();
  ASSERT_TRUE(robot.enable());
  ASSERT_TRUE(robot.bus->drop({kStatuswords + kSickNode}));
  robot.run(500);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
  robot.drives[2].set_state(DriveState::kSwitchOnDisabled);
  ASSERT_TRUE(robot.run_until(ArmState::kFault, 54));
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kLeftEnabled);

  CanopenRobot mute;
  mute.drives[2].refuse(kTpdoCommunication + 1, kPdoTimerSub, kAbortNoSubIndex);
  ASSERT_TRUE(mute.move(0.2));
  ASSERT_TRUE(mute.bus->drop({kSdoResponseCobId + kSickNode}));
  ASSERT_TRUE(mute.run_until(ArmState::kFault, 127));
  EXPECT_EQ(mute.fault().kind, ArmFaultKind::kStatusMissing);
}

// An answer that was overtaken by a statusword says what was before.
TEST(CanopenWordsTest, AnAnswerThatComesLateIsNotBelieved) {
  CanopenRobot robot;
  robot.drives[2].refuse(kTpdoCommunication + 1, kPdoTimerSub, kAbortNoSubIndex);
  ASSERT_TRUE(robot.move(0.2));
  ASSERT_TRUE(robot.bus->drop({kSdoResponseCobId + kSickNode}));
  while (true) {
    (void)robot.heard();
    robot.period();
    const std::vector<CanFrame> frames = robot.heard();
    if (std::any_of(frames.begin(), frames.end(),
                    [](const CanFrame& frame) { return frame.id == kSdoRequestCobId + kSickNode; })) {
      break;
    }
    ASSERT_EQ(robot.feedback.state, ArmState::kEnabled);
  }
  robot.run(1);
  ASSERT_TRUE(robot.free_port().send(can_frame(kStatuswords + kSickNode, {0x37, 0x12})));
  robot.run(1);
  robot.bus->clear_faults();
  ASSERT_TRUE(robot.free_port().send(
      can_frame(kSdoResponseCobId + kSickNode, {0x4B, 0x41, 0x60, 0, 0x50, 0x02, 0, 0})));
  robot.run(2);
  EXPECT_EQ(robot.arm.master().axis(2).statusword(), 0x1237);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
}

TEST(CanopenWordsTest, TheQuickStopComesBeforeSyncAndUntilTheDriveSaysSo) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  ASSERT_TRUE(robot.bus->drop({kControlwords + kSickNode}, 3));
  robot.drives[5].emergency(0x7305);
  robot.period();
  (void)robot.heard();
  robot.period();
  const std::vector<CanFrame> first = robot.heard();
  ASSERT_GE(first.size(), 15U);
  for (std::uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(first[i].id, 0x30BU + i + (i >= 2 ? 1 : 0));  // that to axis 3 is lost
    EXPECT_EQ(get_number(first[i].payload(), 2), 0x0002U);
  }
  EXPECT_EQ(first[6].id, 0x080U);
  EXPECT_EQ(robot.count(DriveState::kQuickStopActive), 6U);
  // Not even the drive that did not hear of it moves on: its velocity is zero with the SYNC after.
  robot.period();
  EXPECT_EQ(robot.drives[2].state(), DriveState::kOperationEnabled);
  EXPECT_EQ(robot.drives[2].objects().number(kTargetVelocity, 0), 0U);
  robot.run(2);
  EXPECT_EQ(robot.drives[2].state(), DriveState::kQuickStopActive);
  (void)robot.heard();
  robot.run(2);  // it has said so
  for (const CanFrame& frame : robot.heard()) EXPECT_NE(frame.id & 0x780, kControlwords);
}

TEST(CanopenWordsTest, AWordThatWasLostIsSentAgain) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.boot());
  ASSERT_TRUE(robot.bus->drop({kControlwords + kSickNode}, 2));
  robot.request = ArmRequest::kEnable;
  ASSERT_TRUE(robot.run_until(ArmState::kEnabled, 30)) << robot.drives[2].statusword();
}

// By the edge of its bit, which a word that is sent only as it changes must still make; also the second time,
// and where the first edge is lost.
TEST(CanopenWordsTest, AFaultIsResetByAnEdge) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move());
  for (const std::uint32_t lost : {0U, 0U, 1U}) {
    robot.drives[2].fail(0x4310);
    ASSERT_TRUE(robot.run_until(ArmState::kFault, 3));
    robot.request = ArmRequest::kDisable;
    robot.run(100);
    ASSERT_EQ(robot.drives[2].state(), DriveState::kFault);
    if (lost > 0) {
      ASSERT_TRUE(robot.bus->drop({kControlwords + kSickNode}, lost));
    }
    robot.arm.request(ArmRequest::kResetFault);
    (void)robot.heard();
    Words words;
    for (int i = 0; i < 8; ++i) {
      robot.period();
      for (const std::uint32_t word : words_to(robot.heard(), kSickNode)) words.push_back(word);
    }
    EXPECT_EQ(words, lost == 0 ? (Words{0x80, 0x00}) : (Words{0x00, 0x80, 0x00}));
    EXPECT_EQ(robot.feedback.state, ArmState::kDisabled) << describe(robot.fault()).data();
    ASSERT_TRUE(robot.enable());
    robot.run(50);
  }
}

// Words that the bus did not take count as not sent: enabling takes the one period longer, no more.
TEST(CanopenWordsTest, ARefusedWordIsTriedAgainInTheNextPeriod) {
  int periods[2] = {};
  for (const bool is_full : {false, true}) {
    CanopenRobot robot;
    for (SimulatedDrive& drive : robot.drives) drive.refuse(kCyclePeriod, 0, kAbortNoObject);
    ASSERT_TRUE(robot.boot());
    robot.request = ArmRequest::kEnable;
    robot.run(1);
    robot.master_port().set_full(is_full);
    robot.run(1);
    robot.master_port().set_full(false);
    while (robot.feedback.state == ArmState::kEnabling && periods[is_full] < 40) {
      robot.period();
      ++periods[is_full];
    }
    EXPECT_EQ(robot.feedback.state, ArmState::kEnabled) << describe(robot.fault()).data();
  }
  EXPECT_EQ(periods[1], periods[0] + 1);
}

// Started is not yet listening: until a drive is known to run, it is told each period.
TEST(CanopenWordsTest, ADriveThatMayNotHearYetIsToldAgain) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.bus->drop({kStatuswords + kSickNode}, 1));
  for (int i = 0; i < 200 && robot.arm.master().axis(2).phase() != AxisPhase::kAwaitStart; ++i)
    robot.period();
  (void)robot.heard();
  for (int i = 0; i < 20; ++i) {
    robot.period();
    ASSERT_EQ(robot.arm.master().axis(2).phase(), AxisPhase::kAwaitStart);
    EXPECT_EQ(words_to(robot.heard(), kSickNode), (Words{0x00}));
  }
  EXPECT_TRUE(robot.boot());  // by the event timer
}

// A bit that flickers costs one frame a period and drive, and no fault.
TEST(CanopenWordsTest, AFlickeringStatuswordIsHeldBack) {
  CanopenRobot robot;
  ASSERT_TRUE(robot.move(0.2));
  (void)robot.heard();
  int statuswords = 0;
  for (int period = 0; period < 100; ++period) {
    robot.period();
    for (int part = 0; part < 8; ++part) {
      const int bit = part % 2 == 0 ? kStatusTargetReached : 0;
      robot.drives[2].show_statusword(static_cast<std::uint16_t>(0x1237 | bit));
      robot.run_drives(200'000 * (part + 1));
    }
    for (const CanFrame& frame : robot.heard()) statuswords += frame.id == kStatuswords + kSickNode ? 1 : 0;
  }
  EXPECT_LE(statuswords, 100);
  EXPECT_GE(statuswords, 50);
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
}

}  // namespace
}  // namespace vergence::canopen
