// Mailboxes between tasks: the newest value, whole, once.
#include "hal/latest_value.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "firmware_like/messages.hpp"

namespace vergence {
namespace {

TEST(LatestValue, HoldsNothingUntilWritten) {
  LatestValue<int> box;
  int value = 7;
  EXPECT_FALSE(box.read(value));
  EXPECT_EQ(value, 7);
}

TEST(LatestValue, GivesTheNewestOnce) {
  LatestValue<int> box;
  int value = 0;
  for (int round = 1; round < 20; ++round) {
    for (int i = 0; i < round % 5 + 1; ++i) box.write(100 * round + i);
    ASSERT_TRUE(box.read(value));
    EXPECT_EQ(value, 100 * round + round % 5);
    EXPECT_FALSE(box.read(value));
  }
}

// Values larger than any word: a torn one would show two numbers.
TEST(LatestValue, IsNeverTornAndNeverGoesBack) {
  using Wide = std::array<std::uint64_t, 64>;
  static LatestValue<Wide> box;
  std::atomic<bool> done = false;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= 200000; ++i) {
      Wide wide;
      wide.fill(i);
      box.write(wide);
    }
    done = true;
  });
  std::uint64_t last = 0;
  Wide wide{};
  for (bool ended = false; !ended;) {
    ended = done;
    if (!box.read(wide)) continue;
    for (const std::uint64_t word : wide) ASSERT_EQ(word, wide[0]);
    ASSERT_GT(wide[0], last);
    last = wide[0];
  }
  writer.join();
  EXPECT_EQ(last, 200000U);
}

TEST(MotionHistory, DrawsStraightLinesBetweenSamples) {
  MotionHistory<2> history;
  for (int i = 0; i < 200; ++i) history.add(1000 * i, {1.0 * i, -2.0 * i});
  MotionHistory<2>::Values values{};
  for (std::int64_t t = 140000; t <= 199000; t += 137) {
    ASSERT_TRUE(history.at(t, 0, values)) << t;
    EXPECT_NEAR(values[0], static_cast<double>(t) / 1000, 1e-9);
    EXPECT_NEAR(values[1], -static_cast<double>(t) / 500, 1e-9);
  }
}

// At the shortest period of the arm as well, the hand is known when a frame was taken that is acted on only
// now.
TEST(MotionHistory, OfTheHandReachesBackBeyondTheOldestFrame) {
  HandHistory history;
  HandHistory::Values values{};
  for (int i = 0; i < 1000; ++i) history.add(1'000'000LL * i, {1.0 * i});
  ASSERT_TRUE(history.at(999'000'000 - 120'000'000, 0, values));
  EXPECT_EQ(values[0], 999 - 120);
}

TEST(MotionHistory, SaysWhereItKnowsNothing) {
  MotionHistory<1> history;
  MotionHistory<1>::Values values{};
  EXPECT_FALSE(history.at(0, 1000, values));
  for (int i = 0; i < 100; ++i) history.add(10 * i, {1.0 * i});
  EXPECT_FALSE(history.at(10 * (99 - 64), 0, values));  // forgotten
  EXPECT_TRUE(history.at(10 * (99 - 63), 0, values));
  EXPECT_TRUE(history.at(995, 5, values));  // a little ahead: the newest
  EXPECT_EQ(values[0], 99);
  EXPECT_FALSE(history.at(996, 5, values));
  history.clear();
  EXPECT_FALSE(history.at(995, 5, values));
}

TEST(MotionHistory, LeavesOutStampsThatDoNotRise) {
  MotionHistory<1> history;
  history.add(10, {1});
  history.add(10, {2});
  history.add(5, {3});
  history.add(20, {2});
  MotionHistory<1>::Values values{};
  ASSERT_TRUE(history.at(15, 0, values));
  EXPECT_EQ(values[0], 1.5);
}

}  // namespace
}  // namespace vergence
