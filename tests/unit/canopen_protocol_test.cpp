// The small parts of CANopen by themselves: error frames, NMT, heartbeats, emergencies, PDO tables, the
// config, the bus in memory, and when a controller that went bus-off may come back.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "hal/canopen/arm_config.hpp"
#include "hal/canopen/arm_fault.hpp"
#include "hal/canopen/boot_script.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/heartbeat.hpp"
#include "hal/canopen/memory_bus.hpp"
#include "hal/canopen/restart_policy.hpp"
#include "tests/support/can_recorder.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::can_frame;
using testing::CanRecorder;
using testing::config_of_drives;

CanFrame error_frame(std::uint32_t classes, int controller = 0) {
  CanFrame frame = can_frame(classes, {0, controller, 0, 0, 0, 0, 0, 0});
  frame.is_error = true;
  return frame;
}

TEST(CanErrorsTest, ErrorFramesBecomeTheStateOfTheBus) {
  CanHealth health;
  count_errors(health, decode_errors(error_frame(0x004, 0x08)));
  EXPECT_EQ(health.state, BusState::kWarning);
  count_errors(health, decode_errors(error_frame(0x004, 0x10)));
  EXPECT_EQ(health.state, BusState::kPassive);
  count_errors(health, decode_errors(error_frame(0x004, 0x40)));
  EXPECT_EQ(health.state, BusState::kActive);
  count_errors(health, decode_errors(error_frame(0x004, 0x01)));
  EXPECT_EQ(health.rx_overflows, 1U);
  count_errors(health, decode_errors(error_frame(0x040)));
  count_errors(health, decode_errors(error_frame(0x040)));
  EXPECT_EQ(health.state, BusState::kOff);
  EXPECT_EQ(health.bus_offs, 1U);
  count_errors(health, decode_errors(error_frame(0x004, 0x40)));
  EXPECT_EQ(health.state, BusState::kOff);  // only a restart ends it
  count_errors(health, decode_errors(error_frame(0x100)));
  EXPECT_EQ(health.state, BusState::kActive);
  EXPECT_EQ(health.error_frames, 8U);
}

TEST(CanErrorsTest, EachHasWords) {
  const CanFrame frames[] = {error_frame(0x001),       error_frame(0x002),       error_frame(0x004, 0x01),
                             error_frame(0x004, 0x02), error_frame(0x004, 0x04), error_frame(0x004, 0x20),
                             error_frame(0x004, 0x40), error_frame(0x008),       error_frame(0x010),
                             error_frame(0x020),       error_frame(0x040),       error_frame(0x100)};
  std::set<std::string> words = {describe(CanErrors{})};
  for (const CanFrame& frame : frames) words.insert(describe(decode_errors(frame)));
  EXPECT_EQ(words.size(), std::size(frames) + 1);
  EXPECT_FALSE(decode_errors(can_frame(0x040, {})).bus_off);  // an identifier, no error
}

TEST(NmtTest, CommandsAndStatesAreTheStandardsBytes) {
  const struct {
    NmtCommand command;
    int byte;
  } commands[] = {{NmtCommand::kStart, 0x01},
                  {NmtCommand::kStop, 0x02},
                  {NmtCommand::kEnterPreOperational, 0x80},
                  {NmtCommand::kResetNode, 0x81},
                  {NmtCommand::kResetCommunication, 0x82}};
  for (const auto& row : commands) {
    const CanFrame frame = nmt_command(row.command, 5);
    EXPECT_EQ(frame.id, 0U);
    EXPECT_EQ(frame.size, 2);
    EXPECT_EQ(frame.data[0], row.byte);
    EXPECT_EQ(frame.data[1], 5);
  }
  EXPECT_EQ(decode_nmt_state(0x00), NmtState::kBootUp);
  EXPECT_EQ(decode_nmt_state(0x04), NmtState::kStopped);
  EXPECT_EQ(decode_nmt_state(0x85), NmtState::kOperational);  // with the toggle bit of node guarding
  EXPECT_EQ(decode_nmt_state(0x7F), NmtState::kPreOperational);
  EXPECT_EQ(decode_nmt_state(0x06), NmtState::kUnknown);
  EXPECT_EQ(sync_frame().id, 0x080U);
  EXPECT_EQ(sync_frame().size, 0);
}

