// How a task waits: until an absolute instant, so that what it does itself never adds to its period; and the
// loop of a periodic task around it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <concepts>
#include <cstdint>
#include <ctime>

#include "hal/clock.hpp"
#include "hal/rt/periodic_schedule.hpp"

namespace vergence::rt {

// In the time of MonotonicClock; at once where that has passed. Signals do not shorten it.
inline void sleep_until(std::int64_t monotonic_ns) {
  const std::int64_t ns = std::max<std::int64_t>(monotonic_ns, 0);
  const timespec until{static_cast<std::time_t>(ns / kNsPerSecond), static_cast<long>(ns % kNsPerSecond)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

template <typename T>
concept Sleeper = requires(T& sleeper, std::int64_t ns) {
  sleeper.sleep_until(ns);
};

struct MonotonicSleeper {
  void sleep_until(std::int64_t ns) { rt::sleep_until(ns); }
};

static_assert(Sleeper<MonotonicSleeper>);

// TaskTiming or TimingRecord.
template <typename T>
concept Timing = requires(T& timing, std::int64_t ns) {
  timing.began(ns, ns);
  { timing.ended(ns) } -> std::same_as<bool>;
};

// A run of a periodic task.
struct Release {
  std::int64_t release_ns = 0;  // on the grid, at most one period ago
  std::int64_t now_ns = 0;      // when it woke
  std::int64_t skipped = 0;     // periods lost since the last run
};

// Runs body(Release) once a period until `stop`, which is looked at once a period, after the sleep. `timing`
// is complete for the run before when body reads it. Lateness is measured from the instant that was slept
// for, even where the wake-up is so late that body gets a later release.
template <Clock C, Sleeper S, Timing T, typename Body>
void run_periodic(C& clock, S& sleeper, PeriodicSchedule& schedule, T& timing, const std::atomic<bool>& stop,
                  Body&& body) {
  std::int64_t skipped = 0;
  while (true) {
    const std::int64_t slept_for_ns = schedule.next_release_ns();
    sleeper.sleep_until(slept_for_ns);
    if (stop.load(std::memory_order_acquire)) return;
    const std::int64_t now_ns = clock.now_ns();
    skipped += schedule.skip_passed(now_ns);
    timing.began(slept_for_ns, now_ns);
    body(Release{schedule.next_release_ns(), now_ns, skipped});
    const std::int64_t ended_ns = clock.now_ns();
    (void)timing.ended(ended_ns);
    skipped = schedule.advance(ended_ns);
  }
}

}  // namespace vergence::rt
