#include "hal/canopen/simulated_drive.hpp"

#include <algorithm>
#include <cmath>

#include "hal/canopen/bytes.hpp"
#include "hal/canopen/objects.hpp"
#include "hal/canopen/pdo.hpp"
#include "hal/clock.hpp"

namespace vergence::canopen {
namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;

double to_signed(std::uint32_t value) {
  return static_cast<std::int32_t>(value);
}

// Of PDO number 1, object `first`; pdo counts from 0.
std::uint16_t of_pdo(std::uint16_t first, std::size_t pdo) {
  return static_cast<std::uint16_t>(first + pdo);
}

bool is_on_event(std::uint32_t transmission) {
  return transmission >= 254;
}

// Counts go round, as they do in a drive.
std::uint32_t to_counts(double value) {
  return static_cast<std::uint32_t>(std::llround(value));
}

}  // namespace

void SimulatedDrive::init(const SimulatedDriveOptions& options, std::int64_t now_ns) {
  *this = {};
  options_ = options;
  now_ns_ = now_ns;
  position_ = options.start_counts;
  objects_.init(options.node_id, options.vendor_id);
  sdo_.init(options.node_id);
}

void SimulatedDrive::set_power(bool is_on) {
  powered_ = is_on;
  restart();
}

void SimulatedDrive::restart() {
  state_ = DriveState::kNotReady;
  controlword_ = 0;
  boots_ = true;
}

void SimulatedDrive::reset_communication() {
  objects_.reset();
  sdo_.init(options_.node_id);
  heartbeat_.init(options_.node_id, 0);
  nmt_ = NmtState::kPreOperational;
  answer_due_ = false;
  feedbacks_ = {};
  commands_ = {};
  emergencies_.clear();
  master_seen_ = false;
  sync_seen_ = false;
  boots_ = true;
}

void SimulatedDrive::obey_nmt(NmtCommand command) {
  switch (command) {
    case NmtCommand::kStart:
      nmt_ = NmtState::kOperational;
      feedbacks_ = {};
      break;
    case NmtCommand::kEnterPreOperational: nmt_ = NmtState::kPreOperational; break;
    case NmtCommand::kStop:
      nmt_ = NmtState::kStopped;
      lose_connection(kEmergencyHeartbeat);
      break;
    case NmtCommand::kResetNode:
      state_ = DriveState::kNotReady;
      controlword_ = 0;
      reset_communication();
      break;
    case NmtCommand::kResetCommunication:
      if (state_ == DriveState::kOperationEnabled) state_ = DriveState::kQuickStopActive;
      reset_communication();
      break;
  }
  sync_seen_ = false;
}

void SimulatedDrive::queue_emergency(std::uint16_t code) {
  Emergency emergency;
  emergency.code = code;
  emergency.error_register = 0x01;
  emergencies_.add(emergency);
}

void SimulatedDrive::fail(std::uint16_t code) {
  queue_emergency(code);
  objects_.set(kErrorRegister, 0, 0x01);
  if (state_ != DriveState::kFault) state_ = DriveState::kFaultReaction;
}

// What the drive does by itself when it is left alone, by object 0x6007.
void SimulatedDrive::lose_connection(std::uint16_t code) {
  switch (objects_.number(kAbortConnectionOption, 0)) {
    case 1: return fail(code);
    case 2: obey(controlword(DriveCommand::kDisableVoltage)); break;
    case 3: state_ = next_state(state_, DriveCommand::kQuickStop); break;
    default: return;
  }
  queue_emergency(code);
}

void SimulatedDrive::supervise(std::int64_t now_ns) {
  const std::uint32_t consumer = objects_.number(kHeartbeatConsumer, 1);
  const std::int64_t timeout_ns = std::int64_t{consumer & 0xFFFF} * kNsPerMs;
  if (master_seen_ && timeout_ns != 0 && now_ns - master_ns_ > timeout_ns) {
    master_seen_ = false;  // until it is heard again
    lose_connection(kEmergencyHeartbeat);
  }
  const std::int64_t period_ns = std::int64_t{objects_.number(kCyclePeriod, 0)} * 1000;
  if (sync_seen_ && period_ns != 0 && nmt_ == NmtState::kOperational &&
      2 * (now_ns - sync_ns_) > 3 * period_ns) {
    sync_seen_ = false;
    lose_connection(kEmergencySync);
  }
}