TEST(HeartbeatTest, ANodeThatNeverBootsIsNoticedAsWellAsOneThatStops) {
  HeartbeatConsumer node;
  node.init(5, 50, 1000);
  node.await_boot(0);
  node.receive(can_frame(0x705, {0x05}), 10);  // from before its reset
  node.process(1000);
  EXPECT_EQ(node.life(), NodeLife::kAwaited);
  node.process(1001);
  EXPECT_EQ(node.life(), NodeLife::kNeverBooted);

  node.await_boot(2000);
  node.receive(can_frame(0x706, {0x00}), 2100);
  EXPECT_EQ(node.life(), NodeLife::kAwaited);
  node.receive(can_frame(0x705, {0x00}), 2100);
  EXPECT_EQ(node.life(), NodeLife::kBooted);
  node.process(9000);
  EXPECT_EQ(node.life(), NodeLife::kBooted);  // has not been told to beat
  node.receive(can_frame(0x705, {0x7F}), 9000);
  node.process(9050);
  EXPECT_EQ(node.life(), NodeLife::kAlive);
  EXPECT_EQ(node.state(), NmtState::kPreOperational);
  node.process(9051);
  EXPECT_EQ(node.life(), NodeLife::kLost);
  node.receive(can_frame(0x705, {0x05}), 9060);
  EXPECT_EQ(node.life(), NodeLife::kLost);  // what has been lost once is not trusted again by itself
  EXPECT_EQ(node.boots(), 1U);
}

TEST(HeartbeatTest, TheMastersIsSentEachPeriodAndAgainWhenRefused) {
  CanRecorder bus;
  HeartbeatProducer master;
  master.init(127, 20);
  master.process(1, NmtState::kOperational, FrameSink(bus));
  const CanFrame frame = bus.take();
  EXPECT_EQ(frame.id, 0x77FU);
  EXPECT_EQ(frame.data[0], 0x05);
  master.process(20, NmtState::kOperational, FrameSink(bus));
  EXPECT_TRUE(bus.sent.empty());
  bus.is_full = true;
  master.process(21, NmtState::kOperational, FrameSink(bus));
  bus.is_full = false;
  master.process(22, NmtState::kOperational, FrameSink(bus));
  EXPECT_EQ(bus.sent.size(), 1U);
}

TEST(EmergencyTest, IsDecodedWithWordsOfItsCodeOrClass) {
  Emergency emergency;
  ASSERT_TRUE(decode_emergency(can_frame(0x085, {0x11, 0x86, 0x21, 1, 2, 3, 4, 5}), 5, emergency));
  EXPECT_EQ(emergency.code, 0x8611);
  EXPECT_EQ(emergency.error_register, 0x21);
  EXPECT_EQ(emergency.manufacturer[4], 5);
  EXPECT_FALSE(decode_emergency(can_frame(0x086, {0x11, 0x86, 0, 0, 0, 0, 0, 0}), 5, emergency));
  EXPECT_FALSE(decode_emergency(can_frame(0x085, {0x11, 0x86}), 5, emergency));
  const struct {
    int code;
    const char* words;
  } rows[] = {{0x0000, "error reset, or no error"},
              {0x8611, "following error"},
              {0x8130, "heartbeat of the master missing"},
              {0x2310, "current at the device's output: short circuit, earth leakage or overload"},
              {0x3299, "voltage inside the device"},
              {0x3999, "voltage"},
              {0x4310, "drive too hot"},
              {0x7305, "incremental encoder 1 at fault"},
              {0x7399, "sensor"},
              {0x8199, "communication"},
              {0x9001, "external error"},
              {0xFF01, "device specific"},
              {0x1234, "generic error"},
              {0xA000, "a code that is not in CiA 301"}};
  for (const auto& row : rows) {
    EXPECT_STREQ(describe_emergency(static_cast<std::uint16_t>(row.code)), row.words) << std::hex << row.code;
  }
}

