#include "tools/bench/rt_bench.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "firmware_like/task_table.hpp"
#include "tools/bench/child_process.hpp"
#include "tools/bench/cyclictest.hpp"
#include "tools/bench/stopwatch.hpp"

namespace vergence::tools {
namespace {

constexpr int kSlice_s = 3;
constexpr TaskRow kArm = task(TaskId::kArm);
constexpr TaskRow kSteps = task(TaskId::kSteps);

std::array<int, kTasks.size()> cores_of_tasks() {
  std::array<int, kTasks.size()> cores{};
  for (std::size_t i = 0; i < kTasks.size(); ++i) cores[i] = kTasks[i].core;
  return cores;
}

int highest_priority() {
  int highest = 0;
  for (const TaskRow& row : kTasks) highest = std::max(highest, row.priority);
  return highest;
}

rt::RealtimePolicy policy_of(const RtBenchResult& result) {
  return result.scheduling == rt::RtThreadError::kNone ? rt::RealtimePolicy::kEnforce
                                                       : rt::RealtimePolicy::kIgnore;
}

// Both of our tasks' counterparts, at the same time as each other.
struct Reference {
  std::optional<rt::DurationHistogram> arm;
  std::optional<rt::DurationHistogram> steps;
};

Reference run_reference(int seconds) {
  const long cores = sysconf(_SC_NPROCESSORS_ONLN);
  const auto options = [&](std::int64_t interval_ns, int priority, int core) {
    return CyclictestOptions{interval_ns, seconds, priority, core < cores ? core : -1};
  };
  const std::string prefix =
      std::filesystem::temp_directory_path() / ("vergence-cyclictest-" + std::to_string(getpid()));
  Cyclictest arm(options(kArm.period_ns, kArm.priority, kArm.core), prefix + "-arm.json");
  Cyclictest steps(options((kLeastStep_ns + kMostStep_ns) / 2, kSteps.priority, kSteps.core),
                   prefix + "-steps.json");
  return {arm.result(), steps.result()};
}

// Collects the slices of a load.
class Comparison {
 public:
  void add(const TaskMeasurement& ours, const std::optional<rt::DurationHistogram>& reference) {
    sum_.ours.add(ours);
    if (!reference || reference->count() == 0) return;
    if (!sum_.reference) sum_.reference.emplace();
    sum_.reference->add(*reference);
    if (reference->max_ns() > 0) ratios_.push_back(ratio(ours.latency, *reference));
  }
  [[nodiscard]] RtComparison result() const {
    RtComparison result = sum_;
    if (!ratios_.empty()) {
      result.max_ratio = ratio(sum_.ours.latency, *sum_.reference);
      result.median_slice_ratio = median(ratios_);
    }
    return result;
  }

