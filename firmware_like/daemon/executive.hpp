// The controller at work: the pipeline's tasks on their threads, with the devices they were compiled for. One
// object, placed statically; between start() and stop() nothing here allocates or waits but for the time.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>

#include "firmware_like/config/controller_config.hpp"
#include "firmware_like/daemon/black_box.hpp"
#include "firmware_like/daemon/fill_record.hpp"
#include "firmware_like/daemon/operator_channel.hpp"
#include "firmware_like/daemon/task_health.hpp"
#include "firmware_like/daemon/telemetry_segment.hpp"
#include "firmware_like/pipeline.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/rt_thread.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/rt/task_timing.hpp"

namespace vergence {

// What the executive wants of the devices: a StereoCamera with a capturing side, an Arm with a process() each
// period, and a PanTilt with the side that makes its edges.
template <typename T>
concept Devices = requires(T& devices, std::int64_t now_ns, rt::MonotonicClock& clock) {
  requires StereoCamera<std::remove_reference_t<decltype(devices.cameras())>>;
  requires Arm<std::remove_reference_t<decltype(devices.arm())>>;
  requires PanTilt<std::remove_reference_t<decltype(devices.eyes())>>;
  devices.process_arm(now_ns);
  devices.start_capture(now_ns);
  devices.capture_once(clock);
  devices.stop_capture();
  { devices.next_edge_ns() } -> std::same_as<std::int64_t>;
  devices.run_edges(now_ns);
};

// What a task leaves when it ends.
struct TaskSummary {
  rt::TimingRecord timing;
  rt::PageFaults faults_at_start;
  rt::PageFaults faults;  // since then
  std::size_t stack_used_bytes = 0;
  std::size_t stack_bytes = 0;
  rt::Placement placement = rt::Placement::kNotAsked;
};

struct StartResult {
  Status status = Status::kOk;  // of the pipeline
  rt::RtThreadError thread_error = rt::RtThreadError::kNone;
  TaskId task = TaskId::kArm;  // whose thread
  int error_number = 0;
};

template <Devices D>
class Executive {
 public:
  explicit Executive(D& devices) : devices_(&devices) {}
  ~Executive() { stop(); }
  Executive(const Executive&) = delete;
  Executive& operator=(const Executive&) = delete;

  // The configuration outlives the executive. Where a thread does not start, those before are stopped again.
  [[nodiscard]] StartResult start(const ControllerConfig& config, rt::RealtimePolicy policy);
  // Ends the threads; the arm is to be stopped before.
  void stop();

  // Any thread.
  [[nodiscard]] OperatorChannel& operators() { return operators_; }
  [[nodiscard]] const TaskHealth& health() const { return health_; }
  // False before the first period.
  [[nodiscard]] bool last_record(TelemetryRecord& record) const {
    return memory_.sequence.load(std::memory_order_acquire) != 0 && get_record(memory_, record);
  }

  // Main thread: before start(), to be told of each record as well.
  void publish_to(TelemetryWriter& writer) { writer_ = &writer; }
  [[nodiscard]] BlackBox& black_box() { return box_; }
  [[nodiscard]] const TaskSummary& summary(TaskId id) const { return summaries_[index(id)]; }  // after stop()

 private:
  static constexpr std::int64_t kLongestSleep_ns = 50'000'000;
  static constexpr std::uint64_t kFaultsEvery = 512;  // runs

  static constexpr std::size_t index(TaskId id) { return static_cast<std::size_t>(id); }
  [[nodiscard]] TaskRow row_of(TaskId id) const { return task(id, config_->robot.arm_period_ns); }

  // Lets the black box see what vision takes.
  struct WatchedCameras {
    Executive* self;
    [[nodiscard]] bool take(StereoFrame& frame) {
      if (!self->devices_->cameras().take(frame)) return false;
      self->box_.look(frame);
      return true;
    }
    [[nodiscard]] CameraState state() { return self->devices_->cameras().state(); }
  };

  void run_arm();
  void run_eyes();
  void run_vision();
  void run_capture();
  void run_steps();
  void arm_period(const rt::Release& release);
  void publish(std::int64_t now_ns);
  [[nodiscard]] rt::RtThreadError start_thread(TaskId id, std::span<std::byte> stack,
                                               rt::RealtimePolicy policy, rt::RtThread::Function function);
  void begin_task(TaskId id);
  void end_task(TaskId id);
  void after_run(TaskId id, std::int64_t now_ns);
  template <typename Body>
  void run_periodically(TaskId id, Body&& body);

  D* devices_;
  const ControllerConfig* config_ = nullptr;
  Pipeline pipeline_;
  rt::MonotonicClock clock_;
  rt::MonotonicSleeper sleeper_;
  OperatorChannel operators_;
  TaskHealth health_;
  TelemetryMemory memory_;
  TelemetryWriter* writer_ = nullptr;
  BlackBox box_;
  TelemetryRecord record_;
  Mode last_mode_ = Mode::kInit;