TEST(PdoTest, IsSetUpInTheOrderOfTheStandard) {
  PdoConfig pdo;
  pdo.direction = PdoDirection::kFromDrive;
  pdo.number = 2;
  pdo.cob_id = 0x285;
  pdo.entries.add({0x6041, 0, 16});
  pdo.entries.add({0x6064, 0, 32});
  const PdoWrites writes = pdo_writes(pdo);
  const SdoWrite expected[] = {{0x1801, 1, 4, 0xC0000285}, {0x1801, 2, 1, 1},          {0x1A01, 0, 1, 0},
                               {0x1A01, 1, 4, 0x60410010}, {0x1A01, 2, 4, 0x60640020}, {0x1A01, 0, 1, 2},
                               {0x1801, 1, 4, 0x40000285}};
  ASSERT_EQ(writes.size(), std::size(expected));
  for (std::size_t i = 0; i < writes.size(); ++i) {
    EXPECT_EQ(writes[i].index, expected[i].index) << i;
    EXPECT_EQ(writes[i].sub, expected[i].sub) << i;
    EXPECT_EQ(writes[i].size, expected[i].size) << i;
    EXPECT_EQ(writes[i].value, expected[i].value) << i;
  }
  pdo.inhibit_ns = 2'000'000;
  pdo.event_timer_ns = 100'000'000;
  const PdoWrites timed = pdo_writes(pdo);
  ASSERT_EQ(timed.size(), writes.size() + 2);
  EXPECT_EQ(timed[2].sub, 3);  // while it is off
  EXPECT_EQ(timed[2].size, 2);
  EXPECT_EQ(timed[2].value, 20U);
  EXPECT_TRUE(timed[2].may_be_missing);
  EXPECT_EQ(timed[3].sub, 5);
  EXPECT_EQ(timed[3].value, 100U);
  const SdoWrite off = pdo_off(PdoDirection::kToDrive, 3, 5);
  EXPECT_EQ(off.index, 0x1402);
  EXPECT_EQ(off.value, 0x80000405U);
}

TEST(PdoTest, WhatDoesNotFitIsRefused) {
  PdoConfig pdo;
  pdo.cob_id = 0x205;
  EXPECT_TRUE(pdo_writes(pdo).empty());  // nothing is mapped
  pdo.entries.add({0x60FF, 0, 32});
  pdo.entries.add({0x607A, 0, 32});
  EXPECT_FALSE(pdo_writes(pdo).empty());
  pdo.number = 5;
  EXPECT_TRUE(pdo_writes(pdo).empty());
  pdo.number = 1;
  pdo.cob_id = 0x605;
  EXPECT_TRUE(pdo_writes(pdo).empty());
  pdo.cob_id = 0x205;
  pdo.event_timer_ns = 70'000'000'000;
  EXPECT_TRUE(pdo_writes(pdo).empty());
  pdo.event_timer_ns = 0;
  pdo.inhibit_ns = 50'000;
  EXPECT_TRUE(pdo_writes(pdo).empty());
  pdo.inhibit_ns = 0;
  EXPECT_FALSE(pdo_writes(pdo).empty());
  pdo.entries.add({0x6040, 0, 16});
  EXPECT_TRUE(pdo_writes(pdo).empty());
}