void SimulatedDrive::obey(std::uint16_t controlword) {
  const DriveCommand command = decode_command(controlword, controlword_);
  controlword_ = controlword;
  // A single word may switch on and enable at once.
  if (state_ == DriveState::kReadyToSwitchOn && command == DriveCommand::kEnableOperation) {
    state_ = DriveState::kSwitchedOn;
  }
  state_ = next_state(state_, command);
  if (command == DriveCommand::kFaultReset) objects_.set(kErrorRegister, 0, 0);
}

std::uint16_t SimulatedDrive::statusword() const {
  if (shown_) return *shown_;
  std::uint16_t word = state_bits(state_) | kStatusRemote;
  if (state_ != DriveState::kNotReady) word |= kStatusVoltage;
  const std::uint32_t mode = objects_.number(kModeDisplay, 0);
  if (mode == kModeHoming) word |= options_.is_homed ? 0x1400 : 0x0400;
  if (mode == kModeCyclicVelocity || mode == kModeCyclicPosition) {
    if (state_ == DriveState::kOperationEnabled) word |= kStatusFollows;
    if (following_error_) word |= kStatusFollowingError;
  }
  return word;
}

void SimulatedDrive::refresh() {
  objects_.set(kStatusword, 0, statusword());
  objects_.set(kPositionActual, 0, to_counts(position_));
  objects_.set(kVelocityActual, 0, to_counts(velocity_ / options_.counts_per_velocity_unit));
}

void SimulatedDrive::on_written(std::uint16_t index) {
  if (index == kModeOfOperation) objects_.set(kModeDisplay, 0, objects_.number(kModeOfOperation, 0));
  if (index == kControlword) obey(static_cast<std::uint16_t>(objects_.number(kControlword, 0)));
  if (index == kHeartbeatProducer) {
    heartbeat_.init(options_.node_id, std::int64_t{objects_.number(kHeartbeatProducer, 0)} * kNsPerMs);
  }
}

std::size_t SimulatedDrive::mapped_bytes(std::uint16_t mapping) const {
  std::size_t bits = 0;
  const std::uint32_t entries = objects_.number(mapping, 0);
  for (std::uint32_t i = 1; i <= entries; ++i) {
    bits += objects_.number(mapping, static_cast<std::uint8_t>(i)) & 0xFF;
  }
  return bits / 8;
}

void SimulatedDrive::take_pdos(const CanFrame& frame) {
  if (nmt_ != NmtState::kOperational) return;
  for (std::size_t pdo = 0; pdo < commands_.size(); ++pdo) {
    const std::uint16_t communication = of_pdo(kRpdoCommunication, pdo);
    if (objects_.number(communication, 1) != frame.id) continue;
    if (frame.size < mapped_bytes(of_pdo(kRpdoMapping, pdo))) return queue_emergency(0x8210);
    commands_[pdo] = {frame, true};
    if (is_on_event(objects_.number(communication, 2))) apply_pdo(pdo);
  }
}

void SimulatedDrive::apply_pdo(std::size_t pdo) {
  Command& command = commands_[pdo];
  if (!command.is_here) return;
  command.is_here = false;
  const std::uint16_t mapping = of_pdo(kRpdoMapping, pdo);
  std::size_t at = 0;
  const std::uint32_t entries = objects_.number(mapping, 0);
  for (std::uint32_t i = 1; i <= entries; ++i) {
    const std::uint32_t entry = objects_.number(mapping, static_cast<std::uint8_t>(i));
    const std::size_t bytes = (entry & 0xFF) / 8;
    if (at + bytes > command.frame.payload().size()) return;
    const auto index = static_cast<std::uint16_t>(entry >> 16);
    objects_.set(index, static_cast<std::uint8_t>(entry >> 8),
                 get_number(command.frame.payload().subspan(at), bytes));
    at += bytes;
    on_written(index);
  }
}

