// Threads on given stacks: where they run, how urgently, what they used; and what happens without the rights.
#include "hal/rt/rt_thread.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/rt/task_timing.hpp"
#include "tests/support/in_child.hpp"

namespace vergence::rt {
namespace {

using testing::drop_rights;
using testing::in_child;

// The thread sanitizer keeps a megabyte of its own on each stack.
RtStack<std::size_t{testing::kSanitized ? 2'048 : 256} * 1024> stack;

RtThreadConfig without_rights() {
  RtThreadConfig config;
  config.stack = stack.span();
  config.policy = RealtimePolicy::kIgnore;
  return config;
}

RtThreadConfig fifo(int priority) {
  RtThreadConfig config = without_rights();
  config.policy = RealtimePolicy::kEnforce;
  config.scheduling.priority = priority;
  return config;
}

// What a thread sees of itself.
struct Seen {
  std::array<char, 16> name{};
  int policy = -1;
  int priority = -1;
  int core = -1;
  bool terminate_is_blocked = false;
  int runs = 0;

  static void look(void* context) {
    Seen& seen = *static_cast<Seen*>(context);
    prctl(PR_GET_NAME, seen.name.data());
    seen.policy = sched_getscheduler(0);
    sched_param parameters{};
    sched_getparam(0, &parameters);
    seen.priority = parameters.sched_priority;
    seen.core = sched_getcpu();
    sigset_t blocked;
    pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
    seen.terminate_is_blocked = sigismember(&blocked, SIGTERM) == 1;
    ++seen.runs;
  }
};

int first_core_of_ours() {
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof cores, &cores) != 0) return -1;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(static_cast<std::size_t>(core), &cores)) return core;
  }
  return -1;
}

TEST(RtThread, RunsAFunctionOnceAndJoins) {
  RtThread thread;
  Seen seen;
  RtThreadConfig config = without_rights();
  config.name = "a_name_longer_than_the_kernel_keeps";
  for (int round = 1; round <= 3; ++round) {
    ASSERT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kNone);
    EXPECT_TRUE(thread.is_running());
    EXPECT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kRunning);
    thread.join();
    EXPECT_FALSE(thread.is_running());
    EXPECT_EQ(seen.runs, round);
  }
  thread.join();  // nothing to wait for
  EXPECT_STREQ(seen.name.data(), "a_name_longer_t");
  EXPECT_EQ(seen.policy, SCHED_OTHER);
  EXPECT_TRUE(seen.terminate_is_blocked);
  EXPECT_EQ(thread.placement(), Placement::kNotAsked);
  sigset_t ours;
  pthread_sigmask(SIG_SETMASK, nullptr, &ours);
  EXPECT_EQ(sigismember(&ours, SIGTERM), 0);
}

TEST(RtThread, LeavesScopeOnlyAfterItsThreadHasEnded) {
  std::atomic<int> done = 0;
  {
    RtThread thread;
    ASSERT_EQ(thread.start(
                  without_rights(),
                  [](void* context) {
                    sleep_until(MonotonicClock{}.now_ns() + 20'000'000);
                    static_cast<std::atomic<int>*>(context)->store(1);
                  },
                  &done),
              RtThreadError::kNone);
  }
  EXPECT_EQ(done.load(), 1);
}

TEST(RtThread, IsPinnedWhereTheCoreIsThere) {
  const int core = first_core_of_ours();
  ASSERT_GE(core, 0);
  RtThread thread;
  Seen seen;
  RtThreadConfig config = without_rights();
  config.core = core;
  ASSERT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kNone);
  thread.join();
  EXPECT_EQ(thread.placement(), Placement::kPinned);
  EXPECT_EQ(seen.core, core);
}

TEST(RtThread, RunsAnywhereOnAMachineOfFewerCores) {
  for (const int core : {900, 5'000}) {
    RtThread thread;
    Seen seen;
    RtThreadConfig config = without_rights();
    config.core = core;
    ASSERT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kNone);
    thread.join();
    EXPECT_EQ(thread.placement(), Placement::kFewerCores);
    EXPECT_EQ(seen.runs, 1);
  }
}

// Without inlining, a frame of so many bytes below the caller's, all written.
template <std::size_t Bytes>
[[gnu::noinline]] int use_stack() {
  std::array<volatile char, Bytes> frame;
  for (std::size_t i = 0; i < Bytes; ++i) frame[i] = static_cast<char>(i);
  return frame[Bytes / 2];
}

struct Usage {
  const RtThread* thread = nullptr;
  std::size_t before = 0;
  std::size_t after = 0;
};

