#include "tools/rig/plant_loop.hpp"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "algo/pa10.hpp"
#include "hal/clock.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "tools/demo/closed_loop.hpp"
#include "tools/render/random.hpp"
#include "tools/rig/rig_devices.hpp"
#include "tools/rig/rig_error.hpp"

namespace vergence::rig {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr int kDrivePriority = 95;  // above all of the controller's
constexpr std::int64_t kTicksARow = 10;
constexpr std::int64_t kTicksToTrace = 5;
constexpr std::int64_t kTicksToRhythm = 1000;
constexpr double kCameraPeriods_per_s = 60;
constexpr std::size_t kAims = 10;               // rows: the target's drift is taken over a tenth of a second
constexpr std::uint16_t kMeaningless = 0x0002;  // a statusword of no state

std::int64_t monotonic_ns() {
  return rt::MonotonicClock().now_ns();
}

// Time enough to open the devices, and on a whole second: whatever came before, what follows is the same with
// respect to all of the kernel's ticks.
std::int64_t next_start_ns() {
  constexpr std::int64_t kOpening_ns = kNsPerSecond / 2;
  return ((monotonic_ns() + kOpening_ns) / kNsPerSecond + 1) * kNsPerSecond;
}

void sleep_until(std::int64_t t_ns) {
  const timespec until{t_ns / kNsPerSecond, t_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

JointVector start_of(const SerialArm& arm, const Transform& T_W_S) {
  const Pa10Inverse inverse = inverse_pa10(arm, T_W_S, JointVector::Zero());
  const auto start = nearest_solution(arm, inverse, JointVector::Zero());
  if (!start) throw std::runtime_error("the arm cannot reach its start");
  return *start;
}

Transform start_pose(const RigScenario& scenario) {
  return scenario.over_pool ? demo::pool_start() : demo::lateral_start();
}

render::Scene scene_of(const RigScenario& scenario, const ControllerConfig& config) {
  render::Scene scene = render::load_scene(scenario.scene);
  if (scene.rig.left.width_px != kWidth_px || scene.rig.left.height_px != kHeight_px ||
      config.robot.rig.left.width_px != kWidth_px) {
    throw std::runtime_error("the rig's cameras have 640x480 pixels");
  }
  for (const FaultEvent& fault : scenario.faults) {
    if (fault.kind != FaultKind::kTargetAbsent) continue;
    scene.target.hidden_s.push_back(
        {fault.at_s, fault.for_s > 0 ? fault.at_s + fault.for_s : scenario.duration_s + 1});
  }
  return scene;
}

Transform transform_of(const PoseRecord& record) {
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    pose.position_mm[i] = record.position_mm[static_cast<std::size_t>(i)];
    pose.e[i] = record.e[static_cast<std::size_t>(i)];
  }
  return to_transform(pose);
}

std::int64_t idle_ns(const RigScenario& scenario) {
  return std::llround(1e9 / scenario.frames_per_s);
}

int minor_of(const char* device) {
  struct stat about {};
  if (stat(device, &about) != 0) fail_with_errno(device);
  return static_cast<int>(minor(about.st_rdev));
}

void start_ticking(const FileHandle& timer, std::int64_t first_ns) {
  itimerspec when{};
  when.it_value = {first_ns / kNsPerSecond, first_ns % kNsPerSecond};
  when.it_interval = {0, kTick_ns};
  if (timerfd_settime(timer.get(), TFD_TIMER_ABSTIME, &when, nullptr) != 0) fail_with_errno("timer");
}

// What it starts is scheduled as anything else is.
void schedule(Pace pace) {
  if (pace == Pace::kReal) {
    // Drives answer whatever the controller and the pictures take.
    const sched_param first{kDrivePriority};
    if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &first) != 0) fail_with_errno("SCHED_FIFO");
    return;
  }
  // Woken by a frame, it does not take the processor from who sends the others of the same cycle: it finds
  // all of them at once.
  const sched_param none{};
  if (sched_setscheduler(0, SCHED_BATCH | SCHED_RESET_ON_FORK, &none) != 0) fail_with_errno("SCHED_BATCH");
}