bool SimulatedDrive::pdo_frame(std::size_t pdo, CanFrame& frame) {
  const std::uint32_t cob_id = objects_.number(of_pdo(kTpdoCommunication, pdo), 1);
  if (!pdo_on_ || (cob_id & kPdoOff) != 0) return false;
  refresh();
  frame = {};
  frame.id = cob_id & 0x7FF;
  const std::uint16_t mapping = of_pdo(kTpdoMapping, pdo);
  const std::uint32_t entries = objects_.number(mapping, 0);
  for (std::uint32_t i = 1; i <= entries; ++i) {
    const std::uint32_t entry = objects_.number(mapping, static_cast<std::uint8_t>(i));
    const std::size_t bytes = (entry & 0xFF) / 8;
    if (frame.size + bytes > frame.data.size()) return false;
    const std::uint32_t value =
        objects_.number(static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8));
    put_number(std::span(frame.data).subspan(frame.size), bytes, value);
    frame.size = static_cast<std::uint8_t>(frame.size + bytes);
  }
  return true;
}

void SimulatedDrive::on_sync(std::int64_t now_ns) {
  if (nmt_ != NmtState::kOperational) return;
  sync_seen_ = true;
  sync_ns_ = now_ns;
  for (std::size_t pdo = 0; pdo < commands_.size(); ++pdo) apply_pdo(pdo);
  for (std::size_t pdo = 0; pdo < feedbacks_.size(); ++pdo) {
    if (objects_.number(of_pdo(kTpdoCommunication, pdo), 2) != kEverySync) continue;
    feedbacks_[pdo].is_due = pdo_frame(pdo, feedbacks_[pdo].frame);
  }
}

// Sent once the node is started, as what it holds changes, and when the event timer says so; never before the
// inhibit time is over.
void SimulatedDrive::note_event(std::size_t pdo, std::int64_t now_ns) {
  const std::uint16_t communication = of_pdo(kTpdoCommunication, pdo);
  CanFrame frame;
  if (!is_on_event(objects_.number(communication, 2)) || !pdo_frame(pdo, frame)) return;
  Feedback& feedback = feedbacks_[pdo];
  const std::int64_t since_ns = now_ns - feedback.sent_ns;
  const std::int64_t inhibit_ns =
      std::int64_t{objects_.number(communication, kPdoInhibitSub)} * kNsPerMs / 10;
  const std::int64_t timer_ns = std::int64_t{objects_.number(communication, kPdoTimerSub)} * kNsPerMs;
  if (feedback.was_sent) {
    const bool has_changed = feedback.frame.size != frame.size || feedback.frame.data != frame.data;
    if (since_ns < inhibit_ns || (!has_changed && (timer_ns == 0 || since_ns < timer_ns))) return;
  }
  feedback.frame = frame;
  feedback.is_due = true;
}

void SimulatedDrive::send_pdos(std::int64_t now_ns, const FrameSink& sink) {
  for (std::size_t pdo = 0; pdo < feedbacks_.size(); ++pdo) {
    if (nmt_ == NmtState::kOperational) note_event(pdo, now_ns);
    Feedback& feedback = feedbacks_[pdo];
    if (!feedback.is_due || !sink.send(feedback.frame)) continue;
    feedback.is_due = false;
    feedback.was_sent = true;
    feedback.sent_ns = now_ns;
  }
}

void SimulatedDrive::receive(const CanFrame& frame, std::int64_t now_ns) {
  if (!powered_ || frame.is_remote || frame.is_error) return;
  move(now_ns);
  if (frame.id == kNmtCobId && frame.size == 2) {
    if (frame.data[1] == 0 || frame.data[1] == options_.node_id) {
      obey_nmt(static_cast<NmtCommand>(frame.data[0]));
    }
    return;
  }
  if (frame.id == kSyncCobId) return on_sync(now_ns);
  const std::uint32_t consumer = objects_.number(kHeartbeatConsumer, 1);
  if (frame.id == kHeartbeatCobId + ((consumer >> 16) & 0x7F) && (consumer & 0xFFFF) != 0) {
    master_seen_ = true;
    master_ns_ = now_ns;
    return;
  }
  take_pdos(frame);
  if (nmt_ == NmtState::kStopped) return;
  refresh();
  std::uint16_t written = 0;
  if (sdo_.receive(frame, objects_, answer_, written)) answer_due_ = true;
  if (written != 0) on_written(written);
}

