// Seven axes at 1 kHz on two buses: brought up, switched on and moved together, and stopped together whatever
// goes wrong on one of the two.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "hal/canopen/objects.hpp"
#include "hal/canopen/socket_can.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanopenRobot;
using testing::config_of_two_buses;

TEST(CanopenTwoBusesTest, BootsEnablesAndMovesTheAxesOfBoth) {
  CanopenRobot robot(config_of_two_buses());
  ASSERT_EQ(robot.found, ConfigFinding::kNone);
  ASSERT_TRUE(robot.boot()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.count(DriveState::kSwitchOnDisabled), 7U);
  ASSERT_TRUE(robot.enable()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 7U);
  const ArmFeedback before = robot.feedback;
  for (std::size_t i = 0; i < 7; ++i) {
    robot.velocity_rad_per_s[i] = 0.1 * static_cast<double>(i + 1) * (i % 3 == 0 ? -1 : 1);
  }
  robot.run(1000);
  EXPECT_EQ(robot.feedback.stamp_ns - before.stamp_ns, 1'000'000'000);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(robot.feedback.velocity_rad_per_s[i], robot.velocity_rad_per_s[i], 2e-2) << i;
    // Two periods and the drives' lag behind.
    EXPECT_NEAR(robot.feedback.position_rad[i] - before.position_rad[i], robot.velocity_rad_per_s[i],
                0.02 * std::abs(robot.velocity_rad_per_s[i]) + 1e-4)
        << i;
  }
  robot.request = ArmRequest::kDisable;
  ASSERT_TRUE(robot.run_until(ArmState::kDisabled, 300));
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kNone);
  EXPECT_EQ(robot.count(DriveState::kSwitchOnDisabled), 7U);
}

TEST(CanopenTwoBusesTest, SyncAndHeartbeatGoOutOnBothInTheSamePeriod) {
  CanopenRobot robot(config_of_two_buses());
  ASSERT_TRUE(robot.move());
  for (const int bus : {0, 1}) (void)robot.heard(bus);
  std::array<int, 2> beats{};
  for (int period = 0; period < 100; ++period) {
    robot.period();
    for (const int bus : {0, 1}) {
      int syncs = 0;
      for (const CanFrame& frame : robot.heard(bus)) {
        if (frame.id == kSyncCobId) ++syncs;
        if (frame.id == kHeartbeatCobId + robot.config.master_node_id) ++beats[static_cast<std::size_t>(bus)];
      }
      ASSERT_EQ(syncs, 1) << bus << " " << period;
    }
  }
  EXPECT_EQ(beats, (std::array<int, 2>{5, 5}));
}

TEST(CanopenTwoBusesTest, AreNotToBeHadOfOne) {
  MemoryBus bus;
  CanopenArm<MemoryBus::Port> arm(bus.port(0));
  EXPECT_EQ(arm.init(config_of_two_buses(), 0).finding, ConfigFinding::kBus);
  EXPECT_EQ(arm.init(testing::config_of_drives(), 0).finding, ConfigFinding::kNone);
}

// What has the same identifier on the other bus is somebody else's.
TEST(CanopenTwoBusesTest, WhatIsSaidOnOneBusIsNotHeardOnTheOther) {
  CanopenRobot robot(config_of_two_buses());
  ASSERT_TRUE(robot.move());
  ASSERT_TRUE(robot.free_port(1).send(can_frame(0x08C, {0x10, 0x23, 1, 0, 0, 0, 0, 0})));
  robot.run(2);
  EXPECT_EQ(robot.fault().axis, 5);  // node 12 of the second bus, not axis 1 that is node 12 of the first
  EXPECT_EQ(robot.arm.master().axis(1).fault().kind, ArmFaultKind::kNone);
  EXPECT_EQ(robot.arm.master().axis(5).fault().kind, ArmFaultKind::kEmergency);
}

// Of a drive that cannot skip the other's bytes, at boot and not later.
TEST(CanopenTwoBusesTest, ADriveWithoutDummyEntriesIsNeverEnabled) {
  CanopenRobot robot(config_of_two_buses());
  robot.drives[1].refuse(kRpdoMapping, 1, kAbortNotMappable);
  EXPECT_FALSE(robot.boot());
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kSdoAbort);
  EXPECT_EQ(robot.fault().axis, 1);
  EXPECT_EQ(robot.fault().index, kRpdoMapping);
  EXPECT_EQ(robot.fault().detail, kAbortNotMappable);
}

// The words that stop the four of a bus may push a position into the next period: that is no second fault,
// and a normal stop no fault at all. More than one is.
TEST(CanopenTwoBusesTest, OnePositionMayBeLateWhileTheArmIsBeingStopped) {
  CanopenRobot robot(config_of_two_buses());
  ASSERT_TRUE(robot.move(1));
  robot.request = ArmRequest::kDisable;
  robot.period();  // is asked for
  robot.its_bus(0).drop({0x18E, 0x7FF}, 1);
  robot.period();  // quick stop
  robot.period();
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kNone) << describe(robot.fault()).data();
  robot.its_bus(0).drop({0x18E, 0x7FF}, 2);
  robot.run(3);
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kPdoMissing);
  EXPECT_EQ(robot.fault().axis, 3);
}

