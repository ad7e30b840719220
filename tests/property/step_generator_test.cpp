// Step pulses: whatever is commanded, and however late the edges are made, no least time is broken; the steps
// are the integral of the ramped rate.
#include "hal/gpio_step/step_generator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>

#include "tests/support/random.hpp"
#include "tests/support/step_bench.hpp"

namespace vergence::step {
namespace {

using testing::Edge;
using testing::PulseJudge;
using testing::Random;
using testing::StepBench;

std::int64_t about(Random& random, double middle, int doublings, std::int64_t least, std::int64_t most) {
  return std::clamp(static_cast<std::int64_t>(random.about(middle, doublings)), least, most);
}

// Any that check() admits, its limits among them.
StepTiming any_timing(Random& random) {
  StepTiming timing;
  timing.steplen_ns = about(random, 10'000, 6, kShortestPulse_ns, kLongestPulse_ns);
  timing.stepspace_ns = about(random, 10'000, 6, kShortestPulse_ns, kLongestPulse_ns);
  timing.dirsetup_ns = random.below(4) == 0 ? 0 : about(random, 20'000, 6, 0, kLongestPulse_ns);
  timing.dirhold_ns = random.below(4) == 0 ? 0 : about(random, 20'000, 6, 0, kLongestPulse_ns);
  timing.ramp_ns = about(random, 400'000, 3, 1'000, kLongestRamp_ns);
  timing.jitter_ns = random.below(4) == 0 ? 0 : about(random, 20'000, 1, 0, timing.ramp_ns);
  timing.max_rate_millisteps_per_s = about(random, 2e7, 4, 1, fastest_rate_millisteps_per_s(timing));
  // At least a thousandth of a step a second each time.
  const std::int64_t least = (1'000'000'000 + timing.ramp_ns - 1) / timing.ramp_ns;
  timing.acceleration_millisteps_per_s2 =
      about(random, 2e9, 6, least, kFastestAcceleration_millisteps_per_s2);
  return timing;
}

std::int64_t any_rate(Random& random, const StepTiming& timing) {
  const std::int64_t most = timing.max_rate_millisteps_per_s;
  switch (random.below(5)) {
    case 0: return most;
    case 1: return -most;
    case 2: return 0;
    case 3: return random.below(2001) - 1000;
    default: return static_cast<std::int64_t>(random.between(-1, 1) * static_cast<double>(most));
  }
}

// The staircase that is asked for, and its integral in 1e-12 steps, kept apart from the generator.
class Staircase {
 public:
  explicit Staircase(const StepTiming& timing) : timing_(timing) {}

  void command(std::int64_t now_ns, std::int64_t target) {
    go_to(now_ns);
    if (rate_ == target_) next_ns_ = std::max(now_ns, changed_ns_ + timing_.ramp_ns);
    target_ = target;
  }
  void go_to(std::int64_t now_ns) {
    const std::int64_t most = timing_.acceleration_millisteps_per_s2 * timing_.ramp_ns / 1'000'000'000;
    while (rate_ != target_ && next_ns_ <= now_ns) {
      phase_ += static_cast<__int128>(rate_) * (next_ns_ - t_ns_);
      t_ns_ = changed_ns_ = next_ns_;
      next_ns_ += timing_.ramp_ns;
      if (target_ > rate_) {
        rate_ = std::min(target_, rate_ + most);
      } else {
        rate_ = std::max(target_, rate_ - most);
      }
    }
    phase_ += static_cast<__int128>(rate_) * (now_ns - t_ns_);
    t_ns_ = now_ns;
  }
  // How far `steps` are from the integral, in 1e-12 steps.
  [[nodiscard]] std::int64_t off(std::int64_t steps) const {
    const __int128 off = phase_ - static_cast<__int128>(steps) * kPhasePerStep;
    return static_cast<std::int64_t>(off < 0 ? -off : off);
  }
  [[nodiscard]] std::int64_t rate() const { return rate_; }

 private:
  StepTiming timing_;
  std::int64_t rate_ = 0;
  std::int64_t target_ = 0;
  std::int64_t t_ns_ = 0;
  std::int64_t changed_ns_ = -1'000'000'000;
  std::int64_t next_ns_ = 0;
  __int128 phase_ = 0;
};

// On time, late within the jitter, and far too late, with lines that take their time. Nor does a motor ever
// step faster than its maximum, but for the jitter of one edge.
TEST(StepGenerator, KeepsEveryLeastTime) {
  Random random(1);
  std::int64_t steps = 0;
  int turns = 0;
  std::int64_t least_margin_ns = 1'000'000;
  for (int run = 0; run < 400; ++run) {
    const StepTiming timing = any_timing(random);
    ASSERT_EQ(check(timing), TimingError::kNone);
    StepBench bench(timing);
    PulseJudge judge(timing);
    const int mood = run % 4;
    bench.late_ns = [&]() -> std::int64_t {
      if (mood == 0) return 0;
      if (mood == 3 && random.below(20) == 0) return random.below(3'000'000);
      return timing.jitter_ns == 0 ? 0 : random.below(static_cast<int>(timing.jitter_ns) + 1);
    };
    bench.takes_ns = [&]() -> std::int64_t { return mood < 2 ? 0 : random.below(30'000); };
    const std::int64_t least_period_ns =
        kPhasePerStep / timing.max_rate_millisteps_per_s - timing.jitter_ns - 1;
    std::int64_t risen_ns = -kPhasePerStep;
    bench.on_edge = [&](const Edge& edge) {
      judge.see(edge);
      if (!edge.levels.step) return;
      ++steps;
      EXPECT_GE(edge.begin_ns - risen_ns, least_period_ns);
      risen_ns = edge.begin_ns;
    };
    for (int command = 0; command < 30; ++command) {
      EXPECT_TRUE(bench.generator.command(bench.now_ns, any_rate(random, timing)));
      if (random.below(10) == 0) bench.generator.halt();
      bench.run_until(bench.now_ns + random.below(20'000'000));
    }
    EXPECT_EQ(judge.steps(), bench.generator.position_steps());
    turns += judge.turns();
    least_margin_ns = std::min(least_margin_ns, judge.least_margin_ns());
    if (::testing::Test::HasFailure()) FAIL() << "run " << run;
  }
  EXPECT_GT(steps, 50'000);
  EXPECT_GT(turns, 1'000);
  EXPECT_EQ(least_margin_ns, 0);  // no more is waited than needed
}

// Runs random commands and compares the steps with the integral after each event.
struct IntegralRun {
  StepTiming timing;
  bool late = false;
  std::function<std::int64_t(int)> rate;          // of a command
  std::function<std::int64_t()> next_command_ns;  // after the last
};

std::int64_t run_integral(Random& random, const IntegralRun& run) {
  const StepTiming& timing = run.timing;
  StepBench bench(timing);
  Staircase staircase(timing);
  bench.run_until(timing.dirsetup_ns);  // the direction is as it is since the start
  if (run.late) bench.late_ns = [&] { return random.below(static_cast<int>(timing.jitter_ns) + 1); };
  const std::int64_t slack = timing.max_rate_millisteps_per_s * (run.late ? 2 * timing.jitter_ns + 1 : 1);
  std::int64_t steps = 0;
  bench.on_edge = [&](const Edge& edge) { steps += edge.levels.step ? 1 : 0; };
  bench.after_event = [&] {
    staircase.go_to(bench.now_ns);
    EXPECT_LE(staircase.off(bench.generator.position_steps()), kPhasePerStep + slack);
  };
  for (int command = 0; command < 30; ++command) {
    const std::int64_t rate = run.rate(command);
    staircase.command(bench.now_ns, rate);
    EXPECT_TRUE(bench.generator.command(bench.now_ns, rate));
    bench.run_until(bench.now_ns + run.next_command_ns());
  }
  EXPECT_EQ(bench.generator.delay_ns(), 0);
  return steps;
}

// An edge within the jitter may be late, but the next ones do not inherit it.
TEST(StepGenerator, IssuesTheIntegralOfTheRampedRateOneWay) {
  Random random(2);
  std::int64_t steps = 0;
  for (int run = 0; run < 200; ++run) {
    IntegralRun one_way;
    one_way.timing = any_timing(random);
    one_way.late = run % 2 == 1;
    one_way.rate = [&](int) { return std::abs(any_rate(random, one_way.timing)); };
    one_way.next_command_ns = [&] { return random.below(20'000'000); };
    steps += run_integral(random, one_way);
    if (::testing::Test::HasFailure()) FAIL() << "run " << run;
  }
  EXPECT_GT(steps, 50'000);
}

TEST(StepGenerator, IssuesTheIntegralOfTheRampedRateBothWays) {
  Random random(6);
  std::int64_t steps = 0;
  for (int run = 0; run < 200; ++run) {
    IntegralRun both_ways;
    both_ways.timing = any_timing(random);
    both_ways.timing.dirsetup_ns = 0;  // otherwise steps may have to wait
    both_ways.timing.dirhold_ns = 0;
    both_ways.rate = [&](int) { return any_rate(random, both_ways.timing); };
    both_ways.next_command_ns = [&] { return random.below(20'000'000); };
    steps += run_integral(random, both_ways);
    if (::testing::Test::HasFailure()) FAIL() << "run " << run;
  }
  EXPECT_GT(steps, 50'000);
}

// With time to turn: no step the other way is due sooner than a period after the rate's sign changed, if some
// steps were made between the changes.
TEST(StepGenerator, IssuesTheIntegralOfTheRampedRateWhereItHasTimeToTurn) {
  Random random(7);
  std::int64_t steps = 0;
  for (int run = 0; run < 200; ++run) {
    IntegralRun turning;
    turning.timing = any_timing(random);
    turning.late = run % 2 == 1;
    StepTiming& timing = turning.timing;
    const std::int64_t turn_ns =
        timing.steplen_ns + timing.dirhold_ns + timing.dirsetup_ns + 4 * timing.jitter_ns;
    std::int64_t& most = timing.max_rate_millisteps_per_s;
    most = std::min(most, kPhasePerStep / turn_ns);
    timing.acceleration_millisteps_per_s2 =
        std::clamp(timing.acceleration_millisteps_per_s2, 100 * most, 10'000 * most);
    turning.rate = [&](int command) {
      const auto rate = static_cast<std::int64_t>(random.between(0.25, 1) * static_cast<double>(most));
      return command % 2 == 0 ? rate : -rate;
    };
    turning.next_command_ns = [&] { return 40'000'000 + 16 * kPhasePerStep / most; };
    if (check(timing) != TimingError::kNone) continue;
    steps += run_integral(random, turning);
    if (::testing::Test::HasFailure()) FAIL() << "run " << run;
  }
  EXPECT_GT(steps, 50'000);
}

TEST(StepGenerator, KeepsItsAccelerationAndEndsAtTheCommandedRate) {
  Random random(3);
  for (int run = 0; run < 200; ++run) {
    const StepTiming timing = any_timing(random);
    const std::int64_t most = ramp_step_millisteps_per_s(timing);
    StepBench bench(timing);
    std::int64_t changed_ns = -1'000'000'000;
    std::int64_t rate = 0;
    bench.after_event = [&] {
      const std::int64_t now_rate = bench.generator.rate_millisteps_per_s();
      if (now_rate == rate) return;
      EXPECT_LE(std::abs(now_rate - rate), most);
      EXPECT_GE(bench.now_ns - changed_ns, timing.ramp_ns);
      changed_ns = bench.now_ns;
      rate = now_rate;
    };
    std::int64_t target = 0;
    for (int command = 0; command < 60; ++command) {
      target = any_rate(random, timing);
      (void)bench.generator.command(bench.now_ns, target);
      // Often long before the ramp is through, and more often than the rate may change.
      bench.run_until(bench.now_ns + random.below(command % 2 == 0 ? 100'000 : 5'000'000));
    }
    const std::int64_t changes = 2 * timing.max_rate_millisteps_per_s / most + 2;
    bench.run_until(bench.now_ns + changes * timing.ramp_ns);
    EXPECT_EQ(bench.generator.rate_millisteps_per_s(), target);
  }
}

TEST(StepGenerator, DoesNotDriftOverTenMillionSteps) {
  StepTiming timing;
  timing.jitter_ns = 20'000;
  timing.max_rate_millisteps_per_s = 20'000'000;
  timing.acceleration_millisteps_per_s2 = 50'000'000'000;
  StepBench bench(timing);
  Staircase staircase(timing);
  Random random(4);
  bench.late_ns = [&] { return random.below(20'001); };
  constexpr std::int64_t kRate = 12'345'679;  // whose period is no whole number of ns
  staircase.command(0, kRate);
  ASSERT_TRUE(bench.generator.command(0, kRate));
  const std::int64_t end_ns = kPhasePerStep / kRate * 10'000'500;
  bench.run_until(end_ns);
  staircase.go_to(end_ns);
  EXPECT_GE(bench.generator.position_steps(), 10'000'000);
  EXPECT_LE(staircase.off(bench.generator.position_steps()), kPhasePerStep + kRate * 20'001);
  EXPECT_EQ(bench.generator.late_events(), 0U);
}

TEST(StepGenerator, SustainsTheMaximumRateWithEveryEdgeLateByTheJitter) {
  StepTiming timing;
  timing.jitter_ns = 50'000;
  timing.steplen_ns = 7'000;
  timing.stepspace_ns = 3'000;
  timing.max_rate_millisteps_per_s = fastest_rate_millisteps_per_s(timing);
  EXPECT_EQ(timing.max_rate_millisteps_per_s, 9'090'909);
  StepBench bench(timing);
  PulseJudge judge(timing);
  Staircase staircase(timing);
  bench.late_ns = [&] { return timing.jitter_ns; };
  bench.on_edge = [&](const Edge& edge) { judge.see(edge); };
  staircase.command(0, timing.max_rate_millisteps_per_s);
  ASSERT_TRUE(bench.generator.command(0, timing.max_rate_millisteps_per_s));
  bench.run_until(10'000'000'000);
  staircase.go_to(10'000'000'000);
  EXPECT_LE(staircase.off(bench.generator.position_steps()), 2 * kPhasePerStep);
  EXPECT_GT(bench.generator.position_steps(), 80'000);
  EXPECT_EQ(bench.generator.late_events(), 0U);
}

// Whatever the lateness: two steps are never closer than their period less the jitter.
TEST(StepGenerator, DoesNotCatchUpInABurst) {
  Random random(5);
  StepTiming timing;
  timing.jitter_ns = 50'000;
  StepBench bench(timing);
  std::int64_t lateness_ns = 0;
  std::int64_t expected_delay_ns = 0;
  std::uint64_t late = 0;
  bench.late_ns = [&] {
    lateness_ns = random.below(50) == 0 ? random.below(40'000'000) : random.below(50'001);
    if (lateness_ns > timing.jitter_ns) {
      ++late;
      expected_delay_ns += lateness_ns - timing.jitter_ns;
    }
    return lateness_ns;
  };
  ASSERT_TRUE(bench.generator.command(0, 2'000'000));
  bench.run_until(1'000'000'000);
  ASSERT_EQ(bench.generator.rate_millisteps_per_s(), 2'000'000);
  std::int64_t risen_ns = bench.now_ns - 1'000'000'000;
  bench.on_edge = [&](const Edge& edge) {
    if (!edge.levels.step) return;
    EXPECT_GE(edge.begin_ns - risen_ns, 500'000 - 50'000);
    risen_ns = edge.begin_ns;
  };
  bench.run_until(20'000'000'000);
  EXPECT_GT(late, 100U);
  EXPECT_EQ(bench.generator.late_events(), late);
  EXPECT_EQ(bench.generator.delay_ns(), expected_delay_ns);
}

// Lines that hang for longer than the phase could be counted: the motion waits for them.
TEST(StepGenerator, LinesThatHangDelayTheMotion) {
  StepTiming timing;
  timing.steplen_ns = kShortestPulse_ns;
  timing.stepspace_ns = kShortestPulse_ns;
  timing.dirsetup_ns = 0;
  timing.jitter_ns = 0;
  timing.max_rate_millisteps_per_s = fastest_rate_millisteps_per_s(timing);
  timing.acceleration_millisteps_per_s2 = kFastestAcceleration_millisteps_per_s2;
  StepBench bench(timing);
  PulseJudge judge(timing);
  Staircase staircase(timing);
  ASSERT_TRUE(bench.generator.command(0, timing.max_rate_millisteps_per_s));
  staircase.command(0, timing.max_rate_millisteps_per_s);
  std::uint64_t edges = 0;
  std::uint64_t hung = 0;
  const auto hangs = [&] { return edges % 1000 == 999; };
  bench.takes_ns = [&]() -> std::int64_t { return hangs() ? 10'000'000'000 : 0; };
  bench.on_edge = [&](const Edge& edge) {
    if (hangs()) ++hung;
    ++edges;
    judge.see(edge);
  };
  while (edges < 20'000) bench.run_until(bench.now_ns + 1'000'000);
  EXPECT_EQ(hung, 20U);
  EXPECT_EQ(bench.generator.late_events(), hung);
  EXPECT_EQ(bench.generator.delay_ns(), static_cast<std::int64_t>(hung) * 10'000'000'000);
  staircase.go_to(bench.now_ns - bench.generator.delay_ns());
  EXPECT_LE(staircase.off(bench.generator.position_steps()), kPhasePerStep);
}

// Where the acceleration is so high that a change of the rate is a multiple of the maximum, and the direction
// line slow: what fell due meanwhile must not come as a burst.
TEST(StepGenerator, DoesNotCatchUpWithWhatFellDueWhileTurning) {
  StepTiming timing;
  timing.ramp_ns = kLongestRamp_ns;
  timing.jitter_ns = kLongestRamp_ns;
  timing.dirsetup_ns = kLongestPulse_ns;
  timing.dirhold_ns = kLongestPulse_ns;
  timing.acceleration_millisteps_per_s2 = kFastestAcceleration_millisteps_per_s2;
  timing.max_rate_millisteps_per_s = fastest_rate_millisteps_per_s(timing);
  const std::int64_t period_ns = kPhasePerStep / timing.max_rate_millisteps_per_s;
  StepBench bench(timing);
  std::int64_t risen_ns = -kPhasePerStep;
  int steps = 0;
  bench.on_edge = [&](const Edge& edge) {
    if (!edge.levels.step) return;
    EXPECT_GE(edge.begin_ns - risen_ns, period_ns - timing.jitter_ns - 1);
    risen_ns = edge.begin_ns;
    ++steps;
  };
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(bench.generator.command(
        bench.now_ns, i % 2 == 0 ? timing.max_rate_millisteps_per_s : -timing.max_rate_millisteps_per_s));
    bench.run_until(bench.now_ns + 1'000'000'000);
  }
  EXPECT_GT(steps, 500);
}

TEST(StepGenerator, NeverGoesBackInTime) {
  StepTiming timing;
  StepBench bench(timing);
  ASSERT_TRUE(bench.generator.command(0, 2'000'000));
  bench.run_until(1'000'000'000);
  const std::int64_t steps = bench.generator.position_steps();
  ASSERT_TRUE(bench.generator.command(0, -2'000'000));  // by a clock that was read long ago
  ASSERT_TRUE(bench.generator.command(0, 1'000'000));
  bench.run_until(1'010'000'000);
  EXPECT_GE(bench.generator.position_steps(), steps + 10);
}

TEST(StepGenerator, HoversAboutZeroWithoutAStep) {
  StepTiming timing;
  timing.acceleration_millisteps_per_s2 = 1'000'000'000;
  StepBench bench(timing);
  int edges = 0;
  bench.on_edge = [&](const Edge& edge) { edges += edge.levels.step ? 1 : 0; };
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(bench.generator.command(bench.now_ns, i % 2 == 0 ? 100'000 : -100'000));
    bench.run_until(bench.now_ns + 4'000'000);  // 0.4 steps there, 0.4 back
  }
  EXPECT_EQ(edges, 0);
  EXPECT_EQ(bench.generator.position_steps(), 0);
}

TEST(StepGenerator, HaltsAtOnceButNotInsideAPulse) {
  StepTiming timing;
  StepBench bench(timing);
  std::int64_t risen_ns = -1;
  std::int64_t fallen_ns = -1;
  int rises = 0;
  bench.on_edge = [&](const Edge& edge) {
    if (edge.levels.step) {
      ++rises;
      risen_ns = edge.done_ns;
      if (rises == 3) bench.generator.halt();
    } else {
      fallen_ns = edge.begin_ns;
    }
  };
  ASSERT_TRUE(bench.generator.command(0, 1'000'000));
  bench.run_until(1'000'000'000);
  EXPECT_EQ(rises, 3);
  EXPECT_EQ(fallen_ns - risen_ns, timing.steplen_ns);
  EXPECT_EQ(bench.generator.position_steps(), 3);
  EXPECT_EQ(bench.generator.next_event_ns(), kNever_ns);
}

TEST(StepGenerator, RefusesRatesAboveTheMaximumAndRampsToRest) {
  StepTiming timing;
  StepBench bench(timing);
  ASSERT_TRUE(bench.generator.command(0, 2'000'000));
  bench.run_until(1'000'000'000);
  for (const std::int64_t rate : {2'000'001LL, -2'000'001LL, static_cast<long long>(kNever_ns),
                                  std::numeric_limits<long long>::min()}) {
    EXPECT_FALSE(bench.generator.command(bench.now_ns, rate));
    EXPECT_EQ(bench.generator.target_millisteps_per_s(), 0);
  }
  bench.run_until(2'000'000'000);
  EXPECT_EQ(bench.generator.rate_millisteps_per_s(), 0);
}

TEST(StepTiming, DerivesTheFastestRateAndRefusesMore) {
  StepTiming timing;
  timing.steplen_ns = 10'000;
  timing.stepspace_ns = 10'000;
  timing.jitter_ns = 90'000;
  EXPECT_EQ(fastest_rate_millisteps_per_s(timing), 5'000'000);
  timing.max_rate_millisteps_per_s = 5'000'000;
  EXPECT_EQ(check(timing), TimingError::kNone);
  timing.max_rate_millisteps_per_s = 5'000'001;
  EXPECT_EQ(check(timing), TimingError::kRateTooHigh);
  StepGenerator generator;
  EXPECT_EQ(generator.configure(timing, 0), TimingError::kRateTooHigh);
}

TEST(StepTiming, RefusesWhatCannotBe) {
  const auto with = [](auto change) {
    StepTiming timing;
    change(timing);
    return check(timing);
  };
  EXPECT_EQ(with([](StepTiming&) {}), TimingError::kNone);
  EXPECT_EQ(with([](StepTiming& t) { t.steplen_ns = 99; }), TimingError::kBadPulse);
  EXPECT_EQ(with([](StepTiming& t) { t.stepspace_ns = 100'000'001; }), TimingError::kBadPulse);
  EXPECT_EQ(with([](StepTiming& t) { t.dirsetup_ns = -1; }), TimingError::kBadDirection);
  EXPECT_EQ(with([](StepTiming& t) { t.dirhold_ns = 100'000'001; }), TimingError::kBadDirection);
  EXPECT_EQ(with([](StepTiming& t) { t.jitter_ns = t.ramp_ns + 1; }), TimingError::kBadJitter);
  EXPECT_EQ(with([](StepTiming& t) { t.jitter_ns = -1; }), TimingError::kBadJitter);
  EXPECT_EQ(with([](StepTiming& t) { t.ramp_ns = 0; }), TimingError::kBadRamp);
  EXPECT_EQ(with([](StepTiming& t) { t.acceleration_millisteps_per_s2 = 999; }),
            TimingError::kBadAcceleration);
  EXPECT_EQ(with([](StepTiming& t) { t.max_rate_millisteps_per_s = 0; }), TimingError::kRateTooHigh);
  EXPECT_EQ(
      with([](StepTiming& t) { t.max_rate_millisteps_per_s = std::numeric_limits<std::int64_t>::max(); }),
      TimingError::kRateTooHigh);
}

}  // namespace
}  // namespace vergence::step