TEST(ArmConfigTest, EveryMistakeIsFound) {
  EXPECT_EQ(check(config_of_drives()).finding, ConfigFinding::kNone);
  using Change = void (*)(CanopenArmConfig&);
  const struct {
    Change change;
    ConfigFinding finding;
    int axis;
  } rows[] = {
      {[](CanopenArmConfig& c) { c.axes = 8; }, ConfigFinding::kAxes, -1},
      {[](CanopenArmConfig& c) { c.axes = 0; }, ConfigFinding::kAxes, -1},
      {[](CanopenArmConfig& c) { c.axis[2].node_id = 0; }, ConfigFinding::kNodeId, 2},
      {[](CanopenArmConfig& c) { c.axis[2].node_id = 128; }, ConfigFinding::kNodeId, 2},
      {[](CanopenArmConfig& c) { c.axis[2].node_id = 11; }, ConfigFinding::kNodeIdTwice, 2},
      {[](CanopenArmConfig& c) { c.master_node_id = 17; }, ConfigFinding::kNodeIdTwice, 6},
      {[](CanopenArmConfig& c) { c.axis[1].counts_per_rad = 0; }, ConfigFinding::kScale, 1},
      {[](CanopenArmConfig& c) { c.axis[1].counts_per_rad *= -1; }, ConfigFinding::kScale, 1},
      {[](CanopenArmConfig& c) { c.axis[1].velocity_units_per_rad_per_s = NAN; }, ConfigFinding::kScale, 1},
      {[](CanopenArmConfig& c) { c.axis[3].min_rad = 4; }, ConfigFinding::kRange, 3},
      {[](CanopenArmConfig& c) { c.axis[3].max_rad = 1e6; }, ConfigFinding::kRange, 3},
      {[](CanopenArmConfig& c) { c.axis[4].max_velocity_rad_per_s = 0; }, ConfigFinding::kLimit, 4},
      {[](CanopenArmConfig& c) { c.axis[4].quick_stop_rad_per_s2 = 1e9; }, ConfigFinding::kLimit, 4},
      {[](CanopenArmConfig& c) { c.axis[4].following_error_rad = -1; }, ConfigFinding::kLimit, 4},
      {[](CanopenArmConfig& c) { c.axis[5].tpdo1_cob_id = 0x580; }, ConfigFinding::kCobId, 5},
      {[](CanopenArmConfig& c) { c.axis[5].rpdo2_cob_id = 0x180; }, ConfigFinding::kCobId, 5},
      {[](CanopenArmConfig& c) { c.axis[5].tpdo1_cob_id = 0x18B; }, ConfigFinding::kCobIdTwice, 5},
      {[](CanopenArmConfig& c) { c.axis[5].rpdo1_cob_id = 0x190; }, ConfigFinding::kCobIdTwice, 5},
      {[](CanopenArmConfig& c) { c.axis[5].tpdo2_cob_id = 0x28C; }, ConfigFinding::kCobIdTwice, 5},
      {[](CanopenArmConfig& c) { c.axis[5].rpdo2_cob_id = 0x290; }, ConfigFinding::kCobIdTwice, 5},
      {[](CanopenArmConfig& c) { c.axis[2].tpdo2_cob_id = 0x30E; }, ConfigFinding::kCobIdTwice, 3},
      {[](CanopenArmConfig& c) { c.axis[1].bus = 2; }, ConfigFinding::kBus, 1},
      {[](CanopenArmConfig& c) { c.axis[6].bus = 255; }, ConfigFinding::kBus, 6},
      {[](CanopenArmConfig& c) {
         for (auto& axis : c.axis) axis.bus = 1;
       },
       ConfigFinding::kBus, -1},
      {[](CanopenArmConfig& c) {
         c.axis[2].node_id = c.axis[1].node_id;
         c.axis[6].bus = 1;
       },
       ConfigFinding::kNodeIdTwice, 2},
      {[](CanopenArmConfig& c) {
         c.share_targets = true;
         c.axis[3].rpdo1_cob_id = 0x1FF;
         c.axis[5].tpdo1_cob_id = 0x20B;
       },
       ConfigFinding::kCobIdTwice, 5},
      {[](CanopenArmConfig& c) { c.sync_period_ns = 2'050'000; }, ConfigFinding::kPeriod, -1},
      {[](CanopenArmConfig& c) { c.heartbeat_timeout_ns = c.heartbeat_ns; }, ConfigFinding::kHeartbeat, -1},
      {[](CanopenArmConfig& c) { c.heartbeat_ns = 0; }, ConfigFinding::kHeartbeat, -1},
      {[](CanopenArmConfig& c) { c.statusword_timer_ns = 3'000'000; }, ConfigFinding::kStatuswordTimer, -1},
      {[](CanopenArmConfig& c) { c.statusword_timer_ns += 1; }, ConfigFinding::kStatuswordTimer, -1},
      {[](CanopenArmConfig& c) { c.boot_timeout_ns = 0; }, ConfigFinding::kTimeout, -1},
      {[](CanopenArmConfig& c) { c.tolerated_missing_pdos = 2; }, ConfigFinding::kTolerance, -1},
      {[](CanopenArmConfig& c) { c.must_be_homed = !(c.read_homing = false); }, ConfigFinding::kTolerance,
       -1},
  };
  for (const auto& row : rows) {
    CanopenArmConfig config = config_of_drives();
    row.change(config);
    const ConfigResult result = check(config);
    EXPECT_EQ(result.finding, row.finding) << describe(row.finding) << " / " << describe(result.finding);
    EXPECT_EQ(result.axis, row.axis) << describe(row.finding);
    EXPECT_STRNE(describe(row.finding), "unknown finding");
  }
}

TEST(ArmConfigTest, FiltersLetThroughWhatTheMasterReads) {
  std::array<CanFilter, kMaxFilters> filters;
  const std::size_t count = receive_filters(config_of_drives(), 0, filters);
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < count; ++i) ids.insert(filters[i].id);
  EXPECT_EQ(ids.size(), 35U);
  for (const std::uint32_t id :
       {0x18BU, 0x28BU, 0x58BU, 0x08BU, 0x70BU, 0x191U, 0x291U, 0x591U, 0x091U, 0x711U}) {
    EXPECT_EQ(ids.count(id), 1U) << std::hex << id;
  }
}

