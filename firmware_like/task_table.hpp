// Every task of the controller: how often it runs, how long it may take, where, and how urgently.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vergence {

// Stacks: arm64's C library wants 128 KiB at least, beside the guard page.
struct TaskRow {
  const char* name;
  std::int64_t period_ns;
  std::int64_t deadline_ns;  // from its release
  int priority;              // of SCHED_FIFO
  int core;                  // it is pinned to, where there are so many
  std::size_t stack_bytes;
};

enum class TaskId : std::size_t {
  kArm,
  kEyes,
  kVision,
  kCapture,
  kSteps,
};
inline constexpr std::size_t kTaskCount = 5;

// By urgency: image work must never delay the bus, and nothing may delay an edge. The first three are due
// together, and run in this order. A period of 0: not periodic.
inline constexpr std::array<TaskRow, kTaskCount> kTasks = {
    TaskRow{"arm", 2'000'000, 1'000'000, 80, 1, std::size_t{256} * 1024},
    TaskRow{"eyes", 4'000'000, 2'000'000, 70, 2, std::size_t{256} * 1024},
    // Asked this often whether a pair has come; a frame's own deadline is its release offset.
    TaskRow{"vision", 1'000'000, 33'000'000, 60, 3, std::size_t{1024} * 1024},
    // Waits for the cameras, at most 100 ms.
    TaskRow{"capture", 0, 10'000'000, 65, 0, std::size_t{256} * 1024},
    // Sleeps from edge to edge of the step pulses.
    TaskRow{"steps", 0, 100'000, 85, 2, std::size_t{256} * 1024},
};

[[nodiscard]] constexpr const TaskRow& task(TaskId id) {
  return kTasks[static_cast<std::size_t>(id)];
}

// With the period of the arm's task as configured, and its deadline at the same share of it.
[[nodiscard]] constexpr TaskRow task(TaskId id, std::int64_t arm_period_ns) {
  TaskRow row = task(id);
  if (id != TaskId::kArm) return row;
  row.deadline_ns = row.deadline_ns * arm_period_ns / row.period_ns;
  row.period_ns = arm_period_ns;
  return row;
}
static_assert(task(TaskId::kArm, 1'000'000).deadline_ns == 500'000);

}  // namespace vergence
