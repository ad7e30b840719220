// The executive's view of time, with time handed in: the histogram against a sorted list, the grid of
// releases, what is counted when something is late, and the loop that joins them.
#include <gtest/gtest.h>
#include <sys/time.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <vector>

#include "hal/rt/duration_histogram.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/periodic_schedule.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/rt/task_timing.hpp"
#include "tests/support/random.hpp"

namespace vergence::rt {
namespace {

using testing::Random;

constexpr std::int64_t kMs = 1'000'000;

// From nanoseconds to beyond the last bucket.
std::int64_t any_duration(Random& random) {
  const int bits = random.below(44);
  return static_cast<std::int64_t>(random.bits() & ((std::uint64_t{1} << bits) - 1));
}

TEST(DurationHistogram, BucketsFollowOneAnotherWithoutGap) {
  const DurationHistogram histogram;
  std::int64_t next = 0;
  for (std::size_t i = 0; i < DurationHistogram::kBuckets; ++i) {
    const DurationHistogram::Bucket bucket = histogram.bucket(i);
    ASSERT_EQ(bucket.least_ns, next) << i;
    ASSERT_GE(bucket.greatest_ns, bucket.least_ns) << i;
    next = bucket.greatest_ns + (i + 1 < DurationHistogram::kBuckets ? 1 : 0);
  }
  EXPECT_EQ(next, std::numeric_limits<std::int64_t>::max());
}

TEST(DurationHistogram, AgreesWithASortedList) {
  Random random(1);
  for (int run = 0; run < 200; ++run) {
    DurationHistogram histogram;
    std::vector<std::int64_t> list;
    const int count = 1 + random.below(400);
    for (int i = 0; i < count; ++i) {
      // Some runs of one size, some of all sizes.
      list.push_back(run % 2 == 0 ? any_duration(random) : 5'000 + random.below(20'000));
      histogram.add(list.back());
    }
    std::sort(list.begin(), list.end());
    ASSERT_EQ(histogram.count(), list.size());
    ASSERT_EQ(histogram.min_ns(), list.front());
    ASSERT_EQ(histogram.max_ns(), list.back());
    std::int64_t sum = 0;
    for (const std::int64_t ns : list) sum += ns;
    ASSERT_EQ(histogram.sum_ns(), sum);
    ASSERT_EQ(histogram.mean_ns(), sum / count);

    std::uint64_t in_buckets = 0;
    for (std::size_t i = 0; i < DurationHistogram::kBuckets; ++i) {
      const DurationHistogram::Bucket bucket = histogram.bucket(i);
      const auto inside = std::upper_bound(list.begin(), list.end(), bucket.greatest_ns) -
                          std::lower_bound(list.begin(), list.end(), bucket.least_ns);
      ASSERT_EQ(bucket.count, static_cast<std::uint64_t>(inside)) << bucket.least_ns;
      in_buckets += bucket.count;
    }
    ASSERT_EQ(in_buckets, histogram.count());

    for (const double q : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, random.between(0, 1), 1.0}) {
      const double rank = std::ceil(q * count);
      const std::int64_t exact = list[static_cast<std::size_t>(std::max(rank - 1, 0.0))];
      const std::int64_t bound = histogram.quantile_upper_bound_ns(q);
      ASSERT_GE(bound, exact) << q;
      ASSERT_TRUE(bound <= exact + exact / 16 || exact > DurationHistogram::kLongest_ns)
          << q << ' ' << exact << ' ' << bound;
    }
    ASSERT_EQ(histogram.quantile_upper_bound_ns(1), list.back());
  }
}

TEST(DurationHistogram, AddsUpAnother) {
  Random random(2);
  DurationHistogram parts[2];
  DurationHistogram whole;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t ns = any_duration(random);
    parts[i % 2].add(ns);
    whole.add(ns);
  }
  parts[0].add(parts[1]);
  EXPECT_EQ(parts[0].count(), whole.count());
  EXPECT_EQ(parts[0].sum_ns(), whole.sum_ns());
  EXPECT_EQ(parts[0].min_ns(), whole.min_ns());
  EXPECT_EQ(parts[0].max_ns(), whole.max_ns());
  for (std::size_t i = 0; i < DurationHistogram::kBuckets; ++i) {
    ASSERT_EQ(parts[0].bucket(i).count, whole.bucket(i).count);
  }
}

