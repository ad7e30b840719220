// The arm's drives on a CAN interface, and the joints they move: CiA 402 as in hal/canopen/simulated_drive,
// motion as in tools/plant. What can go wrong on a bus is put in here.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "algo/arm_kinematics.hpp"
#include "hal/canopen/arm_config.hpp"
#include "hal/canopen/simulated_drive.hpp"
#include "hal/canopen/socket_can.hpp"
#include "tools/plant/arm_servo.hpp"
#include "tools/rig/file_handle.hpp"
#include "tools/rig/sway.hpp"

namespace vergence::rig {

struct BusCounts {
  std::uint64_t received = 0;
  std::uint64_t sent = 0;
  std::uint64_t syncs = 0;
  std::uint64_t commands = 0;               // received, of anything but a request to read an object
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a over what was received and when
};

class DriveBank {
 public:
  // Switched on, at the start's angles. Throws RigError where the interface cannot be opened.
  DriveBank(const char* interface, const canopen::CanopenArmConfig& config, const SerialArm& arm,
            const JointVector& start_rad, std::int64_t now_ns);

  [[nodiscard]] int handle_to_poll() const { return bus_.handle_to_poll(); }
  // Answers what came.
  void receive(std::int64_t now_ns);
  // Each millisecond: joints move, heartbeats go out.
  void advance(std::int64_t now_ns);

  [[nodiscard]] const plant::JointArray& position_rad() const { return position_rad_; }
  [[nodiscard]] const plant::JointArray& velocity_rad_per_s() const { return velocity_rad_per_s_; }
  // What an enabled drive was sent last; zero of others.
  [[nodiscard]] double sent_rad_per_s(std::size_t joint) const;
  [[nodiscard]] canopen::DriveState state(std::size_t joint) const { return drives_[joint].state(); }
  [[nodiscard]] bool is_any_enabled() const;
  [[nodiscard]] unsigned ends_hit() const { return ends_hit_; }
  [[nodiscard]] const BusCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t joints() const { return count_; }

  // From now on somebody moves joints by hand, as long as drives are off.
  void sway(std::vector<Sway> sways);

  // Faults.
  [[nodiscard]] canopen::SimulatedDrive& drive(std::size_t joint) { return drives_[joint]; }
  // The controller's interface is told that it is bus-off, and nothing passes until it is on again.
  void set_bus(bool is_on);
  // Answers each SYNC in the name of another drive with nonsense.
  void set_impostor(std::optional<std::size_t> joint) { impostor_ = joint; }
  // So many frames of others each millisecond.
  void set_foreign_traffic(int frames_per_ms) { foreign_per_ms_ = frames_per_ms; }

 private:
  void move_to(std::int64_t now_ns);
  void say(std::int64_t now_ns);
  void send_all();
  void count(const canopen::CanFrame& frame, std::int64_t now_ns);
  void send_error_frame(std::uint32_t error_class) const;
  void add_foreign();

  canopen::CanopenArmConfig config_;
  std::size_t count_ = 0;
  canopen::SocketCan bus_;
  std::vector<canopen::CanFrame> out_;  // to be sent together
  FileHandle raw_;                      // for error frames, which no drive sends
  std::array<canopen::SimulatedDrive, kMaxJoints> drives_{};
  std::array<plant::JointDrive, kMaxJoints> motors_{};
  plant::JointArray position_rad_{};
  plant::JointArray velocity_rad_per_s_{};
  std::int64_t now_ns_ = 0;
  std::vector<Sway> sways_;
  plant::JointArray sway_start_rad_{};
  std::int64_t sway_start_ns_ = 0;
  unsigned ends_hit_ = 0;
  BusCounts counts_;

  bool bus_is_on_ = true;
  std::optional<std::size_t> impostor_;
  int foreign_per_ms_ = 0;
  std::uint32_t foreign_number_ = 0;
};

}  // namespace vergence::rig
