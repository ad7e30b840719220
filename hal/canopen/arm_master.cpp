#include "hal/canopen/arm_master.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace vergence::canopen {

template <typename Predicate>
bool ArmMaster::all(Predicate predicate) const {
  return std::all_of(axes_.begin(), axes_.begin() + static_cast<std::ptrdiff_t>(count_), predicate);
}

ConfigResult ArmMaster::init(const CanopenArmConfig& config, std::int64_t now_ns) {
  *this = {};
  if (const ConfigResult result = check(config); result.finding != ConfigFinding::kNone) return result;
  config_ = config;
  count_ = static_cast<std::size_t>(config.axes);
  bus_count_ = static_cast<std::size_t>(bus_count(config));
  now_ns_ = now_ns;
  since_ns_ = now_ns;
  for (Line& line : lines_) line.heartbeat.init(config.master_node_id, config.heartbeat_ns);
  for (std::size_t i = 0; i < count_; ++i) {
    axes_[i].init(config, static_cast<int>(i), now_ns);
    leader_[i] = static_cast<std::size_t>(target_leader(config, static_cast<int>(i)));
  }
  return {};
}

void ArmMaster::receive(int bus, const CanFrame& frame, std::int64_t now_ns) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (bus_of(i) == static_cast<std::size_t>(bus)) axes_[i].receive(frame, now_ns);
  }
}

void ArmMaster::enter(State state) {
  state_ = state;
  since_ns_ = now_ns_;
}

void ArmMaster::stop(const ArmFaultRecord& fault) {
  if (state_ == State::kFault) return;
  fault_ = fault;
  stopped_ = false;
  resetting_ = false;
  may_enable_ = false;
  reset_wanted_ = false;
  velocity_rad_per_s_ = {};
  enter(State::kFault);
}

void ArmMaster::stop_whole(ArmFaultKind kind, std::uint32_t detail, std::size_t bus) {
  const bool is_one_of_two = bus < bus_count_ && bus_count_ > 1;
  const auto number = static_cast<std::int8_t>(bus);
  stop({now_ns_, kind, -1, 0, 0, detail, is_one_of_two ? number : std::int8_t{-1}});
}

void ArmMaster::judge_bus(std::size_t bus, const CanHealth& health) {
  if (health.state == BusState::kOff || health.state == BusState::kDown) {
    stop_whole(ArmFaultKind::kBusOff, static_cast<std::uint32_t>(health.state), bus);
  }
  Line& line = lines_[bus];
  bool any_refused = line.sync_refused || line.word_refused;
  for (std::size_t i = 0; i < count_; ++i) any_refused = any_refused || (refused_[i] && bus_of(i) == bus);
  line.periods_refused = any_refused ? line.periods_refused + 1 : 0;
  if (line.periods_refused >= 2) stop_whole(ArmFaultKind::kTransmitFull, 0, bus);
}

void ArmMaster::judge_buses(const MasterBuses& buses) {
  for (std::size_t bus = 0; bus < bus_count_; ++bus) judge_bus(bus, *buses[bus].health);
}

// While a reset is under way, a drive may still be in the fault it is reset from.
void ArmMaster::watch() {
  for (std::size_t i = 0; i < count_; ++i) {
    Axis& axis = axes_[i];
    if (!resetting_) axis.watch_drive(now_ns_);
    if (state_ == State::kOn) axis.watch_enabled(now_ns_);
  }
  if (state_ == State::kOn && periods_without_command_ > config_.most_missed_commands) {
    stop_whole(ArmFaultKind::kNoCommand, static_cast<std::uint32_t>(periods_without_command_));
  }
}

void ArmMaster::judge_axes() {
  for (std::size_t i = 0; i < count_; ++i) {
    if (axes_[i].fault().kind != ArmFaultKind::kNone) stop(axes_[i].fault());
  }
}

bool ArmMaster::has_stopped() const {
  if (now_ns_ - since_ns_ > config_.stop_timeout_ns) return true;
  return all([this](const Axis& axis) {
    if (axis.phase() != AxisPhase::kRunning) return true;
    const DriveState drive = axis.drive();
    return drive != DriveState::kOperationEnabled && drive != DriveState::kFaultReaction &&
           std::abs(axis.velocity_rad_per_s()) < config_.rest_rad_per_s;
  });
}