void SimulatedDrive::process(std::int64_t now_ns, const FrameSink& sink) {
  move(now_ns);
  if (!powered_) return;
  if (boots_) {
    reset_communication();
    if (!sink.send(heartbeat_frame(options_.node_id, NmtState::kBootUp))) return;
    boots_ = false;
    if (state_ == DriveState::kNotReady) state_ = DriveState::kSwitchOnDisabled;
  }
  supervise(now_ns);
  while (!emergencies_.empty()) {
    if (!sink.send(emergency_frame(options_.node_id, emergencies_[0]))) return;
    emergencies_.drop_first();
  }
  send_pdos(now_ns, sink);
  if (answer_due_ && sink.send(answer_)) answer_due_ = false;
  if (heartbeat_on_) heartbeat_.process(now_ns, nmt_, sink);
}

double SimulatedDrive::wanted_counts_per_s() const {
  return to_signed(objects_.number(kTargetVelocity, 0)) * options_.counts_per_velocity_unit;
}

double SimulatedDrive::quick_stop_counts_per_s2() const {
  return static_cast<double>(objects_.number(kQuickStopDeceleration, 0)) * options_.counts_per_velocity_unit;
}

void SimulatedDrive::set_motion(double position_counts, double velocity_counts_per_s) {
  position_ = position_counts;
  velocity_ = velocity_counts_per_s;
  if (velocity_ == 0) leave_braking();
}

void SimulatedDrive::follow(double dt_s) {
  if (jammed_) {
    velocity_ = 0;
  } else if (objects_.number(kModeDisplay, 0) == kModeCyclicPosition) {
    const double way = to_signed(objects_.number(kTargetPosition, 0)) - position_;
    velocity_ = way / (options_.time_constant_s + dt_s);
  } else {
    velocity_ += (wanted_counts_per_s() - velocity_) * dt_s / (options_.time_constant_s + dt_s);
  }
  following_error_ = false;
  if (objects_.number(kModeDisplay, 0) != kModeCyclicPosition) return;
  const double behind = std::abs(to_signed(objects_.number(kTargetPosition, 0)) - position_);
  following_error_ = behind > static_cast<double>(objects_.number(kFollowingErrorWindow, 0));
  behind_s_ = following_error_ ? behind_s_ + dt_s : 0;
  if (behind_s_ * 1000 > static_cast<double>(objects_.number(kFollowingErrorTime, 0))) {
    behind_s_ = 0;
    fail(kEmergencyFollowingError);
  }
}

void SimulatedDrive::brake(double dt_s) {
  const double step = quick_stop_counts_per_s2() * dt_s;
  velocity_ -= std::clamp(velocity_, -step, step);
  if (velocity_ == 0) leave_braking();
}

void SimulatedDrive::leave_braking() {
  if (state_ == DriveState::kFaultReaction) state_ = DriveState::kFault;
  const bool leaves = objects_.number(kQuickStopOption, 0) < 5;
  if (state_ == DriveState::kQuickStopActive && leaves) state_ = DriveState::kSwitchOnDisabled;
}

void SimulatedDrive::move(std::int64_t now_ns) {
  const double dt_s = seconds(now_ns - now_ns_);
  if (!(dt_s > 0)) return;
  now_ns_ = now_ns;
  if (!options_.has_motor) return;
  switch (state_) {
    case DriveState::kOperationEnabled: follow(dt_s); break;
    case DriveState::kQuickStopActive:
    case DriveState::kFaultReaction: brake(dt_s); break;
    default: velocity_ = 0;  // the mechanical brake
  }
  position_ += velocity_ * dt_s;
}

}  // namespace vergence::canopen