TEST(ArmConfigTest, FiltersOfABusAreThoseOfItsAxes) {
  const CanopenArmConfig config = testing::config_of_two_buses();
  ASSERT_EQ(check(config).finding, ConfigFinding::kNone);  // node ids may come again on the other bus
  EXPECT_EQ(bus_count(config), 2);
  EXPECT_EQ(bus_count(config_of_drives()), 1);
  std::array<CanFilter, kMaxFilters> filters;
  EXPECT_EQ(receive_filters(config, 0, filters), 20U);
  EXPECT_EQ(receive_filters(config, 1, filters), 15U);
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < 15; ++i) ids.insert(filters[i].id);
  EXPECT_EQ(ids.count(0x18BU), 1U);
  EXPECT_EQ(ids.count(0x18EU), 0U);  // of the other bus's fourth drive
}

TEST(BootScriptTest, FitsAndScales) {
  CanopenArmConfig config = config_of_drives();
  config.axis[1].vendor_id = 7;
  const BootScript script = boot_script(config, 1);
  EXPECT_LT(script.size(), 56U);  // its capacity
  const auto value_of = [&](std::uint16_t index, std::uint8_t sub) {
    std::uint32_t value = 0;
    for (const BootStep& step : script) {
      if (step.object.index == index && step.object.sub == sub) value = step.object.value;
    }
    return value;
  };
  EXPECT_EQ(value_of(0x1016, 1), 0x7F0032U);  // node 127, 50 ms
  EXPECT_EQ(value_of(0x1017, 0), 20U);
  EXPECT_EQ(value_of(0x1006, 0), 2000U);
  EXPECT_EQ(value_of(0x6085, 0), 220000U);  // 20 rad/s^2 of 11000 units, without sign
  EXPECT_EQ(value_of(0x6065, 0), 11000U);
  EXPECT_EQ(value_of(0x6060, 0), 9U);
  EXPECT_EQ(value_of(0x60C2, 1), 2U);
  EXPECT_EQ(value_of(0x60C2, 2), 0xFDU);
  EXPECT_EQ(value_of(0x1600, 1), 0x60FF0020U);
  EXPECT_EQ(value_of(0x1601, 1), 0x60400010U);
  EXPECT_EQ(value_of(0x1A00, 1), 0x60640020U);
  EXPECT_EQ(value_of(0x1A01, 1), 0x60410010U);
  EXPECT_EQ(value_of(0x1801, 5), 100U);
  EXPECT_EQ(value_of(0x1400, 1), 0x20CU);
  EXPECT_EQ(value_of(0x1401, 1), 0x30CU);
  EXPECT_EQ(value_of(0x1801, 1), 0x4000028CU);
  EXPECT_EQ(value_of(0x1402, 1), 0x8000040CU);
  EXPECT_EQ(value_of(0x1800, 1), 0x4000018CU);
  EXPECT_EQ(value_of(0x1803, 1), 0x8000048CU);
  EXPECT_EQ(value_of(0x1018, 1), 7U);
}

TEST(MemoryBusTest, FramesArriveInOrderAtAllOthers) {
  const auto bus = std::make_unique<MemoryBus>();
  bus->advance(7);
  ASSERT_TRUE(bus->port(0).send(can_frame(1, {1})));
  ASSERT_TRUE(bus->port(1).send(can_frame(2, {2})));
  CanFrame frame;
  ASSERT_TRUE(bus->port(2).receive(frame));
  EXPECT_EQ(frame.id, 1U);
  EXPECT_EQ(frame.stamp_ns, 7);
  ASSERT_TRUE(bus->port(2).receive(frame));
  EXPECT_EQ(frame.id, 2U);
  EXPECT_FALSE(bus->port(2).receive(frame));
  ASSERT_TRUE(bus->port(0).receive(frame));
  EXPECT_EQ(frame.id, 2U);  // not its own
  EXPECT_FALSE(bus->port(0).receive(frame));
}

