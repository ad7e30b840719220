#include "hal/canopen/axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/objects.hpp"
#include "hal/clock.hpp"

namespace vergence::canopen {
namespace {

// Of the memory of a velocity that is not followed: a steady difference d counts as d times this.
constexpr double kSlipMemory_s = 1;

constexpr std::int64_t kNsPerMs = 1'000'000;

// A controlword that is not followed is sent again after so many periods: brakes take their time.
constexpr int kRepeatAfter_periods = 10;

// So many event timers in a row without a statusword, in halves, are a fault: one may be lost.
constexpr int kMostHalfTimers = 5;

std::uint32_t to_object(double value) {
  const double clamped = std::clamp(value, -2147483648.0, 2147483647.0);
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(clamped)));
}

}  // namespace

void Axis::init(const CanopenArmConfig& config, int axis, std::int64_t now_ns) {
  *this = {};
  config_ = config.axis[static_cast<std::size_t>(axis)];
  mode_ = config.mode;
  must_be_homed_ = config.must_be_homed;
  number_ = axis;
  period_s_ = seconds(config.sync_period_ns);
  boot_timeout_ns_ = config.boot_timeout_ns;
  sdo_timeout_ns_ = config.sdo_timeout_ns;
  tolerated_missing_ = config.tolerated_missing_pdos;
  statusword_timer_ns_ = config.statusword_timer_ns;
  pdos_ = axis_pdos(config, axis);
  target_offset_ = target_offset(config, axis);
  script_ = boot_script(config, axis);
  sdo_.init(config_.node_id, config.sdo_timeout_ns);
  heartbeat_.init(config_.node_id, config.heartbeat_timeout_ns, config.boot_timeout_ns);
  boot(now_ns);
}

void Axis::boot(std::int64_t now_ns) {
  phase_ = AxisPhase::kReset;
  since_ns_ = now_ns;
  step_ = 0;
  step_begun_ = false;
  boots_ = 1;
  left_out_ = 0;
  homing_ = HomingState::kUnknown;
  heartbeat_.await_boot(now_ns);
  emergency_ = {};
  fault_ = {};
  statusword_ = 0;
  statusword_known_ = false;
  has_statusword_timer_ = true;
  asking_ = false;
  arrived_ = false;
  missing_ = 0;
  sampled_ = false;
  velocity_rad_per_s_ = 0;
  last_command_ = DriveCommand::kNone;
  told_ = false;
}

void Axis::start(std::int64_t now_ns) {
  if (phase_ != AxisPhase::kConfigured) return;
  phase_ = AxisPhase::kStart;
  since_ns_ = now_ns;
}

void Axis::fail(ArmFaultKind kind, std::uint32_t detail, std::int64_t now_ns) {
  if (fault_.kind != ArmFaultKind::kNone) return;
  fault_ = {now_ns, kind, static_cast<std::int8_t>(number_), 0, 0, detail};
}

void Axis::fail_step(ArmFaultKind kind, std::uint32_t detail, std::int64_t now_ns) {
  if (fault_.kind != ArmFaultKind::kNone) return;
  fail(kind, detail, now_ns);
  fault_.index = script_[step_].object.index;
  fault_.sub = script_[step_].object.sub;
}

void Axis::take_statusword(std::uint32_t value, std::int64_t now_ns) {
  statusword_ = static_cast<std::uint16_t>(value);
  statusword_known_ = true;
  statusword_ns_ = now_ns;
}

// Frames that have not the length that was mapped are not ours.
void Axis::receive_feedback(const CanFrame& frame, std::int64_t now_ns) {
  if (frame.is_remote) return;
  if (frame.id == pdos_.position.cob_id && frame.size == pdo_bytes(pdos_.position)) {
    counts_ = static_cast<std::int32_t>(get_number(frame.data, 4));
    arrived_ns_ = frame.stamp_ns;
    arrived_ = true;
  }
  if (frame.id == pdos_.statusword.cob_id && frame.size == pdo_bytes(pdos_.statusword)) {
    take_statusword(get_number(frame.data, 2), now_ns);
  }
}