TEST(CanopenTwoBusesTest, ASyncThatWasRefusedOnOneBusMovesNoStampAndIsNoFaultYet) {
  CanopenRobot robot(config_of_two_buses());
  ASSERT_TRUE(robot.move());
  robot.master_port(1).set_full(true);
  robot.period();
  robot.master_port(1).set_full(false);
  const std::int64_t stamp_ns = robot.feedback.stamp_ns;
  robot.period();
  EXPECT_EQ(robot.feedback.stamp_ns, stamp_ns);  // of the second bus nothing newer is known
  EXPECT_EQ(robot.feedback.state, ArmState::kEnabled);
  EXPECT_EQ(robot.fault().kind, ArmFaultKind::kNone);
}

// ---- faults of one bus ------------------------------------------------------------------------------------

struct BusFault {
  const char* name;
  std::function<void(CanopenRobot&, int bus)> begin;
  std::function<void(CanopenRobot&, int bus)> end;
  ArmFaultKind kind;
  bool of_the_bus;      // or of a drive on it
  int noticed_periods;  // after so many at most
};

// The last axis on a bus.
std::size_t sick_axis(int bus) {
  return bus == 0 ? 3 : 6;
}
SimulatedDrive& sick(CanopenRobot& robot, int bus) {
  return robot.drives[sick_axis(bus)];
}

void nothing(CanopenRobot&, int) {}

std::vector<BusFault> bus_faults() {
  return {
      {"BusOff", [](CanopenRobot& r, int bus) { r.master_port(bus).set_off(true); },
       [](CanopenRobot& r, int bus) { r.master_port(bus).set_off(false); }, ArmFaultKind::kBusOff, true, 1},
      {"QueueFull", [](CanopenRobot& r, int bus) { r.master_port(bus).set_full(true); },
       [](CanopenRobot& r, int bus) { r.master_port(bus).set_full(false); }, ArmFaultKind::kTransmitFull,
       true, 3},
      {"CableCut",
       [](CanopenRobot& r, int bus) {
         r.its_bus(bus).drop({0, 0});
       },
       [](CanopenRobot& r, int bus) { r.its_bus(bus).clear_faults(); }, ArmFaultKind::kPdoMissing, false, 2},
      {"PowerLost", [](CanopenRobot& r, int bus) { sick(r, bus).set_power(false); },
       [](CanopenRobot& r, int bus) { sick(r, bus).set_power(true); }, ArmFaultKind::kPdoMissing, false, 2},
      {"Emergency", [](CanopenRobot& r, int bus) { sick(r, bus).fail(0x3210); }, nothing,
       ArmFaultKind::kEmergency, false, 2},
      {"HeartbeatMissing", [](CanopenRobot& r, int bus) { sick(r, bus).set_heartbeat(false); },
       [](CanopenRobot& r, int bus) { sick(r, bus).set_heartbeat(true); }, ArmFaultKind::kHeartbeatLost,
       false, 52},
  };
}

class CanopenTwoBusesFaultTest : public ::testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(CanopenTwoBusesFaultTest, OfOneBusStopsTheAxesOfBoth) {
  const BusFault fault = bus_faults()[std::get<0>(GetParam())];
  const int bus = std::get<1>(GetParam());
  CanopenRobot robot(config_of_two_buses());
  ASSERT_TRUE(robot.move(0.5));
  fault.begin(robot, bus);
  int periods = 0;
  while (robot.fault().kind == ArmFaultKind::kNone && periods < fault.noticed_periods) {
    ++periods;
    robot.period();
  }
  EXPECT_EQ(robot.fault().kind, fault.kind) << describe(robot.fault()).data();
  EXPECT_EQ(robot.feedback.state, ArmState::kFault);
  EXPECT_EQ(robot.fault().bus, fault.of_the_bus ? bus : -1);
  if (!fault.of_the_bus) {
    EXPECT_EQ(robot.config.axis[static_cast<std::size_t>(robot.fault().axis)].bus, bus);
  }
  // In the period in which it was noticed, the axes of the other bus; those of this one at the latest in the
  // next: by the quick stop, or because they miss SYNC.
  for (std::size_t i = 0; i < 7; ++i) {
    if (robot.config.axis[i].bus != bus) {
      EXPECT_EQ(robot.drives[i].state(), DriveState::kQuickStopActive) << i;
    }
  }
  robot.run(1);
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 0U);
  robot.run(200);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(robot.drives[i].velocity_counts_per_s(), 0) << i;

  // And moves again, once it was mended, reset, and asked for.
  fault.end(robot, bus);
  robot.velocity_rad_per_s.fill(0);
  robot.request = ArmRequest::kDisable;
  robot.run(100);
  EXPECT_EQ(robot.feedback.state, ArmState::kFault);
  robot.arm.request(ArmRequest::kResetFault);
  ASSERT_TRUE(robot.run_until(ArmState::kDisabled, 1200)) << describe(robot.fault()).data();
  ASSERT_TRUE(robot.enable()) << describe(robot.fault()).data();
  EXPECT_EQ(robot.count(DriveState::kOperationEnabled), 7U);
}

