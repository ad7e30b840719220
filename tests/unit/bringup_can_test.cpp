// The bus and its drives: every verdict, the answers of the kernel, and asking simulated drives, to whom
// nothing is ever sent that could move or change them.
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>

#include <cstring>
#include <functional>
#include <memory>

#include "hal/canopen/memory_bus.hpp"
#include "hal/canopen/objects.hpp"
#include "hal/canopen/simulated_drive.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"
#include "tests/support/findings.hpp"
#include "tools/bringup/ask_drives.hpp"
#include "tools/bringup/can_checks.hpp"
#include "tools/bringup/can_link.hpp"
#include "tools/bringup/read_only_bus.hpp"

namespace vergence::tools {
namespace {

using canopen::CanFrame;
using testing::can_frame;
using testing::expect_all_pass;
using testing::expect_complete;
using testing::expect_finding;

CanLink sound_link() {
  CanLink link;
  link.was_told = link.exists = link.is_can = link.is_up = true;
  link.tx_queue = 32;
  link.bitrate_bit_per_s = 1'000'000;
  link.state = CAN_STATE_ERROR_ACTIVE;
  link.errors = CanLink::ErrorCounters{};
  link.restart_ms = 100;
  return link;
}

CanConfig config_of_bus() {
  CanConfig config;
  config.arm = testing::config_of_drives();
  return config;
}

// ---- what may be sent
// ---------------------------------------------------------------------------------------

struct NoClock {
  std::int64_t now_ns() { return 0; }
};
struct NoSleeper {
  void sleep_until(std::int64_t) {}
};

TEST(ReadOnlyBusTest, LetsOnlyRequestsToReadThrough) {
  testing::CanRecorder recorder;
  NoClock clock;
  NoSleeper sleeper;
  ReadOnly bus(recorder, clock, sleeper);
  const std::vector<CanFrame> commands = {
      canopen::nmt_command(canopen::NmtCommand::kStart, 0),
      canopen::nmt_command(canopen::NmtCommand::kResetCommunication, 11),
      canopen::sync_frame(),
      canopen::heartbeat_frame(127, canopen::NmtState::kOperational),
      can_frame(0x20B, {0x0F, 0, 1, 0, 0, 0}),                 // velocity
      can_frame(0x60B, {0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0}),  // writes the controlword
      can_frame(0x60B, {0x21, 0x40, 0x60, 0, 2, 0, 0, 0}),     // begins to
      can_frame(0x60B, {0x00, 0x0F, 0, 0, 0, 0, 0, 0}),        // a segment of it
      can_frame(0x600, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}),     // of no node
      can_frame(0x60B, {0x40, 0x41, 0x60, 0}),                 // too short
      can_frame(0x7E5, {0x04, 1, 0, 0, 0, 0, 0, 0}),           // LSS
  };
  for (const CanFrame& frame : commands) EXPECT_FALSE(bus.send(frame)) << frame.id;
  CanFrame remote = can_frame(0x60B, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0});
  remote.is_remote = true;
  EXPECT_FALSE(bus.send(remote));
  EXPECT_TRUE(recorder.sent.empty());
  EXPECT_EQ(bus.refused(), commands.size() + 1);

  EXPECT_TRUE(bus.send(can_frame(0x60B, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0})));
  EXPECT_TRUE(bus.send(can_frame(0x67F, {0x70, 0, 0, 0, 0, 0, 0, 0})));
  EXPECT_TRUE(bus.send(can_frame(0x601, {0x80, 0x41, 0x60, 0, 0, 0, 4, 5})));
  EXPECT_EQ(recorder.sent.size(), 3U);
}

// ---- asking drives in memory
// --------------------------------------------------------------------------------

// Seven drives, whoever asks, and a listener that keeps every frame; time moves as the asker sleeps.
class BusBench : public ::testing::Test {
 protected:
  static constexpr std::size_t kDrives = 7;
  static constexpr std::size_t kOurs = 7;
  static constexpr std::size_t kListener = 8;

  BusBench() {
    for (std::size_t i = 0; i < kDrives; ++i) {
      canopen::SimulatedDriveOptions options;
      options.node_id = config.arm.axis[i].node_id;
      options.start_counts = config.arm.axis[i].zero_counts;
      drives[i].init(options, now_ns);
    }
    run_until(10'000'000);
    frames.clear();
  }

