// Is this machine fit for real time? One finding a probe, each with its own remedy. What files tell is read
// below a root that tests choose; what only calls can tell comes in as values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence::rt {

enum class Verdict : std::uint8_t {
  kPass,
  kWarn,  // wake-ups may be late
  kFail,  // wake-ups will be late, or the tasks do not start
};
[[nodiscard]] const char* to_string(Verdict verdict);

enum class Probe : std::uint8_t {
  kKernel,         // is PREEMPT_RT
  kFifo,           // SCHED_FIFO may be had at the priority asked for
  kPriorityLimit,  // RLIMIT_RTPRIO
  kMemoryLimit,    // RLIMIT_MEMLOCK
  kThrottling,     // of real-time tasks
  kCores,          // are enough
  kGovernor,       // of the frequency
  kIsolation,      // of the tasks' cores, but core 0, from other tasks
  kTicks,          // none on the tasks' cores while they are alone there
  kSiblings,       // hardware threads that share the tasks' cores
  kIdleStates,     // can be kept shallow
  kClock,          // is read without leaving the processor
  kSwap,           // is off
  kHypervisor,     // none that may stop all cores at once
};
inline constexpr std::size_t kProbes = 14;
[[nodiscard]] const char* to_string(Probe probe);

struct Finding {
  Probe probe = Probe::kKernel;
  Verdict verdict = Verdict::kFail;
  std::array<char, 120> detail{};  // what was found, ends with a zero
  const char* remedy = "";         // empty where it passed
};

struct MachineReport {
  std::array<Finding, kProbes> findings{};  // by Probe
  [[nodiscard]] const Finding& operator[](Probe probe) const {
    return findings[static_cast<std::size_t>(probe)];
  }
  [[nodiscard]] Verdict worst() const;
};

// What the tasks want.
struct MachineDemand {
  int priority = 80;                               // the highest of the tasks
  std::span<const int> cores;                      // they are pinned to
  std::uint64_t locked_bytes = 64U * 1024 * 1024;  // of memory
};

// What calls tell.
struct KernelAnswers {
  std::array<char, 128> version{};  // of uname: "#1 SMP PREEMPT_RT ..."
  int fifo_errno = 0;               // of asking for SCHED_FIFO; 0: granted
  std::uint64_t priority_limit = 0;
  std::uint64_t memory_limit_bytes = 0;
  int cores = 0;  // online
};
inline constexpr std::uint64_t kUnlimited = ~std::uint64_t{0};

// Asks for SCHED_FIFO at that priority for the calling thread, and gives it back at once.
[[nodiscard]] KernelAnswers ask_kernel(int priority);

// `root` precedes /sys, /proc and /dev; "" is the machine itself.
[[nodiscard]] MachineReport check_machine(const MachineDemand& demand, const KernelAnswers& answers,
                                          const char* root = "");

}  // namespace vergence::rt