 private:
  static double ratio(const rt::DurationHistogram& ours, const rt::DurationHistogram& reference) {
    return static_cast<double>(ours.max_ns()) / static_cast<double>(reference.max_ns());
  }
  RtComparison sum_;
  std::vector<double> ratios_;
};

void note_once(std::vector<std::string>& notes, const std::string& note) {
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

// The real-time threads as the machine grants them, or else without.
RtSlice run_ours(int seconds, RtBenchResult& result) {
  RtSlice slice = run_rt_slice(seconds, policy_of(result));
  if (slice.error != rt::RtThreadError::kNone && result.scheduling == rt::RtThreadError::kNone) {
    result.scheduling = slice.error;
    note_once(result.notes, std::string("measured without real-time scheduling: ") + describe(slice.error));
    slice = run_rt_slice(seconds, rt::RealtimePolicy::kIgnore);
  }
  if (slice.error != rt::RtThreadError::kNone) throw std::runtime_error(describe(slice.error));
  return slice;
}

RtLoad measure(const std::string& name, const RtBenchOptions& options, RtBenchResult& result,
               const std::function<void()>& slice_done) {
  const int slices = rt_bench_slices(options.seconds);
  Comparison arm;
  Comparison steps;
  bool has_reference = is_in_path("cyclictest");
  if (!has_reference) note_once(result.notes, "cyclictest is not installed: apt install rt-tests");
  for (int i = 0; i < slices; ++i) {
    // Whole seconds, as cyclictest wants them; the first slices have the rest.
    const int seconds = options.seconds / slices + (i < options.seconds % slices ? 1 : 0);
    Reference reference;
    const auto run_theirs = [&] {
      if (has_reference) reference = run_reference(seconds);
    };
    // Who is first changes, against drifts.
    if (i % 2 == 1) run_theirs();
    const RtSlice slice = run_ours(seconds, result);
    if (i % 2 == 0) run_theirs();
    if (has_reference && (!reference.arm || !reference.steps)) {
      has_reference = false;
      note_once(result.notes, result.scheduling != rt::RtThreadError::kNone
                                  ? "cyclictest needs the same rights"
                                  : "cyclictest failed: see what `cyclictest -q -p 80 -i 2000 -D 1` says");
    }
    arm.add(slice.arm, reference.arm);
    steps.add(slice.steps, reference.steps);
    slice_done();
  }
  return {name, slices, arm.result(), steps.result()};
}

// Calculation on each core, memory, caches, and what the kernel does for sockets and context switches.
std::vector<std::string> stress_command(const RtBenchOptions& options) {
  constexpr int kMost = 4;  // times as long as ours alone, in case this process is killed
  return {"stress-ng", "--cpu",    "0",          "--cache",   "1",
          "--vm",      "1",        "--vm-bytes", "64M",       "--sock",
          "1",         "--switch", "1",          "--timeout", std::to_string(kMost * options.seconds + 10),
          "--quiet"};
}

}  // namespace

int rt_bench_slices(int seconds) {
  return std::max(1, seconds / kSlice_s);
}

RtBenchResult run_rt_bench(const RtBenchOptions& options, const std::function<void()>& slice_done) {
  RtBenchResult result;
  const std::array<int, kTasks.size()> cores = cores_of_tasks();
  rt::MachineDemand demand;
  demand.priority = highest_priority();
  demand.cores = cores;
  result.machine = check_machine(demand, rt::ask_kernel(demand.priority));

  result.memory = rt::lock_memory();
  if (result.memory.error != rt::MemoryLockError::kNone) {
    result.notes.push_back(std::string("memory not locked: ") + describe(result.memory.error));
  }
  rt::CpuLatencyRequest awake;
  result.idle_states = awake.hold();
  if (result.idle_states != rt::CpuLatencyError::kNone) {
    result.notes.push_back(std::string("idle states not held: ") + describe(result.idle_states));
  }

  result.loads.push_back(measure("idle", options, result, slice_done));
  if (options.stress && !is_in_path("stress-ng")) {
    result.notes.emplace_back("stress-ng is not installed: apt install stress-ng");
  } else if (options.stress) {
    ChildProcess stress(stress_command(options));
    if (!stress.has_started()) throw std::runtime_error("stress-ng did not start");
    result.loads.push_back(measure("stress", options, result, slice_done));
  }
  rt::unlock_memory();
  return result;
}

std::int64_t worst_arm_latency_ns(const RtBenchResult& result) {
  std::int64_t worst_ns = 0;
  for (const RtLoad& load : result.loads) worst_ns = std::max(worst_ns, load.arm.ours.latency.max_ns());
  return worst_ns;
}

std::int64_t step_jitter_ns(const RtBenchResult& result) {
  std::int64_t worst_ns = 0;
  for (const RtLoad& load : result.loads) worst_ns = std::max(worst_ns, load.steps.ours.response.max_ns());
  return worst_ns;
}

bool is_fit(const RtBenchResult& result) {
  if (result.scheduling != rt::RtThreadError::kNone) return false;
  for (const RtLoad& load : result.loads) {
    if (load.arm.ours.lost_periods > 0) return false;
  }
  return worst_arm_latency_ns(result) <= kArm.deadline_ns / 2;
}

}  // namespace vergence::tools
