// Whether every task is alive: each says so when it has done its work, and whoever feeds the watchdog looks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "firmware_like/task_table.hpp"

namespace vergence {

// Silence beyond this is a task that hangs. Vision may take long where the machine is slow: late frames are
// another matter.
[[nodiscard]] constexpr std::int64_t longest_silence_ns(TaskId id) {
  switch (id) {
    case TaskId::kArm: return 100'000'000;
    case TaskId::kEyes: return 200'000'000;
    case TaskId::kVision:
    case TaskId::kCapture: return 2'000'000'000;
    case TaskId::kSteps: return 500'000'000;
  }
  return 0;
}

class TaskHealth {
 public:
  // From now on its silence counts. Before the task starts.
  void expect(TaskId id, std::int64_t now_ns) {
    last_ns_[static_cast<std::size_t>(id)].store(now_ns, std::memory_order_relaxed);
  }
  // The task itself, each time round.
  void ping(TaskId id, std::int64_t now_ns) { expect(id, now_ns); }

  // The first that has been silent too long.
  [[nodiscard]] std::optional<TaskId> silent(std::int64_t now_ns) const {
    for (std::size_t i = 0; i < kTaskCount; ++i) {
      const std::int64_t last_ns = last_ns_[i].load(std::memory_order_relaxed);
      const auto id = static_cast<TaskId>(i);
      if (last_ns != kNotExpected && now_ns - last_ns > longest_silence_ns(id)) return id;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::int64_t kNotExpected = -1;
  std::array<std::atomic<std::int64_t>, kTaskCount> last_ns_{kNotExpected, kNotExpected, kNotExpected,
                                                             kNotExpected, kNotExpected};
};

}  // namespace vergence