void Axis::receive(const CanFrame& frame, std::int64_t now_ns) {
  if (frame.is_error) return;
  heartbeat_.receive(frame, now_ns);
  // What it sent before it was reset says nothing about now.
  if (phase_ == AxisPhase::kReset || phase_ == AxisPhase::kAwaitBoot) return;
  sdo_.receive(frame, now_ns);
  if (phase_ >= AxisPhase::kAwaitStart) receive_feedback(frame, now_ns);
  if (Emergency emergency; decode_emergency(frame, config_.node_id, emergency)) {
    emergency_ = emergency;
    if (emergency.code >= 0x0100) fail(ArmFaultKind::kEmergency, emergency.code, now_ns);
  }
}

void Axis::begin_step(std::int64_t now_ns) {
  const BootStep& step = script_[step_];
  const SdoWrite& object = step.object;
  if (step.kind == BootStepKind::kWrite || step.kind == BootStepKind::kWriteIfThere) {
    std::array<std::uint8_t, 4> bytes{};
    put_number(bytes, object.size, object.value);
    step_begun_ = sdo_.write(object.index, object.sub, std::span(bytes).first(object.size), now_ns);
  } else {
    step_begun_ = sdo_.read(object.index, object.sub, now_ns);
  }
}

// True where the script may go on.
bool Axis::end_step(std::int64_t now_ns) {
  const BootStep& step = script_[step_];
  if (sdo_.state() == SdoState::kAborted) {
    const std::uint32_t code = sdo_.abort_code();
    const bool not_there = code == kAbortNoObject || code == kAbortNoSubIndex;
    if (step.kind == BootStepKind::kWriteIfThere && not_there) {
      ++left_out_;
      if (is_statusword_timer(step)) has_statusword_timer_ = false;
      return true;
    }
    fail_step(ArmFaultKind::kSdoAbort, code, now_ns);
    return false;
  }
  const std::uint32_t value = get_number(sdo_.bytes(), sdo_.bytes().size());
  if (step.kind == BootStepKind::kExpect && (value & step.mask) != (step.object.value & step.mask)) {
    fail_step(ArmFaultKind::kWrongValue, value, now_ns);
    return false;
  }
  if (step.kind == BootStepKind::kReadHoming) {
    homing_ = decode_homing(static_cast<std::uint16_t>(value));
    if (must_be_homed_ && homing_ != HomingState::kDone) {
      fail_step(ArmFaultKind::kNotHomed, static_cast<std::uint32_t>(homing_), now_ns);
      return false;
    }
  }
  return true;
}

void Axis::configure(std::int64_t now_ns, const FrameSink& sink) {
  if (step_begun_ && sdo_.state() != SdoState::kBusy) {
    step_begun_ = false;
    if (!end_step(now_ns)) return;
    ++step_;
  }
  if (step_ == script_.size()) {
    phase_ = AxisPhase::kConfigured;
    return;
  }
  if (!step_begun_) begin_step(now_ns);
  sdo_.process(now_ns, sink);
}

// A drive that was just switched on boots by itself, then once more because it is told to: that is no fault,
// but what it was told in between is forgotten.
void Axis::judge_boots(std::int64_t now_ns) {
  if (heartbeat_.boots() <= boots_) return;
  if (phase_ != AxisPhase::kConfigure || boots_ > 1) return fail(ArmFaultKind::kRebooted, 0, now_ns);
  boots_ = heartbeat_.boots();
  sdo_.init(config_.node_id, sdo_timeout_ns_);
  step_ = 0;
  step_begun_ = false;
  has_statusword_timer_ = true;
}

// Of a drive without the event timer, so that a change that was lost shows all the same.
void Axis::ask_for_statusword(std::int64_t now_ns, const FrameSink& sink) {
  if (has_statusword_timer_) return;
  if (asking_ && sdo_.state() != SdoState::kBusy) {
    asking_ = false;
    // What came by itself meanwhile is newer.
    const bool is_news = !statusword_known_ || statusword_ns_ < asked_ns_;
    if (sdo_.state() == SdoState::kDone && sdo_.bytes().size() == 2 && is_news) {
      take_statusword(get_number(sdo_.bytes(), 2), now_ns);
    }
  }
  const std::int64_t since_ns = std::max(statusword_known_ ? statusword_ns_ : since_ns_, asked_ns_);
  if (!asking_ && now_ns - since_ns >= statusword_timer_ns_) {
    asking_ = sdo_.read(kStatusword, 0, now_ns);
    asked_ns_ = now_ns;
  }
  sdo_.process(now_ns, sink);
}

