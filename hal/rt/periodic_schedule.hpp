// When a periodic task is released: on a grid that never moves, whatever is late. Periods that have passed
// wholly are skipped and counted, never made up for by runs in a burst; the one that has begun is run late.
// Knows no clock.
#pragma once

#include <cstdint>
#include <type_traits>

namespace vergence::rt {

class PeriodicSchedule {
 public:
  // First release at start_ns. The period must be positive.
  PeriodicSchedule(std::int64_t start_ns, std::int64_t period_ns)
      : next_ns_(start_ns), period_ns_(period_ns > 0 ? period_ns : 1) {}

  [[nodiscard]] std::int64_t next_release_ns() const { return next_ns_; }
  [[nodiscard]] std::int64_t period_ns() const { return period_ns_; }
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

  // Passes over releases whose period is over by now; answers how many. On waking, before the run.
  std::int64_t skip_passed(std::int64_t now_ns) {
    const std::int64_t late_ns = now_ns - next_ns_;
    if (late_ns < period_ns_) return 0;
    const std::int64_t passed = late_ns / period_ns_;
    next_ns_ += passed * period_ns_;
    skipped_ += static_cast<std::uint64_t>(passed);
    return passed;
  }
  // The run released at next_release_ns() has ended by now; answers how many releases were passed over.
  std::int64_t advance(std::int64_t now_ns) {
    next_ns_ += period_ns_;
    return skip_passed(now_ns);
  }

 private:
  std::int64_t next_ns_;
  std::int64_t period_ns_;
  std::uint64_t skipped_ = 0;
};

static_assert(std::is_trivially_copyable_v<PeriodicSchedule>);

}  // namespace vergence::rt
