// Seven simulated drives and their master on a bus in memory, or on two, period by period.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "hal/canopen/arm_master.hpp"
#include "hal/canopen/memory_bus.hpp"
#include "hal/canopen/simulated_drive.hpp"

namespace vergence::testing {

using canopen::ArmFaultKind;
using canopen::CanopenArmConfig;
using canopen::DriveState;

// Of every axis another scale, and every second one turned round.
inline CanopenArmConfig config_of_drives() {
  CanopenArmConfig config;
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const double counts_per_rad = (i % 2 == 0 ? 1 : -1) * (100000.0 + 10000.0 * static_cast<double>(i));
    config.axis[i].node_id = static_cast<std::uint8_t>(11 + i);
    config.axis[i].counts_per_rad = counts_per_rad;
    config.axis[i].velocity_units_per_rad_per_s = counts_per_rad / 10;  // a unit is 10 counts/s
    config.axis[i].zero_counts = static_cast<std::int32_t>(1000 * i);
  }
  config.boot_timeout_ns = 1'000'000'000;
  config.enable_timeout_ns = 300'000'000;
  return config;
}

// Four axes on one bus and three on another, at 1 kHz, whose targets share frames. The node ids of one bus
// are also those of the other: they are networks of their own.
inline CanopenArmConfig config_of_two_buses() {
  CanopenArmConfig config = config_of_drives();
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    config.axis[i].bus = i < 4 ? 0 : 1;
    config.axis[i].node_id = static_cast<std::uint8_t>(11 + i % 4);
  }
  config.sync_period_ns = 1'000'000;
  config.share_targets = true;
  return config;
}

class CanopenRobot {
 public:
  static constexpr std::size_t kDrives = kMaxJoints;

  explicit CanopenRobot(const CanopenArmConfig& its_config = config_of_drives())
      : config(its_config),
        bus(std::make_unique<canopen::MemoryBus>()),
        second_bus(std::make_unique<canopen::MemoryBus>()),
        arm(bus->port(kDrives), second_bus->port(kDrives)) {
    for (std::size_t i = 0; i < kDrives; ++i) {
      canopen::SimulatedDriveOptions options;
      options.node_id = config.axis[i].node_id;
      options.counts_per_velocity_unit = 10;
      options.start_counts = config.axis[i].zero_counts;
      drives[i].init(options, t_ns);
    }
    found = arm.init(config, t_ns).finding;
  }

  // In the order of the arm's task.
  void period() {
    t_ns += config.sync_period_ns;
    if (master_runs) arm.process(t_ns);
    step_drives(t_ns);
    if (!master_runs) return;
    fed_back = arm.read(feedback);
    arm.request(request);
    if (commands) arm.command(velocity_rad_per_s);
  }
  // The drives alone, so long after the SYNC: what happens there between two SYNCs.
  void run_drives(std::int64_t after_ns) {
    bus->advance(t_ns + after_ns);
    second_bus->advance(t_ns + after_ns);
    step_drives(t_ns + after_ns);
  }
  void run(int periods) {
    for (int i = 0; i < periods; ++i) period();
  }
  // Until the arm is in this state; false where it takes longer.
  bool run_until(ArmState state, int most_periods) {
    for (int i = 0; i < most_periods; ++i) {
      period();
      if (fed_back && feedback.state == state) return true;
    }
    return false;
  }
  bool boot() { return run_until(ArmState::kDisabled, 500); }
  bool enable() {
    request = ArmRequest::kEnable;
    return run_until(ArmState::kEnabled, 100);
  }
  // Booted, enabled, and at speed.
  bool move(double rad_per_s = 0.5) {
    if (!boot() || !enable()) return false;
    velocity_rad_per_s.fill(rad_per_s);
    run(100);
    return feedback.state == ArmState::kEnabled;
  }

  // How many are in this state.
  [[nodiscard]] std::size_t count(DriveState state) const {
    std::size_t number = 0;
    for (const canopen::SimulatedDrive& drive : drives) number += drive.state() == state ? 1U : 0U;
    return number;
  }
  [[nodiscard]] const canopen::ArmFaultRecord& fault() const { return arm.master().fault(); }
  [[nodiscard]] canopen::MemoryBus& its_bus(int number) { return number == 0 ? *bus : *second_bus; }
  [[nodiscard]] canopen::MemoryBus::Port& master_port(int number = 0) {
    return its_bus(number).port(kDrives);
  }
  [[nodiscard]] canopen::MemoryBus::Port& free_port(int number = 0) {
    return its_bus(number).port(kDrives + 1);
  }
  // What was on the bus since the last call; its queue holds that of three periods.
  std::vector<canopen::CanFrame> heard(int number = 0) {
    std::vector<canopen::CanFrame> frames;
    for (canopen::CanFrame frame; free_port(number).receive(frame);) frames.push_back(frame);
    return frames;
  }

  CanopenArmConfig config;
  std::unique_ptr<canopen::MemoryBus> bus;
  std::unique_ptr<canopen::MemoryBus> second_bus;  // silent, where no axis is on it
  canopen::CanopenArm<canopen::MemoryBus::Port> arm;
  std::array<canopen::SimulatedDrive, kDrives> drives;
  canopen::ConfigFinding found = canopen::ConfigFinding::kNone;
  std::int64_t t_ns = 0;
  ArmFeedback feedback;
  bool fed_back = false;
  ArmRequest request = ArmRequest::kDisable;
  bool master_runs = true;  // otherwise the controller is dead
  bool commands = true;
  std::array<double, kMaxJoints> velocity_rad_per_s{};

 private:
  void step_drives(std::int64_t now_ns) {
    for (std::size_t i = 0; i < kDrives; ++i) {
      canopen::MemoryBus::Port& port = its_bus(config.axis[i].bus).port(i);
      for (canopen::CanFrame frame; port.receive(frame);) drives[i].receive(frame, now_ns);
      drives[i].process(now_ns, canopen::FrameSink(port));
    }
  }
};

}  // namespace vergence::testing
