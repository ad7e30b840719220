// A thread whose stack, core and urgency are the caller's: on memory given to it and painted, so that what it
// used of its stack can be measured, with a guard page below, scheduled by priority or by deadline.
#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence::rt {

enum class RealtimePolicy : std::uint8_t {
  kEnforce,  // a thread that cannot have its scheduling does not start
  kIgnore,   // SCHED_OTHER, for machines and tests without the rights
};

enum class SchedulingKind : std::uint8_t {
  kFifo,      // by priority
  kDeadline,  // SCHED_DEADLINE: so much time within each period; the kernel picks the core
};

struct Scheduling {
  SchedulingKind kind = SchedulingKind::kFifo;
  int priority = 1;              // kFifo: 1 to 99
  std::int64_t runtime_ns = 0;   // kDeadline: runtime <= deadline <= period
  std::int64_t deadline_ns = 0;  // kDeadline
  std::int64_t period_ns = 0;    // kDeadline
};

inline constexpr int kAnyCore = -1;

struct RtThreadConfig {
  const char* name = "rt";  // the kernel keeps 15 letters of it
  // Outlives the thread. Its first whole page becomes the guard; what is above it is the stack, of which the
  // C library takes some 5 kB.
  std::span<std::byte> stack;
  int core = kAnyCore;
  Scheduling scheduling;
  RealtimePolicy policy = RealtimePolicy::kEnforce;
};

// What the thread sanitizer keeps on each stack.
#if defined(__SANITIZE_THREAD__)
inline constexpr std::size_t kSanitizersStack_bytes = std::size_t{1024} * 1024;
#else
inline constexpr std::size_t kSanitizersStack_bytes = 0;
#endif

// Memory for a stack, on pages of its own; the guard page is one of them.
template <std::size_t Bytes>
struct alignas(4096) RtStack {
  std::array<std::byte, Bytes + kSanitizersStack_bytes> bytes;
  [[nodiscard]] std::span<std::byte> span() { return bytes; }
};

enum class RtThreadError : std::uint8_t {
  kNone,
  kRunning,        // it was started, and not joined
  kStackTooSmall,  // for the C library, beside a guard page
  kCreate,         // no more threads: last_errno()
  kBadScheduling,  // priority or times out of range
  kNotPermitted,   // EPERM
  kNotAdmitted,    // SCHED_DEADLINE: the cores have no such time left
  kNotSupported,   // the kernel lacks the scheduler
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(RtThreadError error);

enum class Placement : std::uint8_t {
  kNotAsked,
  kPinned,
  kFewerCores,  // than the one asked for: on any core
  kRefused,     // the core is not ours (container, cpuset, offline): on any core
  kByKernel,    // SCHED_DEADLINE: on any core
};
[[nodiscard]] const char* describe(Placement placement);

struct PageFaults {
  std::int64_t minor = 0;  // memory that was not mapped yet
  std::int64_t major = 0;  // and had to come from a disk
};
// Of the calling thread, since it started. 0 and 0 in an armed controller's periods.
[[nodiscard]] PageFaults page_faults_of_this_thread();

class RtThread {
 public:
  using Function = void (*)(void* context);

  RtThread() = default;
  ~RtThread();  // joins
  RtThread(const RtThread&) = delete;
  RtThread& operator=(const RtThread&) = delete;

  // Returns once the thread is placed and scheduled, about to call function(context), or has ended for the
  // error answered. Signals are blocked in it: they are the main thread's.
  [[nodiscard]] RtThreadError start(const RtThreadConfig& config, Function function, void* context);
  // Waits until the function has returned; at once where none runs.
  void join();

  [[nodiscard]] bool is_running() const { return running_; }  // started and not joined
  [[nodiscard]] Placement placement() const { return placement_; }
  [[nodiscard]] bool has_guard_page() const { return has_guard_; }
  [[nodiscard]] int last_errno() const { return errno_; }

  // How much of the stack was ever used since start(), the C library's part included, of stack_bytes(). From
  // inside the thread or after join(); reads the unused part, so not in every period.
  [[nodiscard]] std::size_t stack_high_water_bytes() const;
  [[nodiscard]] std::size_t stack_bytes() const { return stack_.size(); }  // without the guard page

 private:
  static void* enter(void* self);
  [[nodiscard]] bool lay_out(std::span<std::byte> memory);
  void unguard();
  [[nodiscard]] RtThreadError place_and_schedule();

  RtThreadConfig config_;
  Function function_ = nullptr;
  void* context_ = nullptr;
  std::span<std::byte> stack_;
  std::span<std::byte> guard_;
  pthread_t thread_{};
  sem_t settled_{};
  RtThreadError outcome_ = RtThreadError::kNone;
  Placement placement_ = Placement::kNotAsked;
  int errno_ = 0;
  bool has_guard_ = false;
  bool running_ = false;
};

}  // namespace vergence::rt
