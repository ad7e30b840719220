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
//
// The axes may be on two buses. SYNC goes out on both in the same period, and whatever goes wrong on one of
// them stops the axes of both.
#pragma once

#include <array>
#include <cstdint>

#include "hal/arm.hpp"
#include "hal/canopen/axis.hpp"

namespace vergence::canopen {

// A bus as the master needs it, or the same one twice. What it refers to outlives the call.
struct MasterBus {
  FrameSink sink;
  const CanHealth* health;
};
using MasterBuses = std::array<MasterBus, kMaxBuses>;

class ArmMaster {
 public:
  // Nothing else may be called before this has found nothing. Booting begins.
  [[nodiscard]] ConfigResult init(const CanopenArmConfig& config, std::int64_t now_ns);

  void receive(int bus, const CanFrame& frame, std::int64_t now_ns);
  void process(std::int64_t now_ns, const MasterBuses& buses);

  // False until all drives have booted and answered, or something went wrong. The stamp is the SYNC's.
  [[nodiscard]] bool read(ArmFeedback& feedback);
  void command(const std::array<double, kMaxJoints>& velocity_rad_per_s, const MasterBuses& buses);
  // kEnable, kDisable and kQuickStop hold until the next one; a moving arm is stopped before it is switched
  // off. kResetFault is obeyed once the arm has stopped, and boots again what must be. After a fault the arm
  // is not enabled before it was asked for something else.
  void request(ArmRequest request);

  // The fault that stopped the arm, until it is reset.
  [[nodiscard]] const ArmFaultRecord& fault() const { return fault_; }
  [[nodiscard]] const Axis& axis(int i) const { return axes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int buses() const { return static_cast<int>(bus_count_); }

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
  void judge_bus(std::size_t bus, const CanHealth& health);
  void judge_buses(const MasterBuses& buses);
  void judge_axes();
  void watch();
  void stop(const ArmFaultRecord& fault);
  void stop_whole(ArmFaultKind kind, std::uint32_t detail, std::size_t bus = kMaxBuses);
  void advance();
  void advance_fault();
  void reset();
  [[nodiscard]] bool has_stopped() const;
  template <typename Predicate>
  [[nodiscard]] bool all(Predicate predicate) const;
  [[nodiscard]] DriveGoal goal() const;
  [[nodiscard]] bool is_stopping() const { return state_ == State::kStopping || state_ == State::kFault; }
  [[nodiscard]] std::size_t bus_of(std::size_t axis) const { return config_.axis[axis].bus; }
  void send_sync(const MasterBuses& buses);
  void steer_all(const MasterBuses& buses);
  void send_targets(const MasterBuses& buses);
  void send_refused(const MasterBuses& buses);
  void publish();

  // What is kept of each bus.
  struct Line {
    HeartbeatProducer heartbeat;
    bool sync_sent = false;
    bool sync_refused = false;
    bool word_refused = false;  // a controlword; it is tried again by itself
    int periods_refused = 0;
  };

  CanopenArmConfig config_;
  std::size_t count_ = 0;
  std::size_t bus_count_ = 1;
  std::array<Axis, kMaxJoints> axes_{};
  std::array<Line, kMaxBuses> lines_{};

  std::int64_t now_ns_ = 0;
  std::int64_t sync_ns_ = 0;
  bool synced_ = false;  // on one of the buses at least, at sync_ns_
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
  // Frames of targets, each at the place of the axis that leads it.
  std::array<std::size_t, kMaxJoints> leader_{};
  std::array<CanFrame, kMaxJoints> targets_{};
  std::array<bool, kMaxJoints> refused_{};  // to be sent again

  ArmFeedback feedback_;
  bool fresh_ = false;
};

// With its bus, or its two, as the controller wants an arm to be. They must outlive it; a second one that no
// axis is on is left alone.
template <CanBus Bus>
class CanopenArm {
 public:
  explicit CanopenArm(Bus& bus) : CanopenArm(bus, bus) {}
  CanopenArm(Bus& first, Bus& second) : buses_{&first, &second} {}

  // kBus as well, where axes are on a second bus and there is none.
  [[nodiscard]] ConfigResult init(const CanopenArmConfig& config, std::int64_t now_ns) {
    if (bus_count(config) > 1 && buses_[0] == buses_[1]) return {ConfigFinding::kBus, -1};
    return master_.init(config, now_ns);
  }
  // Once a period, before the others.
  void process(std::int64_t now_ns) {
    for (int bus = 0; bus < master_.buses(); ++bus) {
      Bus& its = *buses_[static_cast<std::size_t>(bus)];
      its.process(now_ns);
      CanFrame frame;
      for (int i = 0; i < kMostFrames && its.receive(frame); ++i) master_.receive(bus, frame, now_ns);
    }
    master_.process(now_ns, as_master_sees());
  }
  [[nodiscard]] bool read(ArmFeedback& feedback) { return master_.read(feedback); }
  void command(const std::array<double, kMaxJoints>& velocity_rad_per_s) {
    master_.command(velocity_rad_per_s, as_master_sees());
  }
  void request(ArmRequest request) { master_.request(request); }

  [[nodiscard]] const ArmMaster& master() const { return master_; }

 private:
  // More than a bus of 1 Mbit/s carries in the longest period, so that a flood cannot hold up the task, nor
  // that of one bus the other.
  static constexpr int kMostFrames = 600;

  [[nodiscard]] MasterBuses as_master_sees() const {
    return {MasterBus{FrameSink(*buses_[0]), &buses_[0]->health()},
            MasterBus{FrameSink(*buses_[1]), &buses_[1]->health()}};
  }

  std::array<Bus*, kMaxBuses> buses_;
  ArmMaster master_;
};

}  // namespace vergence::canopen
