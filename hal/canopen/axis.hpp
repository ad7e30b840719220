// One drive as the master sees it: booted by a script, watched once it runs, its process data in radians.
#pragma once

#include <cstdint>

#include "hal/canopen/arm_config.hpp"
#include "hal/canopen/arm_fault.hpp"
#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/boot_script.hpp"
#include "hal/canopen/drive_state.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/heartbeat.hpp"
#include "hal/canopen/sdo_client.hpp"

namespace vergence::canopen {

enum class AxisPhase : std::uint8_t {
  kReset,  // to be told to reset its communication
  kAwaitBoot,
  kConfigure,   // the script runs
  kConfigured,  // waits for the others
  kStart,       // to be told to start
  kAwaitStart,  // for operational and the first process data
  kRunning,
  kFailed,  // no longer to be trusted; until it is booted again
};

class Axis {
 public:
  // Of a config that passed check().
  void init(const CanopenArmConfig& config, int axis, std::int64_t now_ns);

  // From the beginning; the record of what went wrong goes.
  void boot(std::int64_t now_ns);
  // Out of kConfigured.
  void start(std::int64_t now_ns);

  void receive(const CanFrame& frame, std::int64_t now_ns);
  // Boots and watches; sends what that takes.
  void process(std::int64_t now_ns, const FrameSink& sink);
  // Takes the position that came since the SYNC of `sync_ns`, and notices where none did; one more may be
  // missing while the arm is being stopped, when the words that stop it hold up what comes after them.
  void sample(std::int64_t now_ns, std::int64_t sync_ns, bool is_stopping);

  // Puts what acts with the next SYNC into its place of a frame; the rest of that is another axis's. The
  // velocity (rad/s) counts where the goal is kOn and the drive is there; it is clamped, and what is no
  // number counts as zero. Once a period.
  void put_target(DriveGoal goal, double velocity_rad_per_s, CanFrame& frame);
  // Sends the controlword that leads towards the goal, which acts at once: where it is another than before,
  // and again where the drive does not say that it followed; a quick stop each period until it does. Once a
  // period; false where the bus did not take it, which is as if it had not been tried.
  [[nodiscard]] bool steer(DriveGoal goal, const FrameSink& sink);
  // From now on following is watched, from zero.
  void expect_following();
  // What an enabled axis must not do: leave its state, or fail to follow.
  void watch_enabled(std::int64_t now_ns);
  // Whatever the state: a fault of the drive, or a statusword without meaning.
  void watch_drive(std::int64_t now_ns);

  // The first fault counts until boot() or clear_fault().
  void fail(ArmFaultKind kind, std::uint32_t detail, std::int64_t now_ns);
  void clear_fault() { fault_ = {}; }
  [[nodiscard]] const ArmFaultRecord& fault() const { return fault_; }

  [[nodiscard]] AxisPhase phase() const { return phase_; }
  [[nodiscard]] DriveState drive() const { return decode_state(statusword_); }
  [[nodiscard]] std::uint16_t statusword() const { return statusword_; }
  [[nodiscard]] HomingState homing() const { return homing_; }
  [[nodiscard]] const Emergency& last_emergency() const { return emergency_; }
  [[nodiscard]] double position_rad() const { return position_rad_; }
  [[nodiscard]] double velocity_rad_per_s() const { return velocity_rad_per_s_; }
  // Objects the drive does not have and can do without.
  [[nodiscard]] int objects_left_out() const { return left_out_; }
  // From SYNC to the process data it asked for, of the last period whose frames had stamps.
  [[nodiscard]] std::int64_t response_ns() const { return response_ns_; }

 private:
  void judge_boots(std::int64_t now_ns);
  void configure(std::int64_t now_ns, const FrameSink& sink);
  void begin_step(std::int64_t now_ns);
  [[nodiscard]] bool end_step(std::int64_t now_ns);
  void fail_step(ArmFaultKind kind, std::uint32_t detail, std::int64_t now_ns);
  void receive_feedback(const CanFrame& frame, std::int64_t now_ns);
  void take_statusword(std::uint32_t value, std::int64_t now_ns);
  void ask_for_statusword(std::int64_t now_ns, const FrameSink& sink);
  [[nodiscard]] bool has_followed(DriveCommand command) const;
  [[nodiscard]] double allowed_velocity(double velocity_rad_per_s) const;
  void follow(double dt_s);

  CanopenAxisConfig config_;
  CyclicMode mode_ = CyclicMode::kVelocity;
  bool must_be_homed_ = false;
  int number_ = 0;
  double period_s_ = 0;
  std::int64_t boot_timeout_ns_ = 0;
  std::int64_t sdo_timeout_ns_ = 0;
  int tolerated_missing_ = 0;
  std::int64_t statusword_timer_ns_ = 0;
  AxisPdos pdos_;
  std::uint8_t target_offset_ = 0;  // bytes
  BootScript script_;

  AxisPhase phase_ = AxisPhase::kReset;
  std::int64_t since_ns_ = 0;
  std::size_t step_ = 0;
  bool step_begun_ = false;
  std::uint32_t boots_ = 1;  // that are in order
  int left_out_ = 0;
  HomingState homing_ = HomingState::kUnknown;
  SdoClient sdo_;
  HeartbeatConsumer heartbeat_;
  Emergency emergency_;
  ArmFaultRecord fault_;

  // Process data.
  std::uint16_t statusword_ = 0;
  bool statusword_known_ = false;
  std::int64_t statusword_ns_ = 0;
  bool has_statusword_timer_ = true;
  bool asking_ = false;  // for the statusword
  std::int64_t asked_ns_ = 0;
  std::int32_t counts_ = 0;
  std::int64_t arrived_ns_ = 0;
  bool arrived_ = false;
  int missing_ = 0;
  bool sampled_ = false;  // there is a sample to take a difference from
  std::int32_t sampled_counts_ = 0;
  std::int64_t sampled_ns_ = 0;
  std::int64_t response_ns_ = 0;
  double position_rad_ = 0;
  double velocity_rad_per_s_ = 0;

  // What it was told.
  DriveCommand last_command_ = DriveCommand::kNone;  // that the bus took
  bool told_ = false;                                // while it could hear
  int periods_since_told_ = 0;
  double commanded_rad_per_s_ = 0;
  double target_rad_ = 0;  // of the position mode
  double slip_rad_ = 0;    // how far it stays behind what it was told
};

}  // namespace vergence::canopen