void Axis::process(std::int64_t now_ns, const FrameSink& sink) {
  heartbeat_.process(now_ns);
  if (phase_ > AxisPhase::kAwaitBoot && phase_ != AxisPhase::kFailed) {
    if (heartbeat_.life() == NodeLife::kLost) fail(ArmFaultKind::kHeartbeatLost, 0, now_ns);
    judge_boots(now_ns);
  }
  switch (phase_) {
    case AxisPhase::kReset:
      if (!sink.send(nmt_command(NmtCommand::kResetCommunication, config_.node_id))) break;
      phase_ = AxisPhase::kAwaitBoot;
      sdo_.init(config_.node_id, sdo_timeout_ns_);
      heartbeat_.await_boot(now_ns);
      break;
    case AxisPhase::kAwaitBoot:
      if (heartbeat_.life() == NodeLife::kNeverBooted) fail(ArmFaultKind::kNeverBooted, 0, now_ns);
      if (heartbeat_.life() == NodeLife::kBooted) phase_ = AxisPhase::kConfigure;
      break;
    case AxisPhase::kConfigure: configure(now_ns, sink); break;
    case AxisPhase::kStart:
      if (!sink.send(nmt_command(NmtCommand::kStart, config_.node_id))) break;
      phase_ = AxisPhase::kAwaitStart;
      since_ns_ = now_ns;
      break;
    case AxisPhase::kAwaitStart:
      ask_for_statusword(now_ns, sink);
      if (arrived_ && statusword_known_ && heartbeat_.state() == NmtState::kOperational) {
        phase_ = AxisPhase::kRunning;
      } else if (now_ns - since_ns_ > boot_timeout_ns_) {
        fail(ArmFaultKind::kNotOperational, static_cast<std::uint32_t>(heartbeat_.state()), now_ns);
      }
      break;
    case AxisPhase::kRunning:
      ask_for_statusword(now_ns, sink);
      if (const std::int64_t age_ns = now_ns - statusword_ns_;
          2 * age_ns > kMostHalfTimers * statusword_timer_ns_) {
        fail(ArmFaultKind::kStatusMissing, static_cast<std::uint32_t>(age_ns / kNsPerMs), now_ns);
      }
      if (heartbeat_.state() != NmtState::kOperational) {
        fail(ArmFaultKind::kLeftOperational, static_cast<std::uint32_t>(heartbeat_.state()), now_ns);
      }
      break;
    case AxisPhase::kConfigured:
    case AxisPhase::kFailed: break;
  }
  // What only concerns the drive leaves its communication as it is; else it must be booted again.
  const bool drive_only = fault_.kind == ArmFaultKind::kNone ||
                          (phase_ == AxisPhase::kRunning && (fault_.kind == ArmFaultKind::kEmergency ||
                                                             fault_.kind >= ArmFaultKind::kFollowingError));
  if (!drive_only) phase_ = AxisPhase::kFailed;
}

void Axis::sample(std::int64_t now_ns, std::int64_t sync_ns, bool is_stopping) {
  if (phase_ != AxisPhase::kRunning) return;
  if (!arrived_) {
    if (++missing_ > std::max(tolerated_missing_, is_stopping ? 1 : 0)) {
      fail(ArmFaultKind::kPdoMissing, static_cast<std::uint32_t>(missing_), now_ns);
      phase_ = AxisPhase::kFailed;
    }
    return;
  }
  missing_ = 0;
  arrived_ = false;
  if (arrived_ns_ != 0) response_ns_ = arrived_ns_ - sync_ns;
  const double dt_s = seconds(sync_ns - sampled_ns_);
  if (sampled_ && dt_s > 0) {
    const std::int64_t moved = std::int64_t{counts_} - sampled_counts_;
    velocity_rad_per_s_ = static_cast<double>(moved) / config_.counts_per_rad / dt_s;
    follow(dt_s);
  }
  position_rad_ = static_cast<double>(std::int64_t{counts_} - config_.zero_counts) / config_.counts_per_rad;
  sampled_ = true;
  sampled_counts_ = counts_;
  sampled_ns_ = sync_ns;
}