INSTANTIATE_TEST_SUITE_P(Faults, CanopenTwoBusesFaultTest,
                         ::testing::Combine(::testing::Range(std::size_t{0}, bus_faults().size()),
                                            ::testing::Values(0, 1)),
                         [](const auto& it) {
                           return std::string(bus_faults()[std::get<0>(it.param)].name) + "OnBus" +
                                  std::to_string(std::get<1>(it.param) + 1);
                         });

// ---- where the kernel has two -----------------------------------------------------------------------------

std::int64_t monotonic_ns() {
  timespec now{};
  (void)clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

class TwoVirtualCansTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const CanFilter all{0, 0};
    constexpr std::array kNames = {"vcan0", "vcan1"};
    for (std::size_t bus = 0; bus < 2; ++bus) {
      std::array<CanFilter, kMaxFilters> filters{};
      const std::size_t count = receive_filters(config, static_cast<int>(bus), filters);
      const SocketStep step = masters[bus].open(kNames[bus], std::span(filters).first(count));
      if (step != SocketStep::kOk) {
        GTEST_SKIP() << kNames[bus] << ": " << describe(step) << " ("
                     << std::strerror(masters[bus].last_errno()) << ")";
      }
      ASSERT_EQ(drives_side[bus].open(kNames[bus], std::span(&all, 1)), SocketStep::kOk);
    }
    t_ns = monotonic_ns();
    for (std::size_t i = 0; i < 7; ++i) {
      SimulatedDriveOptions options;
      options.node_id = config.axis[i].node_id;
      options.counts_per_velocity_unit = 10;
      options.start_counts = config.axis[i].zero_counts;
      drives[i].init(options, t_ns);
    }
    ASSERT_EQ(arm.init(config, t_ns).finding, ConfigFinding::kNone);
  }

  // Time is what it is said to be. Only the frames go through the kernel, which may want the processor for
  // it.
  static void let_frames_pass() { std::this_thread::sleep_for(std::chrono::microseconds(100)); }
  void period() {
    t_ns += config.sync_period_ns;
    arm.process(t_ns);
    let_frames_pass();
    for (std::size_t bus = 0; bus < 2; ++bus) {
      drives_side[bus].process(t_ns);
      for (CanFrame frame; !is_cut[bus] && drives_side[bus].receive(frame);) {
        for (std::size_t i = 0; i < 7; ++i) {
          if (config.axis[i].bus == bus) drives[i].receive(frame, t_ns);
        }
      }
    }
    for (std::size_t i = 0; i < 7; ++i) {
      drives[i].process(t_ns, FrameSink(drives_side[config.axis[i].bus]));
    }
    let_frames_pass();
    (void)arm.read(feedback);
    arm.request(request);
    arm.command(velocity_rad_per_s);
  }
  bool run_until(ArmState state, int most_periods) {
    for (int i = 0; i < most_periods; ++i) {
      period();
      if (feedback.state == state && feedback.stamp_ns != 0) return true;
    }
    return false;
  }

  CanopenArmConfig config = config_of_two_buses();
  std::array<SocketCan, 2> masters;
  std::array<SocketCan, 2> drives_side;
  CanopenArm<SocketCan> arm{masters[0], masters[1]};
  std::array<SimulatedDrive, 7> drives;
  std::array<bool, 2> is_cut{};
  std::array<double, kMaxJoints> velocity_rad_per_s{};
  ArmRequest request = ArmRequest::kDisable;
  ArmFeedback feedback;
  std::int64_t t_ns = 0;
};

TEST_F(TwoVirtualCansTest, SevenAxesMoveAndStopTogether) {
  ASSERT_TRUE(run_until(ArmState::kDisabled, 1000)) << describe(arm.master().fault()).data();
  request = ArmRequest::kEnable;
  ASSERT_TRUE(run_until(ArmState::kEnabled, 200)) << describe(arm.master().fault()).data();
  velocity_rad_per_s.fill(0.5);
  for (int i = 0; i < 300; ++i) period();
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(feedback.velocity_rad_per_s[i], 0.5, 0.02) << i;
  is_cut[1] = true;
  for (int i = 0; i < 3; ++i) period();
  EXPECT_EQ(arm.master().fault().kind, ArmFaultKind::kPdoMissing);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(drives[i].state(), DriveState::kQuickStopActive) << i;
}

}  // namespace
}  // namespace vergence::canopen