template <std::size_t Bytes>
Usage measure_use(RtThread& thread) {
  Usage usage;
  usage.thread = &thread;
  EXPECT_EQ(thread.start(
                without_rights(),
                [](void* context) {
                  Usage& use = *static_cast<Usage*>(context);
                  use.before = use.thread->stack_high_water_bytes();
                  (void)use_stack<Bytes>();
                  use.after = use.thread->stack_high_water_bytes();
                },
                &usage),
            RtThreadError::kNone);
  thread.join();
  return usage;
}

TEST(RtThread, TheStacksHighWaterGrowsByWhatIsUsed) {
  RtThread thread;
  constexpr std::size_t kLittle = 20'000;
  constexpr std::size_t kMuch = 120'000;
  constexpr std::size_t kFrames = 4'096;  // of the calls around it
  const Usage little = measure_use<kLittle>(thread);
  EXPECT_GT(little.before, 0U);
  EXPECT_GE(little.after, kLittle);
  EXPECT_LE(little.after, little.before + kLittle + kFrames);
  EXPECT_EQ(thread.stack_high_water_bytes(), little.after);
  const Usage much = measure_use<kMuch>(thread);
  EXPECT_GE(much.after, little.after + kMuch - kLittle - kFrames);
  EXPECT_LE(much.after, little.after + kMuch - kLittle + kFrames);
  // Painted anew.
  EXPECT_LE(measure_use<kLittle>(thread).after, little.after + kFrames);
  EXPECT_LT(much.after, thread.stack_bytes());
}

TEST(RtThread, TheGuardPageEndsAProcessThatOverflows) {
  const int status = in_child([] {
    rlimit no_core{};
    setrlimit(RLIMIT_CORE, &no_core);
    RtThread thread;
    const RtThreadError error = thread.start(
        without_rights(), [](void* context) { *static_cast<volatile std::byte*>(context) = std::byte{1}; },
        stack.bytes.data());
    thread.join();
    return error == RtThreadError::kNone ? 0 : 1;
  });
  EXPECT_EQ(status, -SIGSEGV);
  // Once it is joined, the memory is the caller's.
  RtThread thread;
  Seen seen;
  ASSERT_EQ(thread.start(without_rights(), Seen::look, &seen), RtThreadError::kNone);
  EXPECT_TRUE(thread.has_guard_page());
  thread.join();
  stack.bytes[0] = std::byte{1};
}

TEST(RtThread, TakesMemoryOfAnyAlignment) {
  for (const std::size_t offset : {1, 8, 100, 4'095}) {
    RtThread thread;
    Seen seen;
    RtThreadConfig config = without_rights();
    config.stack = stack.span().subspan(offset, stack.bytes.size() - 8'000);
    ASSERT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kNone) << offset;
    EXPECT_TRUE(thread.has_guard_page());
    thread.join();
    EXPECT_EQ(seen.runs, 1);
    EXPECT_LT(thread.stack_bytes(), config.stack.size());
  }
}

TEST(RtThread, RefusesWhatCannotWork) {
  RtThread thread;
  Seen seen;
  RtThreadConfig config = without_rights();
  config.stack = stack.span().first(4'096);
  EXPECT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kStackTooSmall);
  config.stack = {};
  EXPECT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kStackTooSmall);
  for (const int priority : {-1, 0, 100}) {
    EXPECT_EQ(thread.start(fifo(priority), Seen::look, &seen), RtThreadError::kBadScheduling);
  }
  config = fifo(1);
  config.scheduling.kind = SchedulingKind::kDeadline;
  for (const auto& [runtime, deadline, period] :
       std::vector<std::array<std::int64_t, 3>>{{0, 1, 1}, {2, 1, 3}, {1, 3, 2}}) {
    config.scheduling.runtime_ns = runtime * 1'000'000;
    config.scheduling.deadline_ns = deadline * 1'000'000;
    config.scheduling.period_ns = period * 1'000'000;
    EXPECT_EQ(thread.start(config, Seen::look, &seen), RtThreadError::kBadScheduling);
  }
  EXPECT_FALSE(thread.is_running());
  EXPECT_EQ(seen.runs, 0);
}

TEST(RtThread, WithoutTheRightsItStartsOnlyWhereThatIsIgnored) {
  enum : int {
    kAsExpected,
    kRights,
    kStarted,
    kErrno,
    kRan,
    kIgnoreFailed,
  };
  const int status = in_child([] {
    const rlimit none{};
    if (setrlimit(RLIMIT_RTPRIO, &none) != 0 || !drop_rights()) return int{kRights};
    RtThread thread;
    Seen seen;
    if (thread.start(fifo(10), Seen::look, &seen) != RtThreadError::kNotPermitted) return int{kStarted};
    if (thread.last_errno() != EPERM || thread.is_running()) return int{kErrno};
    if (seen.runs != 0) return int{kRan};
    if (thread.start(without_rights(), Seen::look, &seen) != RtThreadError::kNone) return int{kIgnoreFailed};
    thread.join();
    return seen.runs == 1 ? int{kAsExpected} : int{kIgnoreFailed};
  });
  EXPECT_EQ(status, kAsExpected);
}

