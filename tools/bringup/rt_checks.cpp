#include "tools/bringup/rt_checks.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>

#include "firmware_like/task_table.hpp"
#include "hal/rt/memory_lock.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/periodic_schedule.hpp"
#include "hal/rt/rt_thread.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/rt/task_timing.hpp"

namespace vergence::tools {
namespace {

constexpr double kGoodShare = 0.1;  // of the period, that a wake-up may be late

Outcome outcome_of(rt::Verdict verdict) {
  switch (verdict) {
    case rt::Verdict::kPass: return Outcome::kPass;
    case rt::Verdict::kWarn: return Outcome::kWarn;
    case rt::Verdict::kFail: return Outcome::kFail;
  }
  return Outcome::kFail;
}

double to_us(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

void judge_wake_ups(const WakeUps& seen, Findings& found) {
  constexpr const char* kCheck = "wake-ups of the arm's task";
  if (!seen.problem.empty() || seen.runs == 0) {
    return found.fail(kCheck, seen.problem.empty() ? "it never ran" : seen.problem, "see the findings above");
  }
  const double share = static_cast<double>(seen.largest_ns) / static_cast<double>(seen.period_ns);
  const std::string measured = format(
      "late by %.0f us (median), %.0f (99 %%), %.0f at worst: %.1f %% of %.1f ms; %llu periods, %llu lost%s",
      to_us(seen.median_ns), to_us(seen.p99_ns), to_us(seen.largest_ns), 100 * share,
      to_us(seen.period_ns) * 1e-3, static_cast<unsigned long long>(seen.runs),
      static_cast<unsigned long long>(seen.lost_periods), seen.is_realtime ? "" : "; without real time");
  if (seen.lost_periods > 0 || seen.largest_ns >= seen.deadline_ns) {
    return found.fail(kCheck, measured,
                      "deadlines would be missed: mend what warns or fails above, then look at "
                      "docs/bringup.md, Real time");
  }
  found.judge(
      share > kGoodShare || !seen.is_realtime ? Outcome::kWarn : Outcome::kPass, kCheck, measured,
      "mend what warns or fails above, and measure under load: `vergence bringup --only rt --seconds 600`");
}

struct Measurement {
  rt::TimingRecord record;
  std::atomic<bool> stop{false};
  std::int64_t until_ns = 0;
  std::int64_t period_ns = 0;
};

void run(void* context) {
  auto& measurement = *static_cast<Measurement*>(context);
  rt::MonotonicClock clock;
  rt::MonotonicSleeper sleeper;
  rt::PeriodicSchedule schedule(clock.now_ns() + measurement.period_ns, measurement.period_ns);
  rt::run_periodic(clock, sleeper, schedule, measurement.record, measurement.stop,
                   [&](const rt::Release& release) {
                     if (release.now_ns >= measurement.until_ns)
                       measurement.stop.store(true, std::memory_order_release);
                   });
}

}  // namespace

std::vector<Finding> judge(const rt::MachineReport& machine, const WakeUps& wake_ups) {
  Findings found("rt");
  for (const rt::Finding& finding : machine.findings) {
    found.judge(outcome_of(finding.verdict), rt::to_string(finding.probe), finding.detail.data(),
                finding.remedy);
  }
  judge_wake_ups(wake_ups, found);
  return found.take();
}

rt::MachineReport judge_machine(const RuntimeConfig& config) {
  rt::MachineDemand demand;
  demand.priority = 0;
  for (const TaskRow& row : kTasks) demand.priority = std::max(demand.priority, row.priority);
  demand.cores = config.core;
  return rt::check_machine(demand, rt::ask_kernel(demand.priority));
}

WakeUps measure_wake_ups(const RuntimeConfig& config, std::int64_t arm_period_ns, double seconds) {
  const TaskRow row = task(TaskId::kArm, arm_period_ns);
  WakeUps seen;
  seen.period_ns = row.period_ns;
  seen.deadline_ns = row.deadline_ns;
  // What is refused of these shows in the machine's findings.
  const bool was_locked = rt::lock_memory().error == rt::MemoryLockError::kNone;
  rt::CpuLatencyRequest latency;
  (void)latency.hold();

  const auto measurement = std::make_unique<Measurement>();
  measurement->period_ns = row.period_ns;
  measurement->record.timing = rt::TaskTiming({row.period_ns, row.deadline_ns});
  rt::MonotonicClock clock;
  measurement->until_ns = clock.now_ns() + static_cast<std::int64_t>(seconds * 1e9);
  const auto stack = std::make_unique<rt::RtStack<std::size_t{256} * 1024>>();
  rt::RtThreadConfig thread;
  thread.name = "bringup";
  thread.stack = stack->span();
  thread.core = config.core[static_cast<std::size_t>(TaskId::kArm)];
  thread.scheduling.priority = row.priority;
  rt::RtThread runner;
  rt::RtThreadError error = runner.start(thread, run, measurement.get());
  seen.is_realtime = error == rt::RtThreadError::kNone;
  if (!seen.is_realtime) {
    thread.policy = rt::RealtimePolicy::kIgnore;
    error = runner.start(thread, run, measurement.get());
  }
  if (error != rt::RtThreadError::kNone) seen.problem = rt::describe(error);
  runner.join();
  if (was_locked) rt::unlock_memory();

  const rt::TimingRecord& record = measurement->record;
  seen.runs = record.timing.runs();
  seen.lost_periods = record.timing.lost_periods();
  seen.median_ns = record.latency.quantile_upper_bound_ns(0.5);
  seen.p99_ns = record.latency.quantile_upper_bound_ns(0.99);
  seen.largest_ns = record.latency.max_ns();
  return seen;
}

}  // namespace vergence::tools