  std::atomic<bool> stop_{false};
  std::int64_t start_ns_ = 0;
  std::array<rt::RtThread, kTaskCount> threads_;
  std::array<TaskSummary, kTaskCount> summaries_{};
  // Of each task, for the record: written by its own thread.
  std::array<LatestValue<TaskRecord>, kTaskCount> task_records_;
  std::array<std::int64_t, kTaskCount> faults_so_far_{};

  rt::RtStack<task(TaskId::kArm).stack_bytes> arm_stack_;
  rt::RtStack<task(TaskId::kEyes).stack_bytes> eyes_stack_;
  rt::RtStack<task(TaskId::kVision).stack_bytes> vision_stack_;
  rt::RtStack<task(TaskId::kCapture).stack_bytes> capture_stack_;
  rt::RtStack<task(TaskId::kSteps).stack_bytes> steps_stack_;
};

// ---- templates ------------------------------------------------------------------------------------------

template <Devices D>
StartResult Executive<D>::start(const ControllerConfig& config, rt::RealtimePolicy policy) {
  config_ = &config;
  StartResult result;
  result.status = config.target == TargetKind::kMarker ? pipeline_.configure(config.robot, config.marker)
                                                       : pipeline_.configure(config.robot, config.photo);
  if (result.status != Status::kOk) return result;
  stop_.store(false);
  // Together, a little later, and on whole periods of all of them.
  start_ns_ = clock_.now_ns() + 20'000'000;

  struct Row {
    TaskId id;
    std::span<std::byte> stack;
    rt::RtThread::Function function;
    bool wanted;
  };
  const bool eyes = config.robot.has_eyes;
  const std::array<Row, kTaskCount> rows = {{
      {TaskId::kSteps, steps_stack_.span(), [](void* self) { static_cast<Executive*>(self)->run_steps(); },
       eyes},
      {TaskId::kCapture, capture_stack_.span(),
       [](void* self) { static_cast<Executive*>(self)->run_capture(); }, true},
      {TaskId::kVision, vision_stack_.span(), [](void* self) { static_cast<Executive*>(self)->run_vision(); },
       true},
      {TaskId::kEyes, eyes_stack_.span(), [](void* self) { static_cast<Executive*>(self)->run_eyes(); },
       eyes},
      {TaskId::kArm, arm_stack_.span(), [](void* self) { static_cast<Executive*>(self)->run_arm(); }, true},
  }};
  for (const Row& row : rows) {
    if (!row.wanted) continue;
    result.thread_error = start_thread(row.id, row.stack, policy, row.function);
    if (result.thread_error == rt::RtThreadError::kNone) continue;
    result.task = row.id;
    result.error_number = threads_[index(row.id)].last_errno();
    stop();
    return result;
  }
  return result;
}

template <Devices D>
rt::RtThreadError Executive<D>::start_thread(TaskId id, std::span<std::byte> stack, rt::RealtimePolicy policy,
                                             rt::RtThread::Function function) {
  const TaskRow row = row_of(id);
  rt::RtThreadConfig thread;
  thread.name = row.name;
  thread.stack = stack;
  thread.core = config_->runtime.core[index(id)];
  thread.policy = policy;
  thread.scheduling.priority = row.priority;
  if (id == TaskId::kArm && config_->runtime.policy == SchedulingPolicy::kDeadline) {
    thread.scheduling = {rt::SchedulingKind::kDeadline, 1, row.deadline_ns / 2, row.deadline_ns,
                         row.period_ns};
  }
  health_.expect(id, clock_.now_ns());
  return threads_[index(id)].start(thread, function, this);
}

template <Devices D>
void Executive<D>::stop() {
  stop_.store(true, std::memory_order_release);
  for (std::size_t i = 0; i < kTaskCount; ++i) {
    if (!threads_[i].is_running()) continue;
    threads_[i].join();
    summaries_[i].stack_used_bytes = threads_[i].stack_high_water_bytes();
    summaries_[i].stack_bytes = threads_[i].stack_bytes();
    summaries_[i].placement = threads_[i].placement();
  }
}

template <Devices D>
void Executive<D>::begin_task(TaskId id) {
  TaskSummary& summary = summaries_[index(id)];
  const TaskRow row = row_of(id);
  summary.timing = {};
  summary.timing.timing = rt::TaskTiming({row.period_ns, row.deadline_ns});
  summary.faults_at_start = rt::page_faults_of_this_thread();
}

template <Devices D>
void Executive<D>::end_task(TaskId id) {
  TaskSummary& summary = summaries_[index(id)];
  const rt::PageFaults now = rt::page_faults_of_this_thread();
  summary.faults = {now.minor - summary.faults_at_start.minor, now.major - summary.faults_at_start.major};
}

template <Devices D>
void Executive<D>::after_run(TaskId id, std::int64_t now_ns) {
  const rt::TaskTiming& timing = summaries_[index(id)].timing.timing;
  if (timing.runs() % kFaultsEvery == 0) {
    const rt::PageFaults now = rt::page_faults_of_this_thread();
    const rt::PageFaults& before = summaries_[index(id)].faults_at_start;
    faults_so_far_[index(id)] = now.minor - before.minor + now.major - before.major;
  }
  TaskRecord record;
  record.worst_latency_ns = timing.worst_latency_ns();
  record.worst_execution_ns = timing.worst_execution_ns();
  record.runs = timing.runs();
  record.slips = timing.lost_periods();
  record.misses = timing.misses();
  record.page_faults = static_cast<std::uint64_t>(faults_so_far_[index(id)]);
  task_records_[index(id)].write(record);
  health_.ping(id, now_ns);
}

template <Devices D>
template <typename Body>
void Executive<D>::run_periodically(TaskId id, Body&& body) {
  begin_task(id);
  // All on one grid, but none late for releases before it was there.
  const std::int64_t period_ns = row_of(id).period_ns;
  const std::int64_t behind_ns = std::max<std::int64_t>(clock_.now_ns() - start_ns_, 0);
  rt::PeriodicSchedule schedule(start_ns_ + (behind_ns + period_ns - 1) / period_ns * period_ns, period_ns);
  rt::run_periodic(clock_, sleeper_, schedule, summaries_[index(id)].timing, stop_,
                   [&](const rt::Release& release) {
                     body(release);
                     after_run(id, release.now_ns);
                   });
  end_task(id);
}

template <Devices D>
void Executive<D>::run_arm() {
  run_periodically(TaskId::kArm, [this](const rt::Release& release) { arm_period(release); });
}

template <Devices D>
void Executive<D>::arm_period(const rt::Release& release) {
  // A period that was left out is a deadline missed as well.
  const rt::TaskTiming& timing = summaries_[index(TaskId::kArm)].timing.timing;
  const auto missed = static_cast<int>(timing.misses_in_a_row()) + static_cast<int>(release.skipped);
  pipeline_.report_missed_deadlines(missed);
  if (const std::optional<OperatorCommand> command = operators_.take()) pipeline_.command(*command);
  devices_->process_arm(release.now_ns);
  pipeline_.step_arm(release.now_ns, devices_->arm());
  publish(release.now_ns);
}

template <Devices D>
void Executive<D>::publish(std::int64_t now_ns) {
  fill_record(pipeline_, record_);
  ++record_.period;
  for (std::size_t i = 0; i < kTaskCount; ++i) (void)task_records_[i].read(record_.tasks[i]);
  put_record(memory_, record_);
  if (writer_ != nullptr) writer_->write(record_);
  box_.record(record_);
  const Mode mode = pipeline_.arm_period().mode;
  const bool stops = mode == Mode::kSafeStop || mode == Mode::kFault;
  if (stops && mode != last_mode_ && last_mode_ != Mode::kSafeStop) (void)box_.trigger(now_ns);
  last_mode_ = mode;
}

template <Devices D>
void Executive<D>::run_eyes() {
  run_periodically(TaskId::kEyes, [this](const rt::Release& release) {
    pipeline_.step_eyes(release.now_ns, devices_->eyes());
  });
}

template <Devices D>
void Executive<D>::run_vision() {
  WatchedCameras cameras{this};
  run_periodically(TaskId::kVision, [this, &cameras](const rt::Release& release) {
    pipeline_.step_vision(release.now_ns, cameras);
  });
}

template <Devices D>
void Executive<D>::run_capture() {
  begin_task(TaskId::kCapture);
  rt::TimingRecord& timing = summaries_[index(TaskId::kCapture)].timing;
  devices_->start_capture(clock_.now_ns());
  while (!stop_.load(std::memory_order_acquire)) {
    devices_->capture_once(clock_);
    // It waits inside: only that it came round is known.
    const std::int64_t now_ns = clock_.now_ns();
    timing.began(now_ns, now_ns);
    (void)timing.ended(now_ns);
    after_run(TaskId::kCapture, now_ns);
  }
  devices_->stop_capture();
  end_task(TaskId::kCapture);
}

template <Devices D>
void Executive<D>::run_steps() {
  begin_task(TaskId::kSteps);
  rt::TimingRecord& timing = summaries_[index(TaskId::kSteps)].timing;
  std::int64_t ended_ns = clock_.now_ns();
  while (!stop_.load(std::memory_order_acquire)) {
    // What was due before the last run ended is due now.
    const std::int64_t due_ns = std::clamp(devices_->next_edge_ns(), ended_ns, ended_ns + kLongestSleep_ns);
    rt::sleep_until(due_ns);
    const std::int64_t now_ns = clock_.now_ns();
    timing.began(due_ns, now_ns);
    devices_->run_edges(now_ns);
    ended_ns = clock_.now_ns();
    (void)timing.ended(ended_ns);
    after_run(TaskId::kSteps, ended_ns);
  }
  end_task(TaskId::kSteps);
}

}  // namespace vergence