TEST(RtThread, HasItsPriorityWhereThatIsGranted) {
  RtThread thread;
  Seen seen;
  const RtThreadError error = thread.start(fifo(33), Seen::look, &seen);
  thread.join();
  if (error == RtThreadError::kNotPermitted) GTEST_SKIP() << describe(error);
  ASSERT_EQ(error, RtThreadError::kNone);
  EXPECT_EQ(seen.policy, SCHED_FIFO);
  EXPECT_EQ(seen.priority, 33);
}

TEST(RtThread, HasItsDeadlineWhereThatIsGranted) {
  RtThread thread;
  Seen seen;
  RtThreadConfig config = fifo(1);
  config.core = 0;
  config.scheduling = {SchedulingKind::kDeadline, 0, 200'000, 1'000'000, 2'000'000};
  const RtThreadError error = thread.start(config, Seen::look, &seen);
  thread.join();
  if (error == RtThreadError::kNotPermitted || error == RtThreadError::kNotAdmitted) {
    GTEST_SKIP() << describe(error);
  }
  ASSERT_EQ(error, RtThreadError::kNone);
  constexpr int kSchedDeadline = 6;
  EXPECT_EQ(seen.policy, kSchedDeadline);
  EXPECT_EQ(thread.placement(), Placement::kByKernel);
}

struct FaultCounts {
  volatile char* pages = nullptr;
  std::int64_t first = 0;
  std::int64_t second = 0;
  static constexpr std::size_t kBytes = std::size_t{64} * 4096;

  static void count(void* context) {
    FaultCounts& counts = *static_cast<FaultCounts*>(context);
    const auto touch = [&counts] {
      const PageFaults before = page_faults_of_this_thread();
      for (std::size_t i = 0; i < kBytes; i += 4096) counts.pages[i] = 1;
      return page_faults_of_this_thread().minor - before.minor;
    };
    counts.first = touch();
    counts.second = touch();
  }
};

TEST(RtThread, CountsItsPageFaults) {
  void* memory =
      mmap(nullptr, FaultCounts::kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  FaultCounts counts;
  counts.pages = static_cast<volatile char*>(memory);
  RtThread thread;
  ASSERT_EQ(thread.start(without_rights(), FaultCounts::count, &counts), RtThreadError::kNone);
  thread.join();
  EXPECT_GT(counts.first, 0);
  EXPECT_LT(counts.second, counts.first);
  munmap(memory, FaultCounts::kBytes);
}

struct PeriodicTask {
  std::atomic<bool> stop = false;
  TaskTiming timing{{1'000'000, 1'000'000}};
  std::int64_t worst_early_ns = 0;

  static void run(void* context) {
    PeriodicTask& task = *static_cast<PeriodicTask*>(context);
    MonotonicClock clock;
    MonotonicSleeper sleeper;
    PeriodicSchedule schedule(clock.now_ns() + 1'000'000, 1'000'000);
    run_periodic(clock, sleeper, schedule, task.timing, task.stop, [&task](const Release& release) {
      task.worst_early_ns = std::max(task.worst_early_ns, release.release_ns - release.now_ns);
      if (task.timing.runs() == 20) task.stop = true;
    });
  }
};

TEST(RtThread, RunsAPeriodicTaskInRealTime) {
  RtThread thread;
  PeriodicTask task;
  ASSERT_EQ(thread.start(without_rights(), PeriodicTask::run, &task), RtThreadError::kNone);
  thread.join();
  EXPECT_EQ(task.timing.runs(), 20U);
  EXPECT_EQ(task.worst_early_ns, 0);
}

TEST(RtThread, EveryErrorHasItsOwnWords) {
  std::set<std::string> words;
  for (int i = 0; i <= static_cast<int>(RtThreadError::kNotSupported); ++i) {
    words.insert(describe(static_cast<RtThreadError>(i)));
  }
  for (int i = 0; i <= static_cast<int>(Placement::kByKernel); ++i) {
    words.insert(describe(static_cast<Placement>(i)));
  }
  EXPECT_EQ(words.size(), static_cast<std::size_t>(RtThreadError::kNotSupported) + 1 +
                              static_cast<std::size_t>(Placement::kByKernel) + 1);
}

}  // namespace
}  // namespace vergence::rt
