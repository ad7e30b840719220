// The master of an arm's drives: boots them, switches them on and off together, sends velocities, and stops
// all of them as soon as anything is wrong with one.
//
// A period, in this order: process() takes what came since the last one, judges it, sends SYNC, and words of
// the state machine where there is news; read() gives the positions the SYNC before asked for; command()
// sends velocities, which act from the next SYNC. A period that comes less than half a period after the last
// is left out: a task that was late and hurries has not given the drives time to answer.
//
// While the arm is being stopped, process() sends the quick stop before SYNC; it acts at once, and is
// repeated until each drive's statusword says so. The velocities that follow that SYNC are zero.
#pragma once

#include <array>
#include <cstdint>

#include "hal/arm.hpp"
#include "hal/canopen/axis.hpp"

namespace vergence::canopen {

class ArmMaster {
 public:
  // Nothing else may be called before this has found nothing. Booting begins.
  [[nodiscard]] ConfigResult init(const CanopenArmConfig& config, std::int64_t now_ns);

  void receive(const CanFrame& frame, std::int64_t now_ns);
  void process(std::int64_t now_ns, const CanHealth& health, const FrameSink& sink);

  // False until all drives have booted and answered, or something went wrong. The stamp is the SYNC's.
  [[nodiscard]] bool read(ArmFeedback& feedback);
  void command(const std::array<double, kMaxJoints>& velocity_rad_per_s, const FrameSink& sink);
  // kEnable, kDisable and kQuickStop hold until the next one; a moving arm is stopped before it is switched
  // off. kResetFault is obeyed once the arm has stopped, and boots again what must be. After a fault the arm
  // is not enabled before it was asked for something else.
  void request(ArmRequest request);

  // The fault that stopped the arm, until it is reset.
  [[nodiscard]] const ArmFaultRecord& fault() const { return fault_; }
  [[nodiscard]] const Axis& axis(int i) const { return axes_[static_cast<std::size_t>(i)]; }

 private:
  enum class State : std::uint8_t {
    kBoot,
    kOff,
    kEnabling,
    kOn,
    kStopping,
    kFault
  };

  void enter(State state);
  void boot();
  void judge_bus(const CanHealth& health);
  void judge_axes();
  void watch();
  void stop(const ArmFaultRecord& fault);
  void stop_whole(ArmFaultKind kind, std::uint32_t detail);
  void advance();
  void advance_fault();
  void reset();
  [[nodiscard]] bool has_stopped() const;
  template <typename Predicate>
  [[nodiscard]] bool all(Predicate predicate) const;
  [[nodiscard]] DriveGoal goal() const;
  [[nodiscard]] bool is_stopping() const { return state_ == State::kStopping || state_ == State::kFault; }
  void steer_all(const FrameSink& sink);
  void send_targets(const FrameSink& sink);
  void send_refused(const FrameSink& sink);
  void publish();

  CanopenArmConfig config_;
  std::size_t count_ = 0;
  std::array<Axis, kMaxJoints> axes_{};
  HeartbeatProducer heartbeat_;

  std::int64_t now_ns_ = 0;
  std::int64_t sync_ns_ = 0;
  bool sync_sent_ = false;
  bool sync_refused_ = false;
  bool too_soon_ = false;
  State state_ = State::kBoot;
  std::int64_t since_ns_ = 0;  // in this state
  bool resetting_ = false;     // booting after a fault
  bool stopped_ = false;       // in a fault, and at rest
  ArmFaultRecord fault_;

  ArmRequest wanted_ = ArmRequest::kDisable;
  bool reset_wanted_ = false;
  bool may_enable_ = true;
  std::array<double, kMaxJoints> velocity_rad_per_s_{};
  int periods_without_command_ = 0;
  std::array<CanFrame, kMaxJoints> targets_{};
  std::array<bool, kMaxJoints> refused_{};  // targets to be sent again
  bool word_refused_ = false;               // a controlword; it is tried again by itself
  int periods_refused_ = 0;

  ArmFeedback feedback_;
  bool fresh_ = false;
};

// With its bus, as the controller wants an arm to be. The bus must outlive it.
template <CanBus Bus>
class CanopenArm {
 public:
  explicit CanopenArm(Bus& bus) : bus_(&bus) {}

  [[nodiscard]] ConfigResult init(const CanopenArmConfig& config, std::int64_t now_ns) {
    return master_.init(config, now_ns);
  }
  // Once a period, before the others.
  void process(std::int64_t now_ns) {
    bus_->process(now_ns);
    CanFrame frame;
    for (int i = 0; i < kMostFrames && bus_->receive(frame); ++i) master_.receive(frame, now_ns);
    master_.process(now_ns, bus_->health(), FrameSink(*bus_));
  }
  [[nodiscard]] bool read(ArmFeedback& feedback) { return master_.read(feedback); }
  void command(const std::array<double, kMaxJoints>& velocity_rad_per_s) {
    master_.command(velocity_rad_per_s, FrameSink(*bus_));
  }
  void request(ArmRequest request) { master_.request(request); }

  [[nodiscard]] const ArmMaster& master() const { return master_; }

 private:
  // More than a bus of 1 Mbit/s carries in the longest period, so that a flood cannot hold up the task.
  static constexpr int kMostFrames = 600;

  Bus* bus_;
  ArmMaster master_;
};

}  // namespace vergence::canopen