void ArmMaster::reset() {
  for (std::size_t i = 0; i < count_; ++i) {
    if (axes_[i].phase() == AxisPhase::kRunning) {
      axes_[i].clear_fault();
    } else {
      axes_[i].boot(now_ns_);
    }
  }
  resetting_ = true;
  enter(State::kBoot);
}

void ArmMaster::boot() {
  const auto is_waiting = [](const Axis& axis) {
    return axis.phase() == AxisPhase::kConfigured || axis.phase() == AxisPhase::kRunning;
  };
  if (all(is_waiting)) {
    for (std::size_t i = 0; i < count_; ++i) axes_[i].start(now_ns_);
  }
  const bool all_run = all([](const Axis& axis) { return axis.phase() == AxisPhase::kRunning; });
  if (!all_run) {
    since_ns_ = now_ns_;  // each phase of booting has its own timeout
    return;
  }
  const bool all_well = all([](const Axis& axis) { return !is_fault(axis.drive()); });
  if (all_well) {
    resetting_ = false;
    fault_ = {};
    enter(State::kOff);
  } else if (now_ns_ - since_ns_ > config_.enable_timeout_ns) {
    resetting_ = false;  // a fault that is still there is one
  }
}

void ArmMaster::advance_fault() {
  stopped_ = stopped_ || has_stopped();
  if (stopped_ && reset_wanted_) reset();
}

void ArmMaster::advance() {
  const bool enable = wanted_ == ArmRequest::kEnable && may_enable_;
  switch (state_) {
    case State::kBoot: boot(); break;
    case State::kOff:
      if (enable) enter(State::kEnabling);
      break;
    case State::kEnabling:
      if (!enable) {
        enter(State::kOff);
      } else if (all([](const Axis& axis) { return axis.drive() == DriveState::kOperationEnabled; })) {
        for (std::size_t i = 0; i < count_; ++i) axes_[i].expect_following();
        velocity_rad_per_s_ = {};
        periods_without_command_ = 0;
        enter(State::kOn);
      } else if (now_ns_ - since_ns_ > config_.enable_timeout_ns) {
        for (std::size_t i = 0; i < count_; ++i) {
          if (axes_[i].drive() == DriveState::kOperationEnabled) continue;
          axes_[i].fail(ArmFaultKind::kEnableTimeout, axes_[i].statusword(), now_ns_);
        }
        judge_axes();
      }
      break;
    case State::kOn:
      if (!enable) enter(State::kStopping);
      break;
    case State::kStopping:
      if (wanted_ != ArmRequest::kQuickStop && has_stopped()) enter(State::kOff);
      break;
    case State::kFault: advance_fault(); break;
  }
  reset_wanted_ = reset_wanted_ && state_ == State::kFault;
}

DriveGoal ArmMaster::goal() const {
  switch (state_) {
    case State::kBoot: return resetting_ ? DriveGoal::kReset : DriveGoal::kOff;
    case State::kOff: return DriveGoal::kOff;
    case State::kEnabling:
    case State::kOn: return DriveGoal::kOn;
    case State::kStopping: return DriveGoal::kQuickStop;
    case State::kFault:
      return stopped_ && wanted_ == ArmRequest::kDisable ? DriveGoal::kOff : DriveGoal::kQuickStop;
  }
  return DriveGoal::kQuickStop;
}

// An axis that failed is told to stop as well: it may still hear.
void ArmMaster::steer_all(const MasterBuses& buses) {
  for (Line& line : lines_) line.word_refused = false;
  for (std::size_t i = 0; i < count_; ++i) {
    if (axes_[i].phase() < AxisPhase::kAwaitStart) continue;
    const std::size_t bus = bus_of(i);
    if (!axes_[i].steer(goal(), buses[bus].sink)) lines_[bus].word_refused = true;
  }
}