void Axis::follow(double dt_s) {
  slip_rad_ += (commanded_rad_per_s_ - velocity_rad_per_s_) * dt_s;
  slip_rad_ *= kSlipMemory_s / (kSlipMemory_s + dt_s);
}

void Axis::expect_following() {
  slip_rad_ = 0;
  target_rad_ = position_rad_;
}

double Axis::allowed_velocity(double velocity_rad_per_s) const {
  if (!std::isfinite(velocity_rad_per_s)) return 0;
  if (velocity_rad_per_s > 0 && position_rad_ >= config_.max_rad) return 0;
  if (velocity_rad_per_s < 0 && position_rad_ <= config_.min_rad) return 0;
  return std::clamp(velocity_rad_per_s, -config_.max_velocity_rad_per_s, config_.max_velocity_rad_per_s);
}

void Axis::put_target(DriveGoal goal, double velocity_rad_per_s, CanFrame& frame) {
  const bool moves = goal == DriveGoal::kOn && drive() == DriveState::kOperationEnabled;
  commanded_rad_per_s_ = moves ? allowed_velocity(velocity_rad_per_s) : 0;
  // Until it moves the target is where it stands, so that nothing jumps when it does.
  target_rad_ = moves ? target_rad_ + commanded_rad_per_s_ * period_s_ : position_rad_;
  const double target = mode_ == CyclicMode::kVelocity
                            ? commanded_rad_per_s_ * config_.velocity_units_per_rad_per_s
                            : target_rad_ * config_.counts_per_rad + config_.zero_counts;
  frame.id = pdos_.target.cob_id;
  frame.size = static_cast<std::uint8_t>(pdo_bytes(pdos_.target));
  put_number(std::span(frame.data).subspan(target_offset_), kTargetBytes, to_object(target));
}

// The drive is where the command leads, or where it leads nowhere.
bool Axis::has_followed(DriveCommand command) const {
  return statusword_known_ && drive() != DriveState::kUnknown && next_state(drive(), command) == drive();
}

bool Axis::steer(DriveGoal goal, const FrameSink& sink) {
  const DriveCommand command = command_towards(goal, drive(), last_command_);
  const bool is_news = !told_ || command != last_command_;
  const int patience = goal == DriveGoal::kQuickStop ? 1 : kRepeatAfter_periods;
  ++periods_since_told_;
  if (!is_news && (has_followed(command) || periods_since_told_ < patience)) return true;
  CanFrame frame;
  frame.id = pdos_.controlword.cob_id;
  frame.size = static_cast<std::uint8_t>(pdo_bytes(pdos_.controlword));
  put_number(frame.data, frame.size, controlword(command));
  if (!sink.send(frame)) return false;
  last_command_ = command;
  // Before it runs it may not have heard.
  told_ = phase_ == AxisPhase::kRunning || phase_ == AxisPhase::kFailed;
  periods_since_told_ = 0;
  return true;
}

void Axis::watch_drive(std::int64_t now_ns) {
  if (phase_ != AxisPhase::kRunning || !is_fault(drive())) return;
  const bool has_meaning = drive() != DriveState::kUnknown;
  fail(has_meaning ? ArmFaultKind::kDriveFault : ArmFaultKind::kBadStatusword, statusword_, now_ns);
}

void Axis::watch_enabled(std::int64_t now_ns) {
  if (phase_ != AxisPhase::kRunning) return;
  if (drive() != DriveState::kOperationEnabled) fail(ArmFaultKind::kLeftEnabled, statusword_, now_ns);
  if (mode_ == CyclicMode::kPosition && (statusword_ & kStatusFollowingError) != 0) {
    fail(ArmFaultKind::kFollowingError, 0, now_ns);
  }
  const double behind = mode_ == CyclicMode::kPosition ? target_rad_ - position_rad_ : slip_rad_;
  if (std::abs(behind) > config_.following_error_rad) {
    const double microradians = std::min(std::abs(behind) * 1e6, 4e9);
    fail(ArmFaultKind::kFollowingError, static_cast<std::uint32_t>(microradians), now_ns);
  }
}

}  // namespace vergence::canopen
