#include "tools/rig/drive_bank.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/clock.hpp"
#include "tools/rig/rig_error.hpp"

namespace vergence::rig {
namespace {

using canopen::CanFrame;
using canopen::DriveState;

FileHandle open_raw(const char* interface) {
  FileHandle raw(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface));
  // Only sends.
  const bool is_deaf = raw.is_open() && setsockopt(raw.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) == 0;
  if (!is_deaf || bind(raw.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    fail_with_errno(interface);
  }
  return raw;
}

// The master's scale, turned round.
double counts_per_velocity_unit(const canopen::CanopenAxisConfig& axis) {
  return std::abs(axis.counts_per_rad / axis.velocity_units_per_rad_per_s);
}

// A client's upload, or its end (CiA 301, 7.2.4.3).
bool is_request_to_read(const CanFrame& frame) {
  if ((frame.id & ~0x7FU) != canopen::kSdoRequestCobId || frame.size != 8) return false;
  const int command = frame.data[0] >> 5;
  return command == 2 || command == 3 || command == 4;
}

}  // namespace

DriveBank::DriveBank(const char* interface, const canopen::CanopenArmConfig& config, const SerialArm& arm,
                     const JointVector& start_rad, std::int64_t now_ns)
    : config_(config), count_(static_cast<std::size_t>(arm.joints)), now_ns_(now_ns) {
  const canopen::CanFilter all{0, 0};
  const canopen::SocketStep step = bus_.open(interface, std::span(&all, 1));
  if (step != canopen::SocketStep::kOk) {
    errno = bus_.last_errno();
    fail_with_errno(std::string(interface) + ": " + canopen::describe(step));
  }
  raw_ = open_raw(interface);
  const plant::ArmServoOptions servo = plant::servo_of(arm);
  for (std::size_t i = 0; i < count_; ++i) {
    const canopen::CanopenAxisConfig& axis = config.axis[i];
    motors_[i] = servo.drive[i];
    position_rad_[i] = start_rad[static_cast<Eigen::Index>(i)];
    canopen::SimulatedDriveOptions options;
    options.node_id = axis.node_id;
    if (axis.vendor_id != 0) options.vendor_id = axis.vendor_id;
    options.counts_per_velocity_unit = counts_per_velocity_unit(axis);
    options.start_counts =
        static_cast<std::int32_t>(std::llround(position_rad_[i] * axis.counts_per_rad) + axis.zero_counts);
    options.has_motor = false;
    drives_[i].init(options, now_ns);
  }
  move_to(now_ns);
}

double DriveBank::sent_rad_per_s(std::size_t joint) const {
  if (drives_[joint].state() != DriveState::kOperationEnabled) return 0;
  return drives_[joint].wanted_counts_per_s() / config_.axis[joint].counts_per_rad;
}

bool DriveBank::is_any_enabled() const {
  return std::any_of(drives_.begin(), drives_.begin() + static_cast<std::ptrdiff_t>(count_),
                     [](const auto& drive) { return drive.state() == DriveState::kOperationEnabled; });
}

void DriveBank::sway(std::vector<Sway> sways) {
  sways_ = std::move(sways);
  sway_start_rad_ = position_rad_;
  sway_start_ns_ = now_ns_;
}

void DriveBank::move_to(std::int64_t now_ns) {
  const double dt_s = seconds(now_ns - now_ns_);
  now_ns_ = now_ns;
  for (std::size_t i = 0; i < count_; ++i) {
    const canopen::CanopenAxisConfig& axis = config_.axis[i];
    plant::JointState joint{position_rad_[i], velocity_rad_per_s_[i]};
    plant::JointDrive motor = motors_[i];
    const double most = motor.velocity_rad_per_s;
    const DriveState state = drives_[i].state();
    if (dt_s > 0 && state == DriveState::kOperationEnabled) {
      plant::follow(motor, std::clamp(sent_rad_per_s(i), -most, most), 0, dt_s, joint);
    } else if (dt_s > 0) {
      // As it was told to stop where it stops by itself, the brake otherwise; neither better than it can.
      const double told = drives_[i].quick_stop_counts_per_s2() / std::abs(axis.counts_per_rad);
      const bool drives = state == DriveState::kQuickStopActive || state == DriveState::kFaultReaction;
      if (drives && told > 0) motor.quick_stop_rad_per_s2 = std::min(told, motor.quick_stop_rad_per_s2);
      plant::brake(motor, 0, dt_s, joint);
    }
    if (!sways_.empty() && !is_any_enabled()) {
      joint = swayed(sways_, i, sway_start_rad_[i], seconds(now_ns_ - sway_start_ns_));
    }
    if (plant::keep_between_stops(motor, joint)) ends_hit_ |= 1U << i;
    position_rad_[i] = joint.position_rad;
    velocity_rad_per_s_[i] = joint.velocity_rad_per_s;
    drives_[i].set_motion(joint.position_rad * axis.counts_per_rad + axis.zero_counts,
                          joint.velocity_rad_per_s * axis.counts_per_rad);
  }
}

void DriveBank::count(const CanFrame& frame, std::int64_t now_ns) {
  ++counts_.received;
  if (frame.id == canopen::kSyncCobId) ++counts_.syncs;
  if (!is_request_to_read(frame)) ++counts_.commands;
  const auto add = [this](std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) counts_.hash = (counts_.hash ^ (value >> (8 * i) & 0xFF)) * 0x100000001b3;
  };
  add(static_cast<std::uint64_t>(now_ns), 8);
  add(frame.id, 4);
  for (const std::uint8_t byte : frame.payload()) add(byte, 1);
}