TEST(DurationHistogram, IsBounded) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.quantile_upper_bound_ns(0.5), 0);
  EXPECT_EQ(histogram.min_ns(), 0);
  EXPECT_EQ(histogram.mean_ns(), 0);
  histogram.add(-5);  // a clock that was read twice the wrong way round
  EXPECT_EQ(histogram.max_ns(), 0);
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 3; ++i) histogram.add(kMost);
  EXPECT_EQ(histogram.sum_ns(), kMost);
  EXPECT_EQ(histogram.quantile_upper_bound_ns(0.9), kMost);
  EXPECT_EQ(histogram.bucket(DurationHistogram::kBuckets - 1).count, 3U);
  DurationHistogram more;
  more.add(1);
  more.add(histogram);
  EXPECT_EQ(more.sum_ns(), kMost);
  histogram.clear();
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.bucket(0).count, 0U);
}

TEST(PeriodicSchedule, KeepsToItsGridWhateverIsLate) {
  Random random(3);
  for (int run = 0; run < 200; ++run) {
    const std::int64_t start = random.below(1'000'000);
    const std::int64_t period = 1 + random.below(4'000'000);
    PeriodicSchedule schedule(start, period);
    std::int64_t now = start;
    std::int64_t releases = 0;
    std::int64_t skipped = 0;
    for (int i = 0; i < 200; ++i) {
      now = std::max(now, schedule.next_release_ns());
      if (random.below(10) == 0)
        now += static_cast<std::int64_t>(random.between(0, 5) * static_cast<double>(period));
      skipped += schedule.skip_passed(now);
      const std::int64_t release = schedule.next_release_ns();
      ASSERT_EQ((release - start) % period, 0);
      ASSERT_LE(release, now);
      ASSERT_LT(now - release, period);  // the period that has begun, no older one
      now += static_cast<std::int64_t>(random.between(0, random.below(10) == 0 ? 4 : 1) *
                                       static_cast<double>(period));
      skipped += schedule.advance(now);
      ++releases;
      ASSERT_GT(schedule.next_release_ns(), release);
      ASSERT_GT(schedule.next_release_ns(), now - period);
      ASSERT_EQ((schedule.next_release_ns() - start) / period, releases + skipped);
      ASSERT_EQ(schedule.skipped(), static_cast<std::uint64_t>(skipped));
    }
  }
}

TEST(PeriodicSchedule, RunsTheBegunPeriodLateAndSkipsWholeOnes) {
  PeriodicSchedule schedule(0, 10);
  EXPECT_EQ(schedule.advance(19), 0);
  EXPECT_EQ(schedule.next_release_ns(), 10);
  EXPECT_EQ(schedule.advance(29), 0);
  EXPECT_EQ(schedule.next_release_ns(), 20);
  EXPECT_EQ(schedule.advance(40), 1);  // the period of 30 is over
  EXPECT_EQ(schedule.next_release_ns(), 40);
  EXPECT_EQ(schedule.skip_passed(45), 0);
  EXPECT_EQ(schedule.skip_passed(75), 3);
  EXPECT_EQ(schedule.next_release_ns(), 70);
  EXPECT_EQ(schedule.skipped(), 4U);
}