// A frame goes out where one of its axes may hear it; a target of rest is in it for an axis that may not.
void ArmMaster::send_targets(const MasterBuses& buses) {
  std::array<bool, kMaxJoints> wanted{};
  for (std::size_t i = 0; i < count_; ++i) {
    const double velocity = state_ == State::kOn ? velocity_rad_per_s_[i] : 0;
    axes_[i].put_target(goal(), velocity, targets_[leader_[i]]);
    if (axes_[i].phase() >= AxisPhase::kAwaitStart) wanted[leader_[i]] = true;
  }
  for (std::size_t bus = 0; bus < bus_count_; ++bus) {
    std::array<CanFrame, kMaxJoints> frames{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (wanted[i] && bus_of(i) == bus) frames[count++] = targets_[i];
    }
    std::size_t taken = buses[bus].sink.send(std::span(frames).first(count));
    for (std::size_t i = 0; i < count_; ++i) {
      if (bus_of(i) != bus) continue;
      refused_[i] = wanted[i] && taken == 0;
      if (wanted[i] && taken > 0) --taken;
    }
  }
}

void ArmMaster::send_refused(const MasterBuses& buses) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (refused_[i]) refused_[i] = !buses[bus_of(i)].sink.send(targets_[i]);
  }
}

// On both buses one after the other, so that all drives sample together but for a frame's time.
void ArmMaster::send_sync(const MasterBuses& buses) {
  synced_ = false;
  for (std::size_t bus = 0; bus < bus_count_; ++bus) {
    Line& line = lines_[bus];
    line.sync_sent = buses[bus].sink.send(sync_frame());
    line.sync_refused = !line.sync_sent;
    synced_ = synced_ || line.sync_sent;
  }
  sync_ns_ = now_ns_;
}

void ArmMaster::publish() {
  if (state_ == State::kBoot && !resetting_) return;
  for (std::size_t i = 0; i < count_; ++i) {
    feedback_.position_rad[i] = axes_[i].position_rad();
    feedback_.velocity_rad_per_s[i] = axes_[i].velocity_rad_per_s();
  }
  feedback_.fault = fault_code(fault_);
  switch (state_) {
    case State::kOff: feedback_.state = ArmState::kDisabled; break;
    case State::kEnabling: feedback_.state = ArmState::kEnabling; break;
    case State::kOn: feedback_.state = ArmState::kEnabled; break;
    case State::kStopping: feedback_.state = ArmState::kQuickStop; break;
    case State::kBoot:
    case State::kFault: feedback_.state = ArmState::kFault; break;
  }
  fresh_ = true;
}

void ArmMaster::process(std::int64_t now_ns, const MasterBuses& buses) {
  too_soon_ = synced_ && now_ns - sync_ns_ < config_.sync_period_ns / 2;
  if (too_soon_) return;
  now_ns_ = now_ns;
  if (state_ == State::kOn) ++periods_without_command_;
  for (std::size_t i = 0; i < count_; ++i) axes_[i].process(now_ns, buses[bus_of(i)].sink);
  bool all_synced = true;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool was_synced = lines_[bus_of(i)].sync_sent;
    if (was_synced) axes_[i].sample(now_ns, sync_ns_, is_stopping());
    all_synced = all_synced && was_synced;
  }
  if (all_synced) feedback_.stamp_ns = sync_ns_;
  judge_buses(buses);  // first: without a bus every drive is missing
  watch();
  judge_axes();
  advance();

  if (is_stopping()) {
    steer_all(buses);
  } else {
    send_refused(buses);
  }
  send_sync(buses);
  if (!is_stopping()) steer_all(buses);
  if (state_ != State::kOn) send_targets(buses);
  for (std::size_t bus = 0; bus < bus_count_; ++bus) {
    lines_[bus].heartbeat.process(now_ns, NmtState::kOperational, buses[bus].sink);
  }
  publish();
}

bool ArmMaster::read(ArmFeedback& feedback) {
  if (!fresh_) return false;
  fresh_ = false;
  feedback = feedback_;
  return true;
}

void ArmMaster::command(const std::array<double, kMaxJoints>& velocity_rad_per_s, const MasterBuses& buses) {
  periods_without_command_ = 0;
  if (state_ != State::kOn || too_soon_) return;
  velocity_rad_per_s_ = velocity_rad_per_s;
  send_targets(buses);
}

void ArmMaster::request(ArmRequest request) {
  if (request == ArmRequest::kResetFault) {
    reset_wanted_ = true;
    return;
  }
  wanted_ = request;
  if (request != ArmRequest::kEnable) may_enable_ = true;
}

}  // namespace vergence::canopen
