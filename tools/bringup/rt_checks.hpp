// Is the machine fit for real time, and does a task of the arm's urgency wake when it should?
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/config/controller_config.hpp"
#include "hal/rt/machine_check.hpp"
#include "tools/bringup/finding.hpp"

namespace vergence::tools {

// Of a task that slept from period to period for a while.
struct WakeUps {
  std::string problem;       // empty: it ran
  bool is_realtime = false;  // scheduled as the controller schedules it
  std::int64_t period_ns = 0;
  std::int64_t deadline_ns = 0;  // of the arm's task, from its release
  std::uint64_t runs = 0;
  std::uint64_t lost_periods = 0;
  std::int64_t median_ns = 0;  // from when it was due to when it ran
  std::int64_t p99_ns = 0;
  std::int64_t largest_ns = 0;
};

[[nodiscard]] std::vector<Finding> judge(const rt::MachineReport& machine, const WakeUps& wake_ups);

// The machine as vergenced judges it.
[[nodiscard]] rt::MachineReport judge_machine(const RuntimeConfig& config);
// On the arm's core, at its priority and the period it is configured for, with memory locked and processors
// kept awake as vergenced does; without real-time scheduling where that is refused.
[[nodiscard]] WakeUps measure_wake_ups(const RuntimeConfig& config, std::int64_t arm_period_ns,
                                       double seconds);

}  // namespace vergence::tools
