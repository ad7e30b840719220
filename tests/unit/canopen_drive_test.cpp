// The simulated drive by itself, spoken to by hand: the other side of the protocol must be right too, or the
// tests of the master would prove nothing.
#include <gtest/gtest.h>

#include "hal/canopen/objects.hpp"
#include "hal/canopen/simulated_drive.hpp"
#include "tests/support/can_recorder.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanRecorder;

constexpr std::int64_t kMs = 1'000'000;

class SimulatedDriveTest : public ::testing::Test {
 protected:
  SimulatedDriveTest() {
    SimulatedDriveOptions options;
    options.node_id = 5;
    drive.init(options, 0);
    step();
  }
  void say(std::uint32_t id, std::initializer_list<int> bytes) { drive.receive(can_frame(id, bytes), t_ns); }
  void step(std::int64_t dt_ns = kMs) {
    t_ns += dt_ns;
    drive.process(t_ns, FrameSink(bus));
  }
  // Frames with this identifier since the last call, the others are forgotten.
  std::vector<CanFrame> heard(std::uint32_t id) {
    std::vector<CanFrame> frames;
    for (const CanFrame& frame : bus.sent) {
      if (frame.id == id) frames.push_back(frame);
    }
    bus.sent.clear();
    return frames;
  }
  void write(int index, int size, int value) {
    const int command = size == 1 ? 0x2F : size == 2 ? 0x2B : 0x23;
    say(0x605,
        {command, index & 0xFF, index >> 8, 0, value & 0xFF, value >> 8 & 0xFF, value >> 16 & 0xFF, 0});
    step();
    const std::vector<CanFrame> answers = heard(0x585);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].data[0], 0x60) << std::hex << index;
  }
  void obey(int controlword) { write(0x6040, 2, controlword); }
  void enable(int mode = kModeCyclicVelocity) {
    write(0x6060, 1, mode);
    for (const int word : {0x06, 0x07, 0x0F}) obey(word);
    ASSERT_EQ(drive.state(), DriveState::kOperationEnabled);
  }

  CanRecorder bus;
  SimulatedDrive drive;
  std::int64_t t_ns = 0;
};

TEST_F(SimulatedDriveTest, SaysThatItHasBooted) {
  const std::vector<CanFrame> frames = heard(0x705);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].data[0], 0x00);
  EXPECT_EQ(drive.nmt(), NmtState::kPreOperational);
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
}

TEST_F(SimulatedDriveTest, ObeysNetworkManagement) {
  say(0x000, {0x01, 0x06});
  EXPECT_EQ(drive.nmt(), NmtState::kPreOperational);  // another node's
  say(0x000, {0x01, 0x00});
  EXPECT_EQ(drive.nmt(), NmtState::kOperational);
  say(0x000, {0x02, 0x05});
  EXPECT_EQ(drive.nmt(), NmtState::kStopped);
  say(0x605, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0});
  step();
  EXPECT_TRUE(heard(0x585).empty());  // no SDO while it is stopped
  say(0x000, {0x82, 0x05});
  step();
  EXPECT_EQ(heard(0x705).size(), 1U);
  EXPECT_EQ(drive.nmt(), NmtState::kPreOperational);
}

TEST_F(SimulatedDriveTest, BeatsAsItIsTold) {
  write(0x1017, 2, 10);
  heard(0x705);
  for (int i = 0; i < 100; ++i) step();
  EXPECT_EQ(heard(0x705).size(), 10U);
}

TEST_F(SimulatedDriveTest, WalksTheStateMachine) {
  obey(0x0F);
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
  obey(0x06);
  EXPECT_EQ(drive.state(), DriveState::kReadyToSwitchOn);
  obey(0x0F);  // switches on and enables in one
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
  obey(0x07);
  EXPECT_EQ(drive.state(), DriveState::kSwitchedOn);
  obey(0x00);
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
  drive.fail(0x2310);
  step();
  EXPECT_EQ(drive.state(), DriveState::kFault);
  obey(0x06);
  EXPECT_EQ(drive.state(), DriveState::kFault);
  obey(0x80);
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);
}

TEST_F(SimulatedDriveTest, QuickStopRampsAndLeavesByItsOption) {
  for (const int option : {2, 6}) {
    enable();
    write(0x605A, 2, option);
    write(0x6085, 4, 100'000);
    write(0x60FF, 4, 10'000);
    for (int i = 0; i < 200; ++i) step();
    EXPECT_NEAR(drive.velocity_counts_per_s(), 10'000, 1);
    const double before = drive.position_counts();
    obey(0x02);
    EXPECT_EQ(drive.state(), DriveState::kQuickStopActive);
    for (int i = 0; i < 120; ++i) step();
    EXPECT_EQ(drive.velocity_counts_per_s(), 0);
    EXPECT_NEAR(drive.position_counts() - before, 500, 20);  // v^2 / 2a
    EXPECT_EQ(drive.state(), option == 2 ? DriveState::kSwitchOnDisabled : DriveState::kQuickStopActive);
    obey(0x00);
  }
}

TEST_F(SimulatedDriveTest, SendsAndTakesProcessDataWithSync) {
  write(0x6060, 1, kModeCyclicVelocity);
  say(0x605, {0x2F, 0x00, 0x14, 2, 1, 0, 0, 0});  // both with each SYNC
  say(0x605, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});
  say(0x080, {});
  step();
  EXPECT_TRUE(heard(0x185).empty());  // not operational
  say(0x000, {0x01, 0x05});
  say(0x205, {0x06, 0x00});                                 // the mapping of the standard: controlword alone
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);  // waits for SYNC
  say(0x080, {});
  EXPECT_EQ(drive.state(), DriveState::kReadyToSwitchOn);
  step();
  const std::vector<CanFrame> frames = heard(0x185);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].size, 2);
  EXPECT_EQ(frames[0].data[0], 0x31);
  EXPECT_EQ(frames[0].data[1], 0x02);
  say(0x205, {0x07});  // too short
  step();
  const std::vector<CanFrame> emergencies = heard(0x085);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].data[1], 0x82);
}

