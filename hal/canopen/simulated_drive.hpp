// A drive of CiA 402 on a CAN bus, written from the standard as the other side of the master: for tests and
// for a simulated arm. Its motor follows as a first-order lag. Faults can be put into it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/drive_objects.hpp"
#include "hal/canopen/drive_state.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/fixed_list.hpp"
#include "hal/canopen/heartbeat.hpp"
#include "hal/canopen/sdo_server.hpp"

namespace vergence::canopen {

struct SimulatedDriveOptions {
  std::uint8_t node_id = 1;
  std::uint32_t vendor_id = 0x1D5;
  double counts_per_velocity_unit = 1;  // counts/s that one unit of 0x60FF means
  double time_constant_s = 0.01;
  std::int32_t start_counts = 0;
  bool is_homed = true;
  // False: somebody else moves the motor, in velocity mode, and tells by set_motion().
  bool has_motor = true;
};

class SimulatedDrive {
 public:
  // Switched on: boots with the next process().
  void init(const SimulatedDriveOptions& options, std::int64_t now_ns);

  void receive(const CanFrame& frame, std::int64_t now_ns);
  // Moves the motor and sends what is due; what is refused is sent next time.
  void process(std::int64_t now_ns, const FrameSink& sink);

  // Faults.
  void set_power(bool is_on);  // off: neither hears nor says anything, and the brake holds; on: boots
  void restart();              // by itself
  void set_heartbeat(bool is_on) { heartbeat_on_ = is_on; }
  void set_pdo(bool is_on) { pdo_on_ = is_on; }
  void emergency(std::uint16_t code) { queue_emergency(code); }  // without more
  void fail(std::uint16_t code);                                 // emergency and fault reaction
  void jam(bool is_jammed) { jammed_ = is_jammed; }
  void refuse(std::uint16_t index, std::uint8_t sub, std::uint32_t code) {
    objects_.refuse(index, sub, code);
  }
  void show_statusword(std::optional<std::uint16_t> statusword) { shown_ = statusword; }
  void set_state(DriveState state) { state_ = state; }

  // For a motor of somebody else's: it is to follow this velocity while the drive is enabled, and to brake
  // otherwise. A drive that braked goes on from there when it is told of velocity zero.
  [[nodiscard]] double wanted_counts_per_s() const;
  [[nodiscard]] double quick_stop_counts_per_s2() const;
  void set_motion(double position_counts, double velocity_counts_per_s);

  [[nodiscard]] DriveState state() const { return state_; }
  [[nodiscard]] NmtState nmt() const { return nmt_; }
  [[nodiscard]] std::uint16_t statusword() const;
  [[nodiscard]] double position_counts() const { return position_; }
  [[nodiscard]] double velocity_counts_per_s() const { return velocity_; }
  [[nodiscard]] const DriveObjects& objects() const { return objects_; }

 private:
  // Process data to the drive, as received.
  struct Command {
    CanFrame frame;
    bool is_here = false;  // for the next SYNC
  };
  // Process data from the drive.
  struct Feedback {
    CanFrame frame;
    bool is_due = false;
    bool was_sent = false;  // since the node was started; then it is `frame`
    std::int64_t sent_ns = 0;
  };

  void reset_communication();
  void obey_nmt(NmtCommand command);
  void on_sync(std::int64_t now_ns);
  void on_written(std::uint16_t index);
  void take_pdos(const CanFrame& frame);
  void apply_pdo(std::size_t pdo);
  void obey(std::uint16_t controlword);
  void lose_connection(std::uint16_t code);
  void queue_emergency(std::uint16_t code);
  void refresh();
  [[nodiscard]] bool pdo_frame(std::size_t pdo, CanFrame& frame);
  void note_event(std::size_t pdo, std::int64_t now_ns);
  void send_pdos(std::int64_t now_ns, const FrameSink& sink);
  [[nodiscard]] std::size_t mapped_bytes(std::uint16_t mapping) const;
  void move(std::int64_t now_ns);
  void follow(double dt_s);
  void brake(double dt_s);
  void leave_braking();
  void supervise(std::int64_t now_ns);

  SimulatedDriveOptions options_;
  DriveObjects objects_;
  SdoServer sdo_;
  HeartbeatProducer heartbeat_;

  NmtState nmt_ = NmtState::kPreOperational;
  bool boots_ = true;
  bool powered_ = true;
  bool heartbeat_on_ = true;
  bool pdo_on_ = true;
  bool jammed_ = false;
  std::optional<std::uint16_t> shown_;

  CanFrame answer_;
  bool answer_due_ = false;
  std::array<Feedback, DriveObjects::kMappablePdos> feedbacks_{};
  std::array<Command, DriveObjects::kMappablePdos> commands_{};
  FixedList<Emergency, 8> emergencies_;

  bool master_seen_ = false;
  std::int64_t master_ns_ = 0;
  bool sync_seen_ = false;
  std::int64_t sync_ns_ = 0;

  DriveState state_ = DriveState::kNotReady;
  std::uint16_t controlword_ = 0;
  std::int64_t now_ns_ = 0;
  double position_ = 0;  // counts
  double velocity_ = 0;  // counts/s
  bool following_error_ = false;
  double behind_s_ = 0;  // for how long
};

}  // namespace vergence::canopen
