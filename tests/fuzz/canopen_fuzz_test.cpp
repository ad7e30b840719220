// Whatever is on the bus: no crash, no read or write out of bounds (with the sanitizers), and never a
// velocity beyond the limits, nor a drive that moves in an arm that is in a fault.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "hal/canopen/sdo_server.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"
#include "tests/support/random.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::CanRecorder;
using testing::Random;

// Any bits, but often an identifier that somebody listens to, and a length of more than there is room for.
CanFrame random_frame(Random& random) {
  static constexpr std::uint32_t kFunctions[] = {0x000, 0x080, 0x180, 0x200, 0x280,
                                                 0x300, 0x580, 0x600, 0x700};
  CanFrame frame;
  frame.id = kFunctions[random.below(9)] + static_cast<std::uint32_t>(random.below(10) + 9);
  if (random.below(8) == 0) frame.id = static_cast<std::uint32_t>(random.bits());
  if (random.below(20) == 0) frame.id = random.below(2) == 0 ? 0x000 : 0x080;
  frame.size = static_cast<std::uint8_t>(random.below(4) == 0 ? random.below(256) : 8);
  const bool is_pdo = frame.id >= 0x180 && frame.id < 0x380;
  // As they are mapped: PDO 1 is four bytes, PDO 2 is two.
  if (is_pdo && random.below(2) == 0) frame.size = frame.id < 0x280 ? 4 : 2;
  const std::uint64_t bits = random.bits();
  std::memcpy(frame.data.data(), &bits, sizeof bits);
  if (random.below(2) == 0)
    frame.data[0] = static_cast<std::uint8_t>(random.below(8) << 5 | random.below(32));
  if (random.below(3) == 0) frame.data[1] = static_cast<std::uint8_t>(11 + random.below(7));
  frame.is_remote = random.below(50) == 0;
  frame.is_error = random.below(50) == 0;
  frame.stamp_ns = static_cast<std::int64_t>(random.bits() >> 1);
  return frame;
}

TEST(CanopenFuzz, SdoClient) {
  Random random(1);
  CanRecorder bus;
  SdoClient client;
  client.init(11, 1'000'000);
  int done = 0;
  int aborted = 0;
  std::int64_t t_ns = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::array<std::uint8_t, kMaxSdoBytes> bytes{};
    const auto length = static_cast<std::size_t>(random.below(static_cast<int>(kMaxSdoBytes) + 1));
    const auto index = static_cast<std::uint16_t>(0x6000 + random.below(2));
    if (client.state() != SdoState::kBusy) {
      const bool reads = random.below(2) == 0;
      (void)(reads ? client.read(index, 0, t_ns)
                   : client.write(index, 0, std::span(bytes).first(length), t_ns));
    }
    client.process(t_ns, FrameSink(bus));
    bus.sent.clear();
    CanFrame frame = random_frame(random);
    frame.id = 0x58B;
    if (random.below(4) != 0) {
      // Of the right object, so that transfers get on.
      frame.size = 8;
      frame.is_remote = frame.is_error = false;
      frame.data[1] = static_cast<std::uint8_t>(random.below(2));
      frame.data[2] = 0x60;
      frame.data[3] = 0;
    }
    client.receive(frame, t_ns);
    ASSERT_LE(client.bytes().size(), kMaxSdoBytes);
    done += client.state() == SdoState::kDone ? 1 : 0;
    aborted += client.state() == SdoState::kAborted ? 1 : 0;
    t_ns += random.below(100'000);
  }
  EXPECT_GT(done, 1000);
  EXPECT_GT(aborted, 1000);
}

TEST(CanopenFuzz, SdoServer) {
  Random random(2);
  DriveObjects objects;
  objects.init(11, 1);
  SdoServer server;
  server.init(11);
  int aborts = 0;
  int written = 0;
  for (int i = 0; i < 200'000; ++i) {
    CanFrame request = random_frame(random);
    request.id = 0x60B;
    if (random.below(4) != 0) request.size = 8;
    if (random.below(2) == 0) {
      // Objects that are there, often the one of variable length.
      static constexpr std::uint16_t kIndices[] = {0x1000, 0x1008, 0x1400, 0x1600, 0x1A00, 0x2000, 0x6060};
      const std::uint16_t index = kIndices[random.below(7)];
      request.data[1] = static_cast<std::uint8_t>(index);
      request.data[2] = static_cast<std::uint8_t>(index >> 8);
      request.data[3] = static_cast<std::uint8_t>(index < 0x1A01 && index >= 0x1400 ? random.below(3) : 0);
      if (random.below(2) == 0) std::memset(request.data.data() + 4, random.below(60), 1);
      if (random.below(2) == 0) std::memset(request.data.data() + 5, 0, 3);
    }
    CanFrame answer;
    std::uint16_t index = 0;
    if (!server.receive(request, objects, answer, index)) continue;
    ASSERT_EQ(answer.id, 0x58BU);
    ASSERT_EQ(answer.size, 8);
    aborts += answer.data[0] == 0x80 ? 1 : 0;
    written += index != 0 ? 1 : 0;
    ASSERT_LE(objects.size(0x2000, 0), DriveObjects::kMaxBytes);
  }
  EXPECT_GT(aborts, 1000);
  EXPECT_GT(written, 1000);
}