// PDO 2 as CiA 402 has it by default: words of the state machine and the mode, on events.
TEST_F(SimulatedDriveTest, TakesAnEventDrivenPdoAtOnce) {
  say(0x305, {0x06, 0x00, 0x09});
  EXPECT_EQ(drive.state(), DriveState::kSwitchOnDisabled);  // not operational
  say(0x000, {0x01, 0x05});
  say(0x305, {0x06, 0x00, 0x09});
  EXPECT_EQ(drive.state(), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(drive.objects().number(kModeDisplay, 0), 9U);
}

TEST_F(SimulatedDriveTest, SendsAnEventDrivenPdoAsItChanges) {
  say(0x605, {0x2F, 0x00, 0x18, 2, 1, 0, 0, 0});  // PDO 1 with SYNC, of which there is none
  step();
  EXPECT_TRUE(heard(0x285).empty());
  say(0x000, {0x01, 0x05});
  step();
  std::vector<CanFrame> frames = heard(0x285);
  ASSERT_EQ(frames.size(), 1U);  // the first, so that everybody knows
  EXPECT_EQ(frames[0].size, 3);
  EXPECT_EQ(frames[0].data[0], 0x50);
  for (int i = 0; i < 1000; ++i) step();
  EXPECT_TRUE(heard(0x285).empty());
  say(0x305, {0x06, 0x00, 0x00});
  step();
  frames = heard(0x285);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].data[0], 0x31);
  // What could not be sent is sent later, with what is true by then.
  bus.is_full = true;
  say(0x305, {0x07, 0x00, 0x00});
  step();
  say(0x305, {0x0F, 0x00, 0x00});
  step();
  bus.is_full = false;
  step();
  frames = heard(0x285);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].data[0], 0x37);
}

TEST_F(SimulatedDriveTest, AnEventTimerRepeatsAndAnInhibitTimeHoldsBack) {
  say(0x605, {0x2B, 0x01, 0x18, 3, 50, 0, 0, 0});
  step();
  EXPECT_EQ(heard(0x585).at(0).data[0], 0x80);  // not while it is on
  say(0x605, {0x23, 0x01, 0x18, 1, 0x85, 0x02, 0, 0xC0});
  step();
  say(0x605, {0x2B, 0x01, 0x18, 3, 50, 0, 0, 0});  // 5 ms
  step();
  say(0x605, {0x2B, 0x01, 0x18, 5, 20, 0, 0, 0});  // 20 ms
  step();
  say(0x000, {0x01, 0x05});
  step();
  EXPECT_TRUE(heard(0x285).empty());  // off
  say(0x605, {0x23, 0x01, 0x18, 1, 0x85, 0x02, 0, 0x40});
  step();
  EXPECT_EQ(heard(0x285).size(), 1U);
  for (int i = 0; i < 200; ++i) step();
  EXPECT_EQ(heard(0x285).size(), 10U);
  for (int i = 0; i < 100; ++i) {
    drive.show_statusword(static_cast<std::uint16_t>(0x0650 ^ (i % 2) << 10));
    step();
  }
  EXPECT_EQ(heard(0x285).size(), 20U);
}

TEST_F(SimulatedDriveTest, MissesItsMasterAndSync) {
  enable();
  write(0x6007, 2, 3);
  say(0x605, {0x23, 0x16, 0x10, 1, 50, 0, 0x7F, 0});
  write(0x1006, 4, 2000);
  say(0x000, {0x01, 0x05});
  for (int i = 0; i < 200; ++i) step();
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);  // neither was there yet
  say(0x080, {});
  step(2 * kMs);
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
  heard(0);
  step(2 * kMs);
  EXPECT_EQ(drive.state(), DriveState::kQuickStopActive);
  const std::vector<CanFrame> emergencies = heard(0x085);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].data[1], 0x87);
  say(0x77F, {0x05});
  step(50 * kMs);
  EXPECT_TRUE(heard(0x085).empty());
  step(1 * kMs);
  EXPECT_EQ(heard(0x085).size(), 1U);
}

TEST_F(SimulatedDriveTest, NoticesThatItCannotFollowAPosition) {
  write(0x6065, 4, 1000);
  write(0x6066, 2, 5);
  enable(kModeCyclicPosition);
  drive.jam(true);
  write(0x607A, 4, 1001);
  step();
  EXPECT_EQ(drive.statusword() & kStatusFollowingError, kStatusFollowingError);
  EXPECT_EQ(drive.state(), DriveState::kOperationEnabled);
  for (int i = 0; i < 6; ++i) step();
  EXPECT_EQ(drive.state(), DriveState::kFault);
  const std::vector<CanFrame> emergencies = heard(0x085);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].data[0], 0x11);
  EXPECT_EQ(emergencies[0].data[1], 0x86);
}

}  // namespace
}  // namespace vergence::canopen