  void run_until(std::int64_t ns) {
    while (now_ns < ns) {
      now_ns = std::min(now_ns + 100'000, ns);
      bus->advance(now_ns);
      for (std::size_t i = 0; i < kDrives; ++i) {
        canopen::MemoryBus::Port& port = bus->port(i);
        for (CanFrame frame; port.receive(frame);) drives[i].receive(frame, now_ns);
        drives[i].process(now_ns, canopen::FrameSink(port));
      }
      for (CanFrame frame; bus->port(kListener).receive(frame);) frames.push_back(frame);
      if (meanwhile) meanwhile();
    }
  }

  struct Clock {
    BusBench* bench;
    std::int64_t now_ns() { return bench->now_ns; }
  };
  struct Sleeper {
    BusBench* bench;
    void sleep_until(std::int64_t ns) { bench->run_until(ns); }
  };

  [[nodiscard]] CanObservation ask(double seconds = 0.2, int number = 0) {
    CanFrame old;
    while (bus->port(kOurs).receive(old)) {
    }
    Clock clock{this};
    Sleeper sleeper{this};
    ReadOnly read_only(bus->port(kOurs), clock, sleeper);
    CanObservation seen = ask_drives(read_only, config.arm, seconds, number);
    EXPECT_EQ(read_only.refused(), 0U);
    seen.link = sound_link();
    return seen;
  }
  [[nodiscard]] std::vector<Finding> judged(const CanObservation& seen) const {
    const std::vector<Finding> findings = judge(seen, config);
    expect_complete(findings);
    return findings;
  }
  void say(const CanFrame& frame) { EXPECT_TRUE(bus->port(kListener).send(frame)); }

  CanConfig config = config_of_bus();
  std::unique_ptr<canopen::MemoryBus> bus = std::make_unique<canopen::MemoryBus>();
  std::array<canopen::SimulatedDrive, kDrives> drives;
  std::int64_t now_ns = 0;
  std::vector<CanFrame> frames;
  std::function<void()> meanwhile;
};

// Four drives are on one bus and three on another: each is asked for its own, and a drive of the other is a
// stranger there.
TEST_F(BusBench, AsksOfEachBusTheDrivesThatAreOnIt) {
  for (std::size_t i = 4; i < kDrives; ++i) {
    config.arm.axis[i].bus = 1;
    drives[i].set_power(false);
  }
  config.interface_2 = {"can1"};
  auto findings = judged(ask());
  expect_all_pass(findings);
  EXPECT_EQ(findings.size(), 9 + 6 * 4);
  expect_finding(findings, "bus 1 interface", Outcome::kPass, "can0 is up");
  expect_finding(findings, "axis 4 answers", Outcome::kPass, "node 14");

  for (std::size_t i = 0; i < kDrives; ++i) drives[i].set_power(i >= 4);
  run_until(now_ns + 10'000'000);
  findings = judged(ask(0.2, 1));
  expect_all_pass(findings);
  EXPECT_EQ(findings.size(), 9 + 6 * 3);
  expect_finding(findings, "bus 2 interface", Outcome::kPass, "can1 is up");
  expect_finding(findings, "axis 5 answers", Outcome::kPass, "node 15");

  drives[0].set_power(true);
  run_until(now_ns + 10'000'000);
  expect_finding(judged(ask(0.2, 1)), "bus 2 no other nodes", Outcome::kWarn, "nodes 11");

  CanObservation seen = ask(0.2, 1);
  seen.link.is_up = false;
  expect_finding(judged(seen), "bus 2 interface", Outcome::kFail, "can1 is down",
                 "link set can1 txqueuelen 32 up");
}

TEST_F(BusBench, PassesAnArmThatIsWell) {
  const CanObservation seen = ask();
  const auto findings = judged(seen);
  expect_all_pass(findings);
  EXPECT_EQ(findings.size(), 9 + 6 * kDrives);
  expect_finding(findings, "axis 1 answers", Outcome::kPass, "node 11");
  expect_finding(findings, "axis 7 identity", Outcome::kPass,
                 "CiA 402, vendor 0x1d5, simulated CiA 402 drive");
  expect_finding(findings, "axis 3 drive", Outcome::kPass, "switch on disabled");
  expect_finding(findings, "axis 2 position", Outcome::kPass, "0.00 deg, 1000 counts");
  expect_finding(findings, "axis 2 round trip", Outcome::kPass, "of 50, 0 unanswered");
  EXPECT_EQ(seen.drives[3].round_trips_ns.size(), 50U);
  for (const std::int64_t ns : seen.drives[3].round_trips_ns) EXPECT_EQ(ns, 100'000);
}

TEST_F(BusBench, NeverSendsWhatMovesOrChangesADrive) {
  (void)ask();
  std::size_t ours = 0;
  for (const CanFrame& frame : frames) {
    EXPECT_NE(frame.id, canopen::kNmtCobId);
    EXPECT_NE(frame.id, canopen::kSyncCobId);
    const bool is_answer = frame.id > 0x580 && frame.id <= 0x5FF;
    if (is_answer) continue;
    EXPECT_TRUE(only_reads(frame)) << frame.id;
    ++ours;
  }
  EXPECT_GT(ours, 127 + kDrives * kRoundTrips);
  for (const canopen::SimulatedDrive& drive : drives) {
    EXPECT_EQ(drive.nmt(), canopen::NmtState::kPreOperational);
    EXPECT_EQ(drive.state(), canopen::DriveState::kSwitchOnDisabled);
    EXPECT_EQ(drive.objects().number(canopen::kControlword, 0), 0U);
    EXPECT_EQ(drive.objects().number(canopen::kHeartbeatProducer, 0), 0U);
    EXPECT_EQ(drive.objects().number(canopen::kModeOfOperation, 0), 0U);
  }
}

TEST_F(BusBench, ADriveWithoutPowerIsMissing) {
  drives[2].set_power(false);
  const auto findings = judged(ask());
  expect_finding(findings, "axis 3 answers", Outcome::kFail, "node 13, no heartbeat", "power on");
  expect_finding(findings, "axis 3 drive", Outcome::kSkipped);
  expect_finding(findings, "axis 2 answers", Outcome::kPass);
  expect_finding(findings, "axis 4 position", Outcome::kPass);
  expect_finding(findings, "no other nodes", Outcome::kPass);
}

TEST_F(BusBench, ADriveWithTheWrongIdIsFoundByAskingAll) {
  config.arm.axis[5].node_id = 77;
  const auto findings = judged(ask());
  expect_finding(findings, "axis 6 answers", Outcome::kFail, "node 77", "nodes 16");
  expect_finding(findings, "no other nodes", Outcome::kWarn, "nodes 16", "[[can.axis]] node");
}

TEST_F(BusBench, AnotherVendorFails) {
  config.arm.axis[0].vendor_id = 0x1D5;
  config.arm.axis[1].vendor_id = 0x2E;
  const auto findings = judged(ask());
  expect_finding(findings, "axis 1 identity", Outcome::kPass);
  expect_finding(findings, "axis 2 identity", Outcome::kFail, "vendor 0x1d5", "0x2e");
}

TEST_F(BusBench, SlowAnswersAreAWarning) {
  ASSERT_TRUE(bus->delay({0x58B, 0x7FF}, 30'000'000));
  const CanObservation seen = ask();
  const auto findings = judged(seen);
  expect_finding(findings, "axis 1 answers", Outcome::kPass);
  expect_finding(findings, "axis 1 round trip", Outcome::kWarn, "median 30", "slow");
  expect_finding(findings, "axis 2 round trip", Outcome::kPass);
}

TEST_F(BusBench, AnswersThatNeverComeEndTheAsking) {
  ASSERT_TRUE(bus->drop({0x58C, 0x7FF}));
  const std::int64_t begun_ns = now_ns;
  const auto findings = judged(ask());
  expect_finding(findings, "axis 2 answers", Outcome::kFail, "answers no SDO");
  EXPECT_LT(now_ns - begun_ns, 3'000'000'000);  // of virtual time
}

TEST_F(BusBench, ObjectsThatAreRefusedAreNamed) {
  drives[0].refuse(canopen::kDeviceName, 0, canopen::kAbortNoObject);  // it may be missing
  drives[1].refuse(canopen::kStatusword, 0, canopen::kAbortNoObject);
  drives[2].refuse(canopen::kDeviceType, 0, canopen::kAbortGeneral);
  drives[3].refuse(canopen::kHeartbeatProducer, 0, canopen::kAbortNoObject);
  drives[4].refuse(canopen::kPositionActual, 0, canopen::kAbortNoObject);
  const auto findings = judged(ask());
  expect_finding(findings, "axis 1 identity", Outcome::kPass, "CiA 402, vendor 0x1d5");
  expect_finding(findings, "axis 2 drive", Outcome::kFail, "0x6041: ");
  expect_finding(findings, "axis 3 answers", Outcome::kPass);
  expect_finding(findings, "axis 3 identity", Outcome::kFail, "0x1000: ");
  expect_finding(findings, "axis 4 heartbeat", Outcome::kFail, "0x1017: ");
  expect_finding(findings, "axis 5 position", Outcome::kFail, "0x6064: ");
}

TEST_F(BusBench, HeartbeatsAreMeasured) {
  say(can_frame(0x60B, {0x2B, 0x17, 0x10, 0, 20, 0, 0, 0}));  // as a set-up tool does it
  run_until(now_ns + 5'000'000);
  CanObservation seen = ask();
  EXPECT_EQ(seen.foreign_commands, 0);  // it was before
  auto findings = judged(seen);
  expect_finding(findings, "axis 1 heartbeat", Outcome::kPass, "every 20.0 ms, 0x1017 is 20");
  expect_finding(findings, "axis 1 answers", Outcome::kPass, "pre-operational");
  drives[0].set_heartbeat(false);
  findings = judged(ask());
  expect_finding(findings, "axis 1 heartbeat", Outcome::kFail, "0 heard");
}

TEST_F(BusBench, AFaultIsShownWithItsEmergency) {
  int turns = 0;
  meanwhile = [&] {
    if (++turns == 100) drives[4].fail(0x3210);
  };
  const auto findings = judged(ask());
  expect_finding(findings, "axis 5 drive", Outcome::kFail, "emergency 0x3210", "manual");
  expect_finding(findings, "axis 6 drive", Outcome::kPass);
}

TEST_F(BusBench, ADriveThatIsOnIsAWarning) {
  drives[6].set_state(canopen::DriveState::kOperationEnabled);
  expect_finding(judged(ask()), "axis 7 drive", Outcome::kWarn, "operation enabled", "emergency stop");
}

TEST_F(BusBench, AnotherMasterIsSeen) {
  int turns = 0;
  meanwhile = [&] {
    if (++turns % 50 == 0) say(canopen::sync_frame());
    if (turns == 100)
      say(canopen::heartbeat_frame(config.arm.master_node_id, canopen::NmtState::kOperational));
    if (turns == 150) say(can_frame(0x20B, {0, 0, 0, 0, 0, 0}));
  };
  const auto findings = judged(ask());
  expect_finding(findings, "no other master", Outcome::kFail, "1 heartbeats of node 127", "stop it");
}

TEST_F(BusBench, ProcessDataAndHeartbeatsOfStrangersAreSeen) {
  meanwhile = [&, turns = 0]() mutable {
    if (++turns == 10) say(canopen::heartbeat_frame(40, canopen::NmtState::kOperational));
    if (turns == 20) say(can_frame(0x180 + 41, {1, 2}));
    if (turns == 30) say(can_frame(0x080 + 42, {0x10, 0x23, 1, 0, 0, 0, 0, 0}));
    if (turns == 40) say(can_frame(0x180 + 11, {1, 2}));  // a drive's own
  };
  expect_finding(judged(ask()), "no other nodes", Outcome::kWarn, "nodes 40, 41, 42");
}

// ---- verdicts on what was made up
// ---------------------------------------------------------------------------

ObjectReading number(std::uint32_t value) {
  ObjectReading reading;
  reading.state = ObjectReading::State::kRead;
  for (int i = 0; i < 4; ++i) reading.bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return reading;
}

DriveObservation sound_drive() {
  DriveObservation drive;
  drive.device_type = number(0x20192);
  drive.vendor = number(0x1D5);
  drive.heartbeat_ms = number(0);
  drive.error_register = number(0);
  drive.statusword = number(0x0250);  // switch on disabled, voltage, remote
  drive.position = number(0);
  drive.round_trips_ns.assign(kRoundTrips, 800'000);
  return drive;
}

CanObservation sound_bus(const CanConfig& config) {
  CanObservation seen;
  seen.link = sound_link();
  seen.drives.assign(static_cast<std::size_t>(config.arm.axes), sound_drive());
  return seen;
}

struct Case {
  const char* name;
  std::function<void(CanObservation&)> change;
  const char* check;
  Outcome outcome;
  const char* measured;
  const char* remedy;
};

const Case kCases[] = {
    {"BitRate", [](auto& s) { s.link.bitrate_bit_per_s = 500'000; }, "bit rate", Outcome::kFail,
     "500000 bit/s of 1000000", "bitrate 1000000"},
    {"NoBitRate", [](auto& s) { s.link.bitrate_bit_per_s.reset(); }, "bit rate", Outcome::kSkipped, "",
     "slcan"},
    {"Virtual",
     [](auto& s) {
       s.link.is_virtual = true;
       s.link.bitrate_bit_per_s.reset();
     },
     "bit rate", Outcome::kSkipped, "", "virtual"},
    {"ErrorPassive", [](auto& s) { s.link.state = CAN_STATE_ERROR_PASSIVE; }, "bus state", Outcome::kWarn,
     "passive", "120 ohms"},
    {"BusOff", [](auto& s) { s.link.state = CAN_STATE_BUS_OFF; }, "bus state", Outcome::kFail, "bus off",
     "wiring"},
    {"NoState", [](auto& s) { s.link.state.reset(); }, "bus state", Outcome::kSkipped, "", "driver"},
    {"Counters", [](auto& s) { s.link.errors->rx = 3; }, "error counters", Outcome::kWarn, "3 receiving",
     "wiring"},
    {"NoCounters", [](auto& s) { s.link.errors.reset(); }, "error counters", Outcome::kSkipped, "", "driver"},
    {"ShortQueue", [](auto& s) { s.link.tx_queue = 10; }, "transmit queue", Outcome::kWarn, "10",
     "txqueuelen 32"},
    {"NoRestart", [](auto& s) { s.link.restart_ms = 0; }, "restart after bus-off", Outcome::kWarn, "never",
     "restart-ms 100"},
    {"RestartUnknown", [](auto& s) { s.link.restart_ms.reset(); }, "restart after bus-off", Outcome::kSkipped,
     "", ""},
    {"ErrorFrames", [](auto& s) { s.health.error_frames = 2; }, "traffic", Outcome::kWarn, "2 error frames",
     "wiring"},
    {"BusOffs", [](auto& s) { s.health.bus_offs = 1; }, "traffic", Outcome::kFail, "1 bus-offs", "wiring"},
    {"NotTaken", [](auto& s) { s.health.tx_refused = 5; }, "traffic", Outcome::kFail, "5 not taken",
     "powered"},
    {"Overflow", [](auto& s) { s.health.rx_overflows = 1; }, "traffic", Outcome::kWarn, "1 frames lost", ""},
    {"NoDrive", [](auto& s) { s.drives[0].device_type = number(401); }, "axis 1 identity", Outcome::kFail,
     "CiA 401", "node id"},
    {"Stopped",
     [](auto& s) {
       s.drives[0] = {};
       s.drives[0].device_type.state = ObjectReading::State::kNoAnswer;
       s.heard[11].heartbeats = 5;
       s.heard[11].state = canopen::NmtState::kStopped;
     },
     "axis 1 answers", Outcome::kFail, "stopped", "off and on"},
    {"Unanswered", [](auto& s) { s.drives[0].unanswered = 1; }, "axis 1 round trip", Outcome::kFail,
     "1 unanswered", "wiring"},
    {"AllUnanswered",
     [](auto& s) {
       s.drives[0].round_trips_ns.clear();
       s.drives[0].unanswered = 3;
     },
     "axis 1 round trip", Outcome::kFail, "3 unanswered", "wiring"},
    {"OneSlowAnswer", [](auto& s) { s.drives[0].round_trips_ns[7] = 300'000'000; }, "axis 1 round trip",
     Outcome::kWarn, "largest 300.00 ms", "sdo_timeout_ms is 500"},
    {"UnevenHeartbeat",
     [](auto& s) {
       s.drives[0].heartbeat_ms = number(100);
       s.heard[11] = {11, 0, 0, 1'500'000'000, canopen::NmtState::kPreOperational, 0, 0};
     },
     "axis 1 heartbeat", Outcome::kWarn, "every 150.0 ms, 0x1017 is 100", "overloaded"},
    {"RareHeartbeat",
     [](auto& s) {
       s.drives[0].heartbeat_ms = number(5000);
       s.heard[11].heartbeats = 1;
     },
     "axis 1 heartbeat", Outcome::kWarn, "1 heard", "--seconds"},
    {"Fault",
     [](auto& s) {
       s.drives[0].statusword = number(0x0238);
       s.drives[0].error_register = number(0x20);
     },
     "axis 1 drive", Outcome::kFail, "error register 0x20", "manual"},
    {"MeaninglessState", [](auto& s) { s.drives[0].statusword = number(0x0026); }, "axis 1 drive",
     Outcome::kFail, "0x0026", ""},
    {"NoVoltage", [](auto& s) { s.drives[0].statusword = number(0x0240); }, "axis 1 drive", Outcome::kWarn,
     "0x0240", "emergency stop"},
    {"Warning", [](auto& s) { s.drives[0].statusword = number(0x02D0); }, "axis 1 drive", Outcome::kWarn,
     "0x02d0", "warns"},
    {"OutOfRange", [](auto& s) { s.drives[0].position = number(400'000); }, "axis 1 position", Outcome::kWarn,
     "400000 counts", "zero_counts"},
};

void PrintTo(const Case& its, std::ostream* out) {
  *out << its.name;
}

class CanVerdicts : public ::testing::TestWithParam<Case> {};

TEST_P(CanVerdicts, AreAsTheyShouldBe) {
  const CanConfig config = config_of_bus();
  CanObservation seen = sound_bus(config);
  expect_finding(judge(seen, config), "axis 1 drive", Outcome::kPass);
  GetParam().change(seen);
  const auto findings = judge(seen, config);
  expect_complete(findings);
  expect_finding(findings, GetParam().check, GetParam().outcome, GetParam().measured, GetParam().remedy);
}

INSTANTIATE_TEST_SUITE_P(Cases, CanVerdicts, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(CanVerdictsOfTheInterface, SkipTheDrivesWhereItCannotBeUsed) {
  const CanConfig config = config_of_bus();
  CanObservation seen;
  seen.link.was_told = true;
  const auto expect_unusable = [&](const char* measured, const char* remedy) {
    const auto findings = judge(seen, config);
    expect_complete(findings);
    expect_finding(findings, "interface", Outcome::kFail, measured, remedy);
    expect_finding(findings, "axis 7 position", Outcome::kSkipped);
  };
  expect_unusable("can0 is not there", "ip -details link");
  seen.link.exists = true;
  expect_unusable("no CAN interface", "can.interface");
  seen.link.is_can = true;
  expect_unusable("can0 is down", "sudo ip link set can0 type can bitrate 1000000");
  seen.link = {};
  seen.open_problem = "no CAN socket";
  expect_unusable("no CAN socket", "ip -details link show");
}

// ---- what the kernel says
// -----------------------------------------------------------------------------------

class Message {
 public:
  explicit Message(std::uint16_t type = RTM_NEWLINK) {
    nlmsghdr header{};
    header.nlmsg_type = type;
    put(&header, sizeof header);
  }
  Message& link(unsigned short hardware, unsigned flags) {
    ifinfomsg info{};
    info.ifi_type = hardware;
    info.ifi_flags = flags;
    put(&info, sizeof info);
    return *this;
  }
  template <typename T>
  Message& attribute(unsigned short type, const T& value) {
    open(type);
    put(&value, sizeof value);
    close();
    return *this;
  }
  Message& text(unsigned short type, const char* value) {
    open(type);
    put(value, std::strlen(value) + 1);
    close();
    return *this;
  }
  void open(unsigned short type) {
    opened_.push_back(bytes_.size());
    const rtattr header{0, type};
    put(&header, sizeof header);
  }
  void close() {
    const auto length = static_cast<unsigned short>(bytes_.size() - opened_.back());
    std::memcpy(&bytes_[opened_.back()], &length, sizeof length);
    opened_.pop_back();
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
  }
  [[nodiscard]] std::vector<std::byte> take() {
    const auto length = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &length, sizeof length);
    return bytes_;
  }

 private:
  void put(const void* from, std::size_t size) {
    const auto* bytes = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }
  std::vector<std::byte> bytes_;
  std::vector<std::size_t> opened_;
};

std::vector<std::byte> answer_of_can0() {
  Message message;
  message.link(280, IFF_UP).text(IFLA_IFNAME, "can0").attribute(IFLA_TXQLEN, std::uint32_t{10});
  message.open(IFLA_LINKINFO);
  message.text(IFLA_INFO_KIND, "can");
  message.open(IFLA_INFO_DATA);
  can_bittiming timing{};
  timing.bitrate = 500'000;
  message.attribute(IFLA_CAN_BITTIMING, timing)
      .attribute(IFLA_CAN_STATE, std::uint32_t{CAN_STATE_ERROR_WARNING})
      .attribute(IFLA_CAN_RESTART_MS, std::uint32_t{100})
      .attribute(IFLA_CAN_BERR_COUNTER, can_berr_counter{96, 7});
  message.close();
  message.close();
  return message.take();
}

TEST(CanLinkTest, ReadsWhatTheKernelSays) {
  const CanLink link = parse_link(answer_of_can0());
  EXPECT_TRUE(link.was_told && link.exists && link.is_can && link.is_up);
  EXPECT_FALSE(link.is_virtual);
  EXPECT_EQ(link.tx_queue, 10U);
  EXPECT_EQ(link.bitrate_bit_per_s, 500'000U);
  EXPECT_EQ(link.state, std::uint32_t{CAN_STATE_ERROR_WARNING});
  EXPECT_EQ(link.restart_ms, 100U);
  ASSERT_TRUE(link.errors);
  EXPECT_EQ(link.errors->tx, 96);
  EXPECT_EQ(link.errors->rx, 7);
}

TEST(CanLinkTest, KnowsVirtualAndOtherInterfaces) {
  Message vcan;
  vcan.link(280, 0);
  vcan.open(IFLA_LINKINFO);
  vcan.text(IFLA_INFO_KIND, "vcan");
  vcan.close();
  const CanLink virtual_link = parse_link(vcan.take());
  EXPECT_TRUE(virtual_link.is_can && virtual_link.is_virtual);
  EXPECT_FALSE(virtual_link.is_up);
  EXPECT_FALSE(virtual_link.bitrate_bit_per_s || virtual_link.state || virtual_link.errors);
  EXPECT_FALSE(parse_link(Message().link(1, IFF_UP).take()).is_can);
  const CanLink none = parse_link(Message(NLMSG_ERROR).attribute(0, nlmsgerr{}).take());
  EXPECT_TRUE(none.was_told);
  EXPECT_FALSE(none.exists);
}

TEST(CanLinkTest, WhatIsCutShortOrCorruptedDoesNoHarm) {
  const std::vector<std::byte> whole = answer_of_can0();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(parse_link(std::span(whole).first(size)).was_told);
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int value : {0, 1, 3, 0x7F, 0xFF}) {
      // A copy of exactly its size, so that a sanitizer sees every byte beyond.
      std::vector<std::byte> broken(whole.begin(), whole.end());
      broken[at] = static_cast<std::byte>(value);
      (void)parse_link(broken);
    }
  }
}

TEST(CanLinkTest, AsksThisKernel) {
  const CanLink none = read_link("no-such-link");
  EXPECT_TRUE(none.was_told);
  EXPECT_FALSE(none.exists);
  const CanLink loopback = read_link("lo");
  EXPECT_TRUE(!loopback.was_told || (loopback.exists && !loopback.is_can));
}

}  // namespace
}  // namespace vergence::tools