TEST(MemoryBusTest, FramesAreLostDelayedRefusedAndOverflow) {
  const auto bus = std::make_unique<MemoryBus>();
  MemoryBus::Port& from = bus->port(0);
  MemoryBus::Port& to = bus->port(1);
  CanFrame frame;
  ASSERT_TRUE(bus->drop({0x180, 0x780}, 1));
  ASSERT_TRUE(from.send(can_frame(0x185, {})));
  EXPECT_FALSE(to.receive(frame));
  ASSERT_TRUE(from.send(can_frame(0x185, {})));
  EXPECT_TRUE(to.receive(frame));

  ASSERT_TRUE(bus->delay({0x205}, 100));
  ASSERT_TRUE(from.send(can_frame(0x205, {})));
  bus->advance(99);
  EXPECT_FALSE(to.receive(frame));
  bus->advance(100);
  EXPECT_TRUE(to.receive(frame));
  bus->clear_faults();

  from.set_full(true);
  EXPECT_FALSE(from.send(can_frame(0x205, {})));
  EXPECT_EQ(from.health().tx_refused, 1U);
  from.set_full(false);

  to.set_queue_limit(3);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(from.send(can_frame(0x205, {})));
  EXPECT_EQ(to.health().rx_overflows, 2U);

  from.set_off(true);
  EXPECT_FALSE(from.send(can_frame(0x205, {})));
  EXPECT_EQ(from.health().state, BusState::kOff);
  from.set_off(false);
  EXPECT_TRUE(from.send(can_frame(0x205, {})));
  for (std::size_t i = 0; i < MemoryBus::kFaults; ++i) EXPECT_TRUE(bus->drop({1}));
  EXPECT_FALSE(bus->drop({1}));
}

TEST(RestartPolicyTest, ComesBackAfterADelayAndNotForEver) {
  RestartPolicy policy;
  constexpr std::int64_t kStep = 1'000'000;
  std::int64_t t_ns = 0;
  int restarts = 0;
  EXPECT_FALSE(policy.is_due(t_ns, true));
  for (; t_ns < 20 * RestartPolicy::kDelay_ns; t_ns += kStep) {
    const bool due = policy.is_due(t_ns, true);
    if (due) {
      EXPECT_EQ(t_ns % RestartPolicy::kDelay_ns, 0) << t_ns;
      ++restarts;
    }
  }
  EXPECT_EQ(restarts, RestartPolicy::kMostRestarts);
  EXPECT_TRUE(policy.has_given_up());
  // Somebody mends the bus; after a while without trouble it is trusted again.
  const std::int64_t well_ns = t_ns + RestartPolicy::kWindow_ns + 1;
  for (; t_ns <= well_ns; t_ns += kStep) EXPECT_FALSE(policy.is_due(t_ns, false));
  EXPECT_FALSE(policy.has_given_up());
  EXPECT_FALSE(policy.is_due(t_ns, true));
  EXPECT_TRUE(policy.is_due(t_ns + RestartPolicy::kDelay_ns, true));
}

TEST(ArmFaultTest, HasACodeAndWords) {
  const ArmFaultRecord abort = {5, ArmFaultKind::kSdoAbort, 2, 1, 0x1016, 0x06020000};
  EXPECT_EQ(fault_code(abort), 0x02031016U);
  EXPECT_STREQ(describe(abort).data(),
               "axis 3: a transfer was aborted (object 0x1016:01): 0x6020000, object does not exist");
  const ArmFaultRecord emergency = {5, ArmFaultKind::kEmergency, 0, 0, 0, 0x4310};
  EXPECT_STREQ(describe(emergency).data(), "axis 1: emergency: 0x4310, drive too hot");
  const ArmFaultRecord bus = {5, ArmFaultKind::kBusOff, -1, 0, 0, 3};
  EXPECT_STREQ(describe(bus).data(), "the bus cannot be used: 0x3, bus off");
  const ArmFaultRecord second_bus{0, ArmFaultKind::kBusOff, -1, 0, 0, 3, 1};
  EXPECT_STREQ(describe(second_bus).data(), "bus 2: the bus cannot be used: 0x3, bus off");
  EXPECT_EQ(fault_code(second_bus), (static_cast<std::uint32_t>(ArmFaultKind::kBusOff) << 24 | 0x090003U));
  EXPECT_EQ(fault_code({}), 0U);
  std::set<std::string> words;
  for (int kind = 0; kind <= static_cast<int>(ArmFaultKind::kNoCommand); ++kind) {
    words.insert(describe({0, static_cast<ArmFaultKind>(kind), 0, 0, 0, 0}).data());
  }
  EXPECT_EQ(words.size(), static_cast<std::size_t>(ArmFaultKind::kNoCommand) + 1);
}

}  // namespace
}  // namespace vergence::canopen