void step_clock(double by_s) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  now.tv_sec += static_cast<time_t>(std::llround(by_s));
  if (clock_settime(CLOCK_REALTIME, &now) != 0) fail_with_errno("the clock cannot be set");
}

}  // namespace

std::optional<PictureAges::Spread> PictureAges::spread() const {
  if (ages_ns_.empty()) return std::nullopt;
  std::vector<std::int64_t> sorted = ages_ns_;
  std::sort(sorted.begin(), sorted.end());
  return Spread{sorted.front(), sorted[sorted.size() / 2], sorted.back()};
}

PlantLoop::PlantLoop(const RigScenario& scenario, const ControllerConfig& config,
                     ControllerProcess& controller)
    : scenario_(scenario),
      config_(config),
      controller_(controller),
      world_(scene_of(scenario, config), config.robot.arm, start_pose(scenario)),
      start_ns_(next_start_ns()),
      drives_(kCan, config.can.arm, config.robot.arm, start_of(config.robot.arm, start_pose(scenario)),
              start_ns_),
      eyes_(config.robot.eye_control.steps_per_rad),
      trace_(kGpioChip),
      cameras_{Vivid(kCameras[0], kDisplays[0]), Vivid(kCameras[1], kDisplays[1])},
      feeds_{PictureFeed(world_.scene(), render::Eye::kLeft, cameras_[0]),
             PictureFeed(world_.scene(), render::Eye::kRight, cameras_[1])},
      view_(config.runtime.telemetry.data()),
      pen_(world_.T_W_S().inverse()),
      judge_(scenario, config.robot.arm, config.robot.hand_limits.linear_velocity_mm_per_s),
      log_(empty_rig_log()),
      phases_(scenario.faults.size(), Phase::kWaiting),
      schedules_{PictureSchedule(idle_ns(scenario)), PictureSchedule(idle_ns(scenario))},
      minors_{minor_of(kCameras[0]), minor_of(kCameras[1])},
      tool_W_mm_(world_.T_W_H(drives_.position_rad()) * config.robot.tool_mm) {
  drives_.sway(scenario.sways);
}

void PlantLoop::run(Pace pace) {
  const FileHandle timer(timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC));
  if (!timer.is_open()) fail_with_errno("timer");
  schedule(pace);
  sleep_until(start_ns_ - kTick_ns);
  controller_.start();
  start_ticking(timer, start_ns_);
  const std::int64_t ticks = std::llround(scenario_.duration_s * 1e9) / kTick_ns;
  // The trace is read by the clock: to be woken by each of its lines would cost more than all else.
  std::array<pollfd, 2> entries{pollfd{drives_.handle_to_poll(), POLLIN, 0}, pollfd{timer.get(), POLLIN, 0}};
  while (tick_ <= ticks) {
    if (poll(entries.data(), entries.size(), -1) < 0 && errno != EINTR) fail_with_errno("poll");
    if (entries[0].revents != 0) drives_.receive(monotonic_ns());
    std::uint64_t due = 0;
    if (entries[1].revents == 0 || read(timer.get(), &due, sizeof due) != static_cast<ssize_t>(sizeof due)) {
      continue;
    }
    most_ticks_late_ = std::max(most_ticks_late_, static_cast<std::int64_t>(due) - 1);
    for (; due > 0 && tick_ <= ticks; --due) tick(tick_++);
    for (PictureFeed& feed : feeds_) {
      if (const auto trouble = feed.trouble()) throw RigError(*trouble);
    }
  }
}

void PlantLoop::take_trace() {
  trace_.read();
  for (const Edge& edge : trace_.edges()) eyes_.take(edge);
  for (const Capture& capture : trace_.captures()) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (capture.minor != minors_[side]) continue;
      schedules_[side].captured(capture.stamp_ns);
      // Once the rhythm is known.
      if (tick_ > kTicksToRhythm && shown_ns_[side] > 0) ages_.add(capture.stamp_ns - shown_ns_[side]);
      if (out_of_step_) keep_out_of_step(side);
    }
  }
}

// The eye whose picture came gives none until the other's has come.
void PlantLoop::keep_out_of_step(std::size_t captured_side) {
  feeds_[captured_side].act(CameraAction::kDropAll);
  feeds_[1 - captured_side].act(CameraAction::kDropNone);
}

