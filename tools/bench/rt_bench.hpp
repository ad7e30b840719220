// Is this machine punctual enough? The executive's wake-ups beside cyclictest's, in short slices that take
// turns so that both meet the same disturbances; idle, and under load.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/rt/machine_check.hpp"
#include "hal/rt/memory_lock.hpp"
#include "tools/bench/rt_tasks.hpp"

namespace vergence::tools {

struct RtBenchOptions {
  int seconds = 30;  // that each of both runs, idle and again under load
  bool stress = false;
};

// One task, over all slices.
struct RtComparison {
  TaskMeasurement ours;
  std::optional<rt::DurationHistogram> reference;  // cyclictest's wake-ups
  // Greatest lateness of ours over that of cyclictest: over all slices, and the median of the slices.
  std::optional<double> max_ratio;
  std::optional<double> median_slice_ratio;
};

struct RtLoad {
  std::string name;  // idle, stress
  int slices = 0;
  RtComparison arm;
  RtComparison steps;
};

struct RtBenchResult {
  rt::MachineReport machine;
  rt::MemoryLock memory;
  rt::CpuLatencyError idle_states = rt::CpuLatencyError::kNone;
  rt::RtThreadError scheduling = rt::RtThreadError::kNone;  // otherwise it was measured without
  std::vector<std::string> notes;                           // what could not be done, and what to install
  std::vector<RtLoad> loads;
};

// Of about three seconds.
[[nodiscard]] int rt_bench_slices(int seconds);

// `slice_done` is called after each slice of each load. Throws std::runtime_error where no thread can be had
// even without real-time scheduling.
[[nodiscard]] RtBenchResult run_rt_bench(const RtBenchOptions& options,
                                         const std::function<void()>& slice_done);

// The arm's worst wake-up over all loads.
[[nodiscard]] std::int64_t worst_arm_latency_ns(const RtBenchResult& result);
// The worst lateness of a step task's edge over all loads, from when it was due to when its line could be
// set.
[[nodiscard]] std::int64_t step_jitter_ns(const RtBenchResult& result);
// Real-time scheduling was granted, no period of the arm was lost, and its wake-ups left half of its deadline
// to its work.
[[nodiscard]] bool is_fit(const RtBenchResult& result);

}  // namespace vergence::tools
