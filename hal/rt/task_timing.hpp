// How punctual a task is: lateness of its wake-ups, time it takes, deadlines it misses, periods it loses.
// Knows no clock; whoever runs the task says when it began and ended. Values only, so it can be published as
// it is.
#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "hal/rt/duration_histogram.hpp"

namespace vergence::rt {

struct TimingLimits {
  std::int64_t period_ns = 0;    // 0: the task has none, and loses none
  std::int64_t deadline_ns = 0;  // from its release; 0: it has none, and misses none
};

class TaskTiming {
 public:
  TaskTiming() = default;
  explicit TaskTiming(const TimingLimits& limits) : limits_(limits) {}

  // Released at the instant it slept for, running since now.
  void began(std::int64_t release_ns, std::int64_t now_ns) {
    if (runs_ > 0 && limits_.period_ns > 0) {
      // Half a period of tolerance, for releases that are not on one grid.
      const std::int64_t periods = (release_ns - release_ns_ + limits_.period_ns / 2) / limits_.period_ns;
      if (periods > 1) lost_periods_ += static_cast<std::uint64_t>(periods - 1);
    }
    ++runs_;
    release_ns_ = release_ns;
    began_ns_ = now_ns;
    latency_ns_ = std::max<std::int64_t>(now_ns - release_ns, 0);
    worst_latency_ns_ = std::max(worst_latency_ns_, latency_ns_);
  }

  // Answers whether the deadline was kept.
  bool ended(std::int64_t now_ns) {
    execution_ns_ = std::max<std::int64_t>(now_ns - began_ns_, 0);
    worst_execution_ns_ = std::max(worst_execution_ns_, execution_ns_);
    response_ns_ = std::max<std::int64_t>(now_ns - release_ns_, 0);
    worst_response_ns_ = std::max(worst_response_ns_, response_ns_);
    const bool kept = limits_.deadline_ns <= 0 || response_ns_ <= limits_.deadline_ns;
    if (kept) {
      misses_in_a_row_ = 0;
    } else {
      ++misses_;
      ++misses_in_a_row_;
      worst_misses_in_a_row_ = std::max(worst_misses_in_a_row_, misses_in_a_row_);
    }
    return kept;
  }

  [[nodiscard]] const TimingLimits& limits() const { return limits_; }
  [[nodiscard]] std::uint64_t runs() const { return runs_; }
  [[nodiscard]] std::int64_t release_ns() const { return release_ns_; }
  // Of the last run: from its release to its first instruction, from there to its end, and both together.
  [[nodiscard]] std::int64_t latency_ns() const { return latency_ns_; }
  [[nodiscard]] std::int64_t execution_ns() const { return execution_ns_; }
  [[nodiscard]] std::int64_t response_ns() const { return response_ns_; }
  [[nodiscard]] std::int64_t worst_latency_ns() const { return worst_latency_ns_; }
  [[nodiscard]] std::int64_t worst_execution_ns() const { return worst_execution_ns_; }
  [[nodiscard]] std::int64_t worst_response_ns() const { return worst_response_ns_; }
  // Whole periods in which the task was not released, because it or its wake-up was late.
  [[nodiscard]] std::uint64_t lost_periods() const { return lost_periods_; }
  [[nodiscard]] std::uint64_t misses() const { return misses_; }
  [[nodiscard]] std::uint32_t misses_in_a_row() const { return misses_in_a_row_; }
  [[nodiscard]] std::uint32_t worst_misses_in_a_row() const { return worst_misses_in_a_row_; }

 private:
  TimingLimits limits_;
  std::uint64_t runs_ = 0;
  std::uint64_t lost_periods_ = 0;
  std::uint64_t misses_ = 0;
  std::uint32_t misses_in_a_row_ = 0;
  std::uint32_t worst_misses_in_a_row_ = 0;
  std::int64_t release_ns_ = 0;
  std::int64_t began_ns_ = 0;
  std::int64_t latency_ns_ = 0;
  std::int64_t execution_ns_ = 0;
  std::int64_t response_ns_ = 0;
  std::int64_t worst_latency_ns_ = 0;
  std::int64_t worst_execution_ns_ = 0;
  std::int64_t worst_response_ns_ = 0;
};

static_assert(std::is_trivially_copyable_v<TaskTiming>);

// The same with the whole distributions, 10 kB: for measurements, or beside what is published each period.
struct TimingRecord {
  TaskTiming timing;
  DurationHistogram latency;
  DurationHistogram execution;

  void began(std::int64_t release_ns, std::int64_t now_ns) {
    timing.began(release_ns, now_ns);
    latency.add(timing.latency_ns());
  }
  bool ended(std::int64_t now_ns) {
    const bool kept = timing.ended(now_ns);
    execution.add(timing.execution_ns());
    return kept;
  }
};

static_assert(std::is_trivially_copyable_v<TimingRecord>);

}  // namespace vergence::rt