TEST(CanopenFuzz, MasterAloneWithNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    MemoryBus bus;
    CanopenArm<MemoryBus::Port> arm(bus.port(0));
    ASSERT_EQ(arm.init(testing::config_of_drives(), 0).finding, ConfigFinding::kNone);
    ArmFeedback feedback;
    for (int period = 1; period < 1500; ++period) {
      for (int i = random.below(30); i > 0; --i) (void)bus.port(1).send(random_frame(random));
      arm.process(2'000'000LL * period);
      (void)arm.read(feedback);
      arm.request(static_cast<ArmRequest>(random.below(4)));
      arm.command({1e300, -1e300, std::nan(""), 0, 1, 2, 3});
      for (int i = 0; i < 7; ++i) ASSERT_TRUE(std::isfinite(arm.master().axis(i).velocity_rad_per_s()));
      ASSERT_NE(describe(arm.master().fault())[0], '\0');
      for (CanFrame frame; bus.port(1).receive(frame);) ASSERT_LE(frame.size, 8);
    }
  }
}

// A whole arm on a noisy bus, noise that even imitates drives and master. It may be stopped at any time; what
// must hold is that a drive of an arm that has been in a fault for two periods is not enabled.
TEST(CanopenFuzz, ArmWithNoise) {
  int faults = 0;
  int moved = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Random random(100 + seed);
    const auto robot = std::make_unique<CanopenRobot>();
    (void)robot->move();
    int periods_in_fault = 0;
    for (int period = 0; period < 600; ++period) {
      if (random.below(40) == 0) {
        CanFrame noise = random_frame(random);
        // Commands to the drives are the master's alone: whoever imitates those can do anything.
        const std::uint32_t function = noise.id & 0x780;
        const bool commands =
            function == 0x000 || function == 0x200 || function == 0x300 || function == 0x600;
        if (!commands) (void)robot->free_port().send(noise);
      }
      robot->request = random.below(3) == 0 ? ArmRequest::kDisable : ArmRequest::kEnable;
      if (period % 10 != 0) robot->request = ArmRequest::kEnable;
      if (random.below(50) == 0) robot->arm.request(ArmRequest::kResetFault);
      for (double& v : robot->velocity_rad_per_s) v = random.between(-1, 1);
      robot->period();
      const bool in_fault = robot->fed_back && robot->feedback.state == ArmState::kFault;
      periods_in_fault = in_fault ? periods_in_fault + 1 : 0;
      faults += periods_in_fault == 1 ? 1 : 0;
      moved += robot->feedback.state == ArmState::kEnabled ? 1 : 0;
      if (periods_in_fault >= 2) {
        ASSERT_EQ(robot->count(DriveState::kOperationEnabled), 0U) << seed << " " << period;
      }
    }
  }
  EXPECT_GT(faults, 20);
  EXPECT_GT(moved, 500);
}

TEST(CanopenFuzz, DriveAloneWithNoise) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(200 + seed);
    CanRecorder bus;
    SimulatedDrive drive;
    SimulatedDriveOptions options;
    options.node_id = 11;
    drive.init(options, 0);
    std::int64_t t_ns = 0;
    for (int i = 0; i < 10'000; ++i) {
      drive.receive(random_frame(random), t_ns);
      drive.process(t_ns, FrameSink(bus));
      for (const CanFrame& frame : bus.sent) ASSERT_LE(frame.size, 8);
      bus.sent.clear();
      t_ns += random.below(500'000);
      ASSERT_TRUE(std::isfinite(drive.position_counts()));
    }
  }
}

}  // namespace
}  // namespace vergence::canopen