TEST(TaskTiming, TellsLatenessFromWork) {
  TaskTiming timing({2 * kMs, kMs});
  timing.began(10 * kMs, 10 * kMs + 30'000);
  EXPECT_TRUE(timing.ended(10 * kMs + 430'000));
  EXPECT_EQ(timing.latency_ns(), 30'000);
  EXPECT_EQ(timing.execution_ns(), 400'000);
  EXPECT_EQ(timing.response_ns(), 430'000);
  timing.began(12 * kMs, 12 * kMs + 10'000);
  EXPECT_TRUE(timing.ended(12 * kMs + 110'000));
  EXPECT_EQ(timing.latency_ns(), 10'000);
  EXPECT_EQ(timing.worst_latency_ns(), 30'000);
  EXPECT_EQ(timing.worst_execution_ns(), 400'000);
  EXPECT_EQ(timing.worst_response_ns(), 430'000);
  EXPECT_EQ(timing.runs(), 2U);
  EXPECT_EQ(timing.lost_periods(), 0U);
  EXPECT_EQ(timing.misses(), 0U);
}

TEST(TaskTiming, CountsMissesInARowAndLostPeriods) {
  TaskTiming timing({2 * kMs, kMs});
  const auto run = [&](std::int64_t release, std::int64_t late, std::int64_t takes) {
    timing.began(release, release + late);
    return timing.ended(release + late + takes);
  };
  EXPECT_TRUE(run(0, 0, kMs));  // in time to the nanosecond
  EXPECT_FALSE(run(2 * kMs, 0, kMs + 1));
  EXPECT_FALSE(run(4 * kMs, kMs, 1));  // the wake-up alone was too late
  EXPECT_EQ(timing.misses_in_a_row(), 2U);
  EXPECT_TRUE(run(6 * kMs, 0, 1));
  EXPECT_EQ(timing.misses_in_a_row(), 0U);
  EXPECT_FALSE(run(8 * kMs, 0, 2 * kMs));
  EXPECT_EQ(timing.misses(), 3U);
  EXPECT_EQ(timing.worst_misses_in_a_row(), 2U);
  EXPECT_EQ(timing.lost_periods(), 0U);
  EXPECT_TRUE(run(16 * kMs, 0, 1));
  EXPECT_EQ(timing.lost_periods(), 3U);  // those of 10, 12 and 14 ms
}

TEST(TaskTiming, ATaskWithoutPeriodOrDeadlineLosesNone) {
  TaskTiming timing;
  timing.began(0, 5);
  EXPECT_TRUE(timing.ended(1'000 * kMs));
  timing.began(5'000 * kMs, 5'000 * kMs);
  EXPECT_TRUE(timing.ended(5'000 * kMs));
  EXPECT_EQ(timing.lost_periods(), 0U);
  EXPECT_EQ(timing.misses(), 0U);
}

// A world in which sleeping and working take what the test says.
struct World {
  std::int64_t time_ns = 0;
  std::function<std::int64_t()> wakes_late_ns = [] { return 0; };
  std::int64_t now_ns() { return time_ns; }
  void sleep_until(std::int64_t ns) { time_ns = std::max(time_ns, ns) + wakes_late_ns(); }
};
static_assert(Clock<World> && Sleeper<World>);

TEST(RunPeriodic, OverrunsAreSeenCountedAndNotMadeUpFor) {
  World world;
  PeriodicSchedule schedule(2 * kMs, 2 * kMs);
  TimingRecord record;
  record.timing = TaskTiming({2 * kMs, kMs});
  std::atomic<bool> stop = false;
  std::vector<std::int64_t> releases;
  std::vector<std::int64_t> skipped;
  run_periodic(world, world, schedule, record, stop, [&](const Release& release) {
    EXPECT_EQ(release.now_ns, world.time_ns);
    releases.push_back(release.release_ns / kMs);
    skipped.push_back(release.skipped);
    // The third run takes three and a half periods.
    world.time_ns += releases.size() == 3 ? 7 * kMs : kMs / 2;
    stop = releases.size() == 7;
  });
  // 8 and 10 are lost; 12 begins at 13, still within its period.
  EXPECT_EQ(releases, (std::vector<std::int64_t>{2, 4, 6, 12, 14, 16, 18}));
  EXPECT_EQ(skipped, (std::vector<std::int64_t>{0, 0, 0, 2, 0, 0, 0}));
  EXPECT_EQ(record.timing.runs(), 7U);
  EXPECT_EQ(record.timing.lost_periods(), 2U);
  EXPECT_EQ(record.timing.misses(), 2U);  // the long run, and the one it delayed
  EXPECT_EQ(record.timing.worst_misses_in_a_row(), 2U);
  EXPECT_EQ(record.timing.misses_in_a_row(), 0U);
  EXPECT_EQ(record.timing.worst_execution_ns(), 7 * kMs);
  EXPECT_EQ(record.timing.worst_latency_ns(), kMs);
  EXPECT_EQ(record.latency.max_ns(), kMs);
  EXPECT_EQ(record.execution.count(), 7U);
  EXPECT_EQ(schedule.skipped(), 2U);
}

TEST(RunPeriodic, ALateWakeUpIsMeasuredFromWhatWasSleptFor) {
  World world;
  PeriodicSchedule schedule(0, 2 * kMs);
  TaskTiming timing({2 * kMs, kMs});
  std::atomic<bool> stop = false;
  int run = 0;
  world.wakes_late_ns = [&] { return run == 1 ? 5 * kMs : 0; };
  std::vector<std::int64_t> releases;
  run_periodic(world, world, schedule, timing, stop, [&](const Release& release) {
    releases.push_back(release.release_ns / kMs);
    EXPECT_EQ(release.skipped, run == 1 ? 2 : 0);
    stop = ++run == 4;
  });
  EXPECT_EQ(releases, (std::vector<std::int64_t>{0, 6, 8, 10}));  // woken at 7
  EXPECT_EQ(timing.worst_latency_ns(), 5 * kMs);
  EXPECT_EQ(timing.misses(), 1U);
  EXPECT_EQ(timing.lost_periods(), 2U);
}

TEST(RunPeriodic, ScheduleAndTimingCountTheSamePeriods) {
  Random random(4);
  for (int run = 0; run < 100; ++run) {
    World world;
    const std::int64_t period = 1'000 + random.below(5'000'000);
    const auto share = [&](double most) {
      return static_cast<std::int64_t>(random.between(0, most) * static_cast<double>(period));
    };
    bool calm = false;
    world.wakes_late_ns = [&] { return !calm && random.below(5) == 0 ? share(4) : 0; };
    PeriodicSchedule schedule(0, period);
    TaskTiming timing({period, period});
    std::atomic<bool> stop = false;
    int runs = 0;
    std::int64_t last = -period;
    run_periodic(world, world, schedule, timing, stop, [&](const Release& release) {
      ASSERT_EQ(release.release_ns - last, (release.skipped + 1) * period);
      ASSERT_LT(release.now_ns - release.release_ns, period);
      last = release.release_ns;
      world.time_ns += calm ? 0 : share(random.below(4) == 0 ? 4 : 1);
      ++runs;
      calm = runs >= 300;
      stop = runs == 302;
    });
    ASSERT_EQ(timing.lost_periods(), schedule.skipped());
    ASSERT_GT(timing.lost_periods(), 0U);
    ASSERT_GT(timing.misses(), 0U);
    ASSERT_EQ(timing.runs(), 302U);
  }
}

TEST(RunPeriodic, StopsAfterTheSleepWithoutAnotherRun) {
  World world;
  PeriodicSchedule schedule(0, kMs);
  TaskTiming timing;
  std::atomic<bool> stop = false;
  int sleeps = 0;
  world.wakes_late_ns = [&]() -> std::int64_t {
    stop = ++sleeps == 3;
    return 0;
  };
  int runs = 0;
  run_periodic(world, world, schedule, timing, stop, [&](const Release&) { ++runs; });
  EXPECT_EQ(runs, 2);
}

// With real time: never early, and signals do not end it.
TEST(SleepUntil, LastsWhateverSignalsCome) {
  static volatile std::sig_atomic_t signals = 0;
  struct sigaction counting {};
  struct sigaction before {};
  counting.sa_handler = [](int) { signals = signals + 1; };
  ASSERT_EQ(sigaction(SIGALRM, &counting, &before), 0);
  const itimerval often{{0, 2'000}, {0, 2'000}};
  ASSERT_EQ(setitimer(ITIMER_REAL, &often, nullptr), 0);
  MonotonicClock clock;
  const std::int64_t until = clock.now_ns() + 100 * kMs;
  sleep_until(until);
  EXPECT_GE(clock.now_ns(), until);
  const itimerval never{};
  ASSERT_EQ(setitimer(ITIMER_REAL, &never, nullptr), 0);
  ASSERT_EQ(sigaction(SIGALRM, &before, nullptr), 0);
  EXPECT_GT(signals, 0);
  sleep_until(0);
  sleep_until(-1);  // at once, both
}

}  // namespace
}  // namespace vergence::rt