void PlantLoop::show_pictures(const std::array<bool, 2>& due, std::int64_t now_ns, double t_s,
                              const Transform& T_W_H) {
  for (std::size_t side = 0; side < 2; ++side) {
    if (!due[side]) continue;
    shown_ns_[side] = now_ns;
    feeds_[side].show(world_.state(t_s, T_W_H, eyes_.angles()),
                      render::hash(world_.scene().seed, pictures_++));
  }
}

void PlantLoop::tick(std::int64_t tick) {
  const std::int64_t t_ns = tick * kTick_ns;
  const double t_s = seconds(t_ns);
  const std::array<bool, 2> due = {schedules_[0].is_due(start_ns_ + t_ns),
                                   schedules_[1].is_due(start_ns_ + t_ns)};
  // For whoever looks at the eyes now, a row or a picture; and soon enough for the next picture's rhythm.
  if (tick % kTicksToTrace == 0 || due[0] || due[1]) {
    take_trace();
    eyes_.advance(start_ns_ + t_ns);
  }
  keep_faults(t_s);
  drives_.advance(start_ns_ + t_ns);

  const Transform T_W_H = world_.T_W_H(drives_.position_rad());
  const Vector3 tool = T_W_H * config_.robot.tool_mm;
  const double speed = (tool - tool_W_mm_).norm() / seconds(kTick_ns);
  tool_W_mm_ = tool;
  fastest_mm_per_s_ = std::max(fastest_mm_per_s_, speed);
  if (tick % kTicksARow == 0) view_.look();
  judge_.watch(t_s, speed, drives_, view_);
  if (scenario_.pen_from_s > 0) {
    pen_.step(t_s, T_W_H, world_.T_W_M(t_s), world_.scene().target.mesh,
              tick % kTicksARow == 0 && is_pen_let_go(t_s));
  }

  show_pictures(due, start_ns_ + t_ns, t_s, T_W_H);
  if (tick % kTicksARow == 0) {
    const auto active = std::count(phases_.begin(), phases_.end(), Phase::kActive);
    add_row(log_, {t_s, std::exchange(fastest_mm_per_s_, 0), static_cast<int>(active), pictures_, start_ns_},
            world_, drives_, eyes_, config_.robot.relation, view_);
  }
}

// By what the controller says it believes alone, each row.
bool PlantLoop::is_pen_let_go(double t_s) {
  const std::optional<TelemetryRecord>& said = view_.record();
  if (!said || said->mode != static_cast<std::uint32_t>(Mode::kServo) || said->target_believed == 0) {
    aims_.clear();
    return false;
  }
  aims_.push_back({seconds(said->t_ns), transform_of(said->T_W_H), transform_of(said->T_W_M)});
  if (aims_.size() <= kAims) return false;
  const Aim before = aims_.front();
  const Aim& now = aims_.back();
  aims_.pop_front();
  if (t_s < scenario_.pen_from_s) return false;
  const Vector3 away_mm = now.T_W_M.t_mm - now.T_W_H.t_mm;
  const Vector3 away_before_mm = before.T_W_M.t_mm - before.T_W_H.t_mm;
  return demo::Pen::will_hit(now.T_W_H, now.T_W_M, (away_mm - away_before_mm) / (now.t_s - before.t_s));
}

void PlantLoop::keep_faults(double t_s) {
  for (std::size_t i = 0; i < phases_.size(); ++i) {
    const FaultEvent& fault = scenario_.faults[i];
    if (phases_[i] == Phase::kWaiting && t_s >= fault.at_s) {
      phases_[i] = Phase::kActive;
      begin(fault);
    }
    if (phases_[i] != Phase::kActive) continue;
    if (fault.for_s > 0 && t_s >= fault.at_s + fault.for_s) {
      phases_[i] = Phase::kOver;
      end(fault);
    } else {
      hold(fault, tick_);
    }
  }
}

