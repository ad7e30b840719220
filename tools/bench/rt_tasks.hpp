// The controller's two most urgent tasks, as its table has them, run by the executive for a while and
// measured: the arm's, with what it calculates, and one that wakes like the task of the step pulses.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/rt/rt_thread.hpp"
#include "hal/rt/task_timing.hpp"

namespace vergence::tools {

// Deadlines of the step task: apart by any time between these.
inline constexpr std::int64_t kLeastStep_ns = 100'000;
inline constexpr std::int64_t kMostStep_ns = 1'000'000;

struct TaskMeasurement {
  rt::DurationHistogram latency;    // of wake-ups, from when they were due
  rt::DurationHistogram execution;  // from there to the end
  rt::DurationHistogram response;   // both together
  std::uint64_t lost_periods = 0;
  std::uint64_t misses = 0;  // of the deadline
  rt::PageFaults faults;     // in its periods
  rt::Placement placement = rt::Placement::kNotAsked;
  std::size_t stack_used_bytes = 0;
  std::size_t stack_bytes = 0;

  void add(const TaskMeasurement& other);
};

struct RtSlice {
  rt::RtThreadError error = rt::RtThreadError::kNone;
  TaskMeasurement arm;
  TaskMeasurement steps;
};

// Both for so long, one call at a time. What does not start is told in `error`, and nothing is measured.
[[nodiscard]] RtSlice run_rt_slice(int seconds, rt::RealtimePolicy policy);

}  // namespace vergence::tools
