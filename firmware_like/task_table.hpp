// Every task of the controller: how often it runs, how long it may take, where, and how urgently.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vergence {

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
};

// By urgency: image work must never delay the bus. Tasks due at the same instant run in this order.
inline constexpr std::array kTasks = {
    TaskRow{"arm", 2'000'000, 1'000'000, 80, 1, std::size_t{256} * 1024},
    TaskRow{"eyes", 4'000'000, 2'000'000, 70, 2, std::size_t{256} * 1024},
    // Asked this often whether a pair has come; a frame's own deadline is its release offset.
    TaskRow{"vision", 1'000'000, 33'000'000, 60, 3, std::size_t{1024} * 1024},
};

[[nodiscard]] constexpr const TaskRow& task(TaskId id) {
  return kTasks[static_cast<std::size_t>(id)];
}

}  // namespace vergence
