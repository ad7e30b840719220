// Runs a step generator in virtual time, later than asked and with slow lines where wanted, and judges its
// pulses.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>

#include "hal/gpio_step/step_generator.hpp"

namespace vergence::testing {

// An edge began to change its line at begin_ns at the earliest, and was through at done_ns.
struct Edge {
  std::int64_t begin_ns;
  std::int64_t done_ns;
  step::StepLevels levels;
};

// Least times between edges, whatever their order.
class PulseJudge {
 public:
  explicit PulseJudge(const step::StepTiming& timing) : timing_(timing) {}

  void see(const Edge& edge) {
    const bool turns = edge.levels.forward != levels_.forward;
    const bool steps = edge.levels.step != levels_.step;
    EXPECT_NE(turns, steps) << "both lines at once";
    if (steps && edge.levels.step) {
      keep(edge.begin_ns - fallen_ns_, timing_.stepspace_ns, space_);
      keep(edge.begin_ns - turned_ns_, timing_.dirsetup_ns, setup_);
      risen_ns_ = edge.done_ns;
      steps_ += edge.levels.forward ? 1 : -1;
    } else if (steps) {
      keep(edge.begin_ns - risen_ns_, timing_.steplen_ns, length_);
      fallen_ns_ = edge.done_ns;
    } else {
      EXPECT_FALSE(edge.levels.step);
      keep(edge.begin_ns - fallen_ns_, timing_.dirhold_ns, hold_);
      turned_ns_ = edge.done_ns;
      ++turns_;
    }
    levels_ = edge.levels;
  }

  [[nodiscard]] std::int64_t steps() const { return steps_; }
  [[nodiscard]] int turns() const { return turns_; }
  // By how much each least time was kept, at the tightest.
  [[nodiscard]] std::int64_t least_margin_ns() const { return std::min({length_, space_, setup_, hold_}); }

 private:
  static void keep(std::int64_t time_ns, std::int64_t least_ns, std::int64_t& margin_ns) {
    EXPECT_GE(time_ns, least_ns);
    margin_ns = std::min(margin_ns, time_ns - least_ns);
  }

  static constexpr std::int64_t kLongAgo_ns = -1'000'000'000'000;
  static constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  step::StepTiming timing_;
  step::StepLevels levels_;
  std::int64_t risen_ns_ = kLongAgo_ns;
  std::int64_t fallen_ns_ = kLongAgo_ns;
  std::int64_t turned_ns_ = kLongAgo_ns;
  std::int64_t length_ = kMost;
  std::int64_t space_ = kMost;
  std::int64_t setup_ = kMost;
  std::int64_t hold_ = kMost;
  std::int64_t steps_ = 0;
  int turns_ = 0;
};

class StepBench {
 public:
  explicit StepBench(const step::StepTiming& timing, std::int64_t start_ns = 0) : now_ns(start_ns) {
    EXPECT_EQ(generator.configure(timing, now_ns), step::TimingError::kNone);
  }

  // Everything that is due before until_ns, each call so late and so slow as the functions say.
  void run_until(std::int64_t until_ns) {
    while (generator.next_event_ns() < until_ns) {
      now_ns = std::max(now_ns, generator.next_event_ns());
      if (late_ns) now_ns += late_ns();
      const step::StepLevels before = generator.levels();
      const step::StepLevels after = generator.advance(now_ns);
      if (after != before) {
        const std::int64_t begin_ns = now_ns;
        if (takes_ns) now_ns += takes_ns();
        generator.written(now_ns);
        if (on_edge) on_edge({begin_ns, now_ns, after});
      }
      if (after_event) after_event();
    }
    now_ns = std::max(now_ns, until_ns);
  }

  step::StepGenerator generator;
  std::int64_t now_ns;
  std::function<std::int64_t()> late_ns;
  std::function<std::int64_t()> takes_ns;
  std::function<void(const Edge&)> on_edge;
  std::function<void()> after_event;
};

}  // namespace vergence::testing
