#include "tools/bench/rt_tasks.hpp"

#include <algorithm>
#include <atomic>

#include "firmware_like/task_table.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/periodic_schedule.hpp"
#include "hal/rt/sleep.hpp"
#include "tools/bench/arm_period.hpp"

namespace vergence::tools {
namespace {

constexpr TaskRow kArm = task(TaskId::kArm);
constexpr TaskRow kSteps = task(TaskId::kSteps);

// From a thread's own start to its first wake-up: whoever starts it is not urgent, and may be late.
constexpr std::int64_t kSettle_ns = 10'000'000;

rt::RtStack<kArm.stack_bytes> arm_stack;
rt::RtStack<kSteps.stack_bytes> step_stack;

struct Slice {
  std::atomic<bool> stop = false;
  ArmPeriod arm_period;
  RtSlice result;
  double sum = 0;  // of what was calculated
};

// Keeps whole distributions where TaskTiming keeps the worst.
class Recorder {
 public:
  Recorder(const rt::TimingLimits& limits, TaskMeasurement& measurement)
      : timing_(limits), measurement_(measurement), faults_before_(rt::page_faults_of_this_thread()) {}

  void began(std::int64_t release_ns, std::int64_t now_ns) {
    timing_.began(release_ns, now_ns);
    measurement_.latency.add(timing_.latency_ns());
  }
  bool ended(std::int64_t now_ns) {
    const bool kept = timing_.ended(now_ns);
    measurement_.execution.add(timing_.execution_ns());
    measurement_.response.add(timing_.response_ns());
    return kept;
  }
  void finish() {
    const rt::PageFaults now = rt::page_faults_of_this_thread();
    measurement_.faults = {now.minor - faults_before_.minor, now.major - faults_before_.major};
    measurement_.lost_periods = timing_.lost_periods();
    measurement_.misses = timing_.misses();
  }

 private:
  rt::TaskTiming timing_;
  TaskMeasurement& measurement_;
  rt::PageFaults faults_before_;
};
static_assert(rt::Timing<Recorder>);

void run_arm(void* context) {
  Slice& slice = *static_cast<Slice*>(context);
  Recorder recorder({kArm.period_ns, kArm.deadline_ns}, slice.result.arm);
  rt::MonotonicClock clock;
  rt::MonotonicSleeper sleeper;
  rt::PeriodicSchedule schedule(clock.now_ns() + kSettle_ns, kArm.period_ns);
  rt::run_periodic(clock, sleeper, schedule, recorder, slice.stop, [&slice](const rt::Release& release) {
    slice.sum += slice.arm_period.run(release.release_ns);
  });
  recorder.finish();
}

// Each edge is due at an instant of its own, after the one before, or from now on where that has passed.
void run_steps(void* context) {
  Slice& slice = *static_cast<Slice*>(context);
  Recorder recorder({}, slice.result.steps);
  rt::MonotonicClock clock;
  std::int64_t due_ns = clock.now_ns() + kSettle_ns;
  std::uint32_t random = 1;
  while (!slice.stop.load(std::memory_order_acquire)) {
    rt::sleep_until(due_ns);
    const std::int64_t now_ns = clock.now_ns();
    recorder.began(due_ns, now_ns);
    random = random * 1664525U + 1013904223U;
    const std::int64_t apart_ns =
        kLeastStep_ns + static_cast<std::int64_t>(random >> 8) % (kMostStep_ns - kLeastStep_ns + 1);
    due_ns = std::max(due_ns, now_ns) + apart_ns;
    (void)recorder.ended(clock.now_ns());
  }
  recorder.finish();
}

void finish(rt::RtThread& thread, TaskMeasurement& measurement) {
  thread.join();
  measurement.placement = thread.placement();
  measurement.stack_used_bytes = thread.stack_high_water_bytes();
  measurement.stack_bytes = thread.stack_bytes();
}

}  // namespace

void TaskMeasurement::add(const TaskMeasurement& other) {
  latency.add(other.latency);
  execution.add(other.execution);
  response.add(other.response);
  lost_periods += other.lost_periods;
  misses += other.misses;
  faults.minor += other.faults.minor;
  faults.major += other.faults.major;
  placement = other.placement;
  stack_used_bytes = std::max(stack_used_bytes, other.stack_used_bytes);
  stack_bytes = other.stack_bytes;
}

RtSlice run_rt_slice(int seconds, rt::RealtimePolicy policy) {
  Slice slice;

  rt::RtThread arm;
  rt::RtThread steps;
  rt::RtThreadConfig config;
  config.policy = policy;
  config.name = "bench arm";
  config.stack = arm_stack.span();
  config.core = kArm.core;
  config.scheduling.priority = kArm.priority;
  slice.result.error = arm.start(config, run_arm, &slice);
  if (slice.result.error != rt::RtThreadError::kNone) return slice.result;
  config.name = "bench steps";
  config.stack = step_stack.span();
  config.core = kSteps.core;
  config.scheduling.priority = kSteps.priority;
  slice.result.error = steps.start(config, run_steps, &slice);
  if (slice.result.error == rt::RtThreadError::kNone) {
    rt::sleep_until(rt::MonotonicClock{}.now_ns() + kSettle_ns + seconds * kNsPerSecond);
  }
  slice.stop = true;
  finish(arm, slice.result.arm);
  finish(steps, slice.result.steps);
  return slice.result;
}

}  // namespace vergence::tools