void PlantLoop::begin(const FaultEvent& fault) {
  canopen::SimulatedDrive& drive = drives_.drive(std::min(fault.joint, drives_.joints() - 1));
  switch (fault.kind) {
    case FaultKind::kDriveSilent: return drive.set_power(false);
    case FaultKind::kDriveEmergency: return drive.fail(static_cast<std::uint16_t>(fault.value));
    case FaultKind::kHeartbeatLost: return drive.set_heartbeat(false);
    case FaultKind::kStatuswordBroken: return drive.show_statusword(kMeaningless);
    case FaultKind::kWrongNode: return drives_.set_impostor(fault.joint);
    case FaultKind::kForeignTraffic: return drives_.set_foreign_traffic(static_cast<int>(fault.value));
    case FaultKind::kBusOff: return drives_.set_bus(false);
    case FaultKind::kCameraUnplugged: return feed_of(fault).act(CameraAction::kUnplug);
    case FaultKind::kCameraStalled: return feed_of(fault).act(CameraAction::kDropAll);
    case FaultKind::kEyeLate:
      return feed_of(fault).set_late(
          static_cast<std::size_t>(std::llround(fault.value * 1e-3 * scenario_.frames_per_s)));
    case FaultKind::kEyesOutOfStep: {
      out_of_step_ = true;
      return keep_out_of_step(static_cast<std::size_t>(fault.side));
    }
    case FaultKind::kTargetAbsent: return;  // the scene knows
    case FaultKind::kControllerKilled: return controller_.send_signal(SIGKILL);
    case FaultKind::kControllerStopped: return controller_.send_signal(SIGSTOP);
    case FaultKind::kClockStep: return step_clock(fault.value);
    case FaultKind::kCameraDropping:
    case FaultKind::kCameraBroken: return;  // again and again
  }
}

// What has to be done each of the camera's periods.
void PlantLoop::hold(const FaultEvent& fault, std::int64_t tick) {
  const auto period = [](std::int64_t of_tick) {
    return static_cast<std::int64_t>(std::floor(static_cast<double>(of_tick) * 1e-3 * kCameraPeriods_per_s));
  };
  const std::int64_t now = period(tick);
  if (now == period(tick - 1)) return;
  // By a hash of its number, not by vivid's own dice, which are thrown anew in each run.
  const bool is_hit = render::uniform(1, static_cast<std::uint64_t>(now)) * 100 < fault.value;
  if (fault.kind == FaultKind::kCameraDropping) {
    feed_of(fault).act(is_hit ? CameraAction::kDropAll : CameraAction::kDropNone);
  } else if (fault.kind == FaultKind::kCameraBroken && is_hit) {
    feed_of(fault).act(CameraAction::kFlagNext);
  }
}

void PlantLoop::end(const FaultEvent& fault) {
  canopen::SimulatedDrive& drive = drives_.drive(std::min(fault.joint, drives_.joints() - 1));
  switch (fault.kind) {
    case FaultKind::kDriveSilent: return drive.set_power(true);
    case FaultKind::kHeartbeatLost: return drive.set_heartbeat(true);
    case FaultKind::kStatuswordBroken: return drive.show_statusword(std::nullopt);
    case FaultKind::kWrongNode: return drives_.set_impostor(std::nullopt);
    case FaultKind::kForeignTraffic: return drives_.set_foreign_traffic(0);
    case FaultKind::kBusOff: return drives_.set_bus(true);
    case FaultKind::kCameraUnplugged: return feed_of(fault).act(CameraAction::kPlugIn);
    case FaultKind::kCameraStalled:
    case FaultKind::kCameraDropping: return feed_of(fault).act(CameraAction::kDropNone);
    case FaultKind::kEyeLate: return feed_of(fault).set_late(0);
    case FaultKind::kEyesOutOfStep: {
      out_of_step_ = false;
      feeds_[0].act(CameraAction::kDropNone);
      return feeds_[1].act(CameraAction::kDropNone);
    }
    case FaultKind::kControllerKilled: (void)controller_.is_running(); return controller_.start();
    case FaultKind::kControllerStopped: return controller_.send_signal(SIGCONT);
    case FaultKind::kClockStep: return step_clock(-fault.value);
    case FaultKind::kDriveEmergency:
    case FaultKind::kTargetAbsent:
    case FaultKind::kCameraBroken: return;
  }
}

}  // namespace vergence::rig