void DriveBank::receive(std::int64_t now_ns) {
  CanFrame frame;
  bool synced = false;
  while (bus_.receive(frame)) {
    if (!bus_is_on_) continue;
    count(frame, now_ns);
    move_to(now_ns);
    for (std::size_t i = 0; i < count_; ++i) drives_[i].receive(frame, now_ns);
    synced = synced || frame.id == canopen::kSyncCobId;
    say(now_ns);
  }
  if (synced && impostor_) {
    CanFrame lie;
    lie.id = canopen::axis_pdos(config_, static_cast<int>(*impostor_)).position.cob_id;
    lie.size = 4;
    lie.data = {0xEF, 0xBE, 0xAD, 0x0E};
    out_.push_back(lie);
  }
  send_all();
}

// In one call for all drives: each call is dear in User Mode Linux. A virtual bus is never full.
void DriveBank::send_all() {
  counts_.sent += bus_.send(out_);
  out_.clear();
}

void DriveBank::say(std::int64_t now_ns) {
  if (!bus_is_on_) return;
  struct Outbox {
    std::vector<CanFrame>& frames;
    void process(std::int64_t) {}
    bool send(const CanFrame& frame) {
      frames.push_back(frame);
      return true;
    }
    bool receive(CanFrame&) { return false; }
    [[nodiscard]] const canopen::CanHealth& health() const { return well; }
    canopen::CanHealth well;
  } outbox{out_, {}};
  const canopen::FrameSink sink(outbox);
  for (std::size_t i = 0; i < count_; ++i) drives_[i].process(now_ns, sink);
}

void DriveBank::advance(std::int64_t now_ns) {
  move_to(now_ns);
  if (bus_is_on_) {
    say(now_ns);
    for (int i = 0; i < foreign_per_ms_; ++i) add_foreign();
    send_all();
    return;
  }
  // Cut off, drives go on by themselves: they miss SYNC and heartbeat.
  struct Nowhere {
    void process(std::int64_t) {}
    bool send(const CanFrame&) { return true; }
    bool receive(CanFrame&) { return false; }
    [[nodiscard]] const canopen::CanHealth& health() const { return none; }
    canopen::CanHealth none;
  } nowhere;
  for (std::size_t i = 0; i < count_; ++i) drives_[i].process(now_ns, canopen::FrameSink(nowhere));
}

void DriveBank::add_foreign() {
  // Identifiers that nobody of the arm has, from the most urgent to the least.
  constexpr std::uint32_t kIds[] = {0x010, 0x0F0, 0x170, 0x3F0, 0x4F0, 0x7F0};
  CanFrame frame;
  frame.id = kIds[foreign_number_++ % std::size(kIds)];
  frame.size = 8;
  frame.data.fill(static_cast<std::uint8_t>(foreign_number_));
  out_.push_back(frame);
}

void DriveBank::send_error_frame(std::uint32_t error_class) const {
  can_frame frame{};
  frame.can_id = CAN_ERR_FLAG | error_class;
  frame.can_dlc = CAN_ERR_DLC;
  if (write(raw_.get(), &frame, sizeof frame) != static_cast<ssize_t>(sizeof frame))
    fail_with_errno("error frame");
}

void DriveBank::set_bus(bool is_on) {
  bus_is_on_ = is_on;
  send_error_frame(is_on ? CAN_ERR_RESTARTED : CAN_ERR_BUSOFF);
}

}  // namespace vergence::rig
