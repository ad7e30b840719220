// Pairs by stamps: examples, and what holds for any stamps.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "hal/v4l2/stereo_pairing.hpp"
#include "tests/support/random.hpp"

namespace vergence::v4l2 {
namespace {

struct Pairing {
  StereoPairing pairing;
  std::array<std::vector<int>, 2> dropped;

  explicit Pairing(std::int64_t skew_ns) { pairing.configure(skew_ns); }

  void add(int side, std::int64_t stamp_ns, int id) {
    DroppedFrames now;
    pairing.add(side, {stamp_ns, id}, now);
    keep(now);
  }
  bool newest(TimedFrame& left, TimedFrame& right) {
    DroppedFrames now;
    const bool found = pairing.newest(left, right, now);
    keep(now);
    return found;
  }
  void keep(const DroppedFrames& now) {
    for (std::size_t s = 0; s < 2; ++s)
      dropped[s].insert(dropped[s].end(), now.ids[s].begin(), now.ids[s].begin() + now.count[s]);
  }
};

TEST(V4l2Pairing, PairsWithinTheSkewAndNotBeyond) {
  TimedFrame left;
  TimedFrame right;
  Pairing p(5);
  p.add(0, 100, 1);
  EXPECT_FALSE(p.newest(left, right));
  p.add(1, 105, 2);
  ASSERT_TRUE(p.newest(left, right));
  EXPECT_EQ(left.id, 1);
  EXPECT_EQ(right.id, 2);
  p.add(0, 200, 3);
  p.add(1, 206, 4);
  EXPECT_FALSE(p.newest(left, right));
  EXPECT_EQ(p.dropped[0], std::vector<int>{3});  // no partner can come any more
  EXPECT_EQ(p.pairing.waiting(1), 1);
}

TEST(V4l2Pairing, TheNewestPairWins) {
  TimedFrame left;
  TimedFrame right;
  Pairing p(5);
  for (int i = 0; i < 3; ++i) {
    p.add(0, 100 + 33 * i, i);
    p.add(1, 102 + 33 * i, 10 + i);
  }
  ASSERT_TRUE(p.newest(left, right));
  EXPECT_EQ(left.id, 2);
  EXPECT_EQ(right.id, 12);
  EXPECT_EQ(p.pairing.counts().superseded, (std::array<std::uint64_t, 2>{2, 2}));
  EXPECT_FALSE(p.newest(left, right));
}

// One eye's frames come 40 ms later than the other's: they still meet.
TEST(V4l2Pairing, WaitsForAnEyeThatIsSlowToCome) {
  TimedFrame left;
  TimedFrame right;
  Pairing p(5);
  int pairs = 0;
  for (int i = 0; i < 30; ++i) {
    p.add(0, 33 * i, i);
    if (i >= 2) p.add(1, 33 * (i - 2) + 1, i);
    if (p.newest(left, right)) ++pairs;
  }
  EXPECT_EQ(pairs, 28);
}

TEST(V4l2Pairing, DropsTheOldestWhereTheOtherEyeIsSilent) {
  Pairing p(5);
  for (int i = 0; i < 10; ++i) p.add(0, 33 * i, i);
  EXPECT_EQ(p.dropped[0].size(), static_cast<std::size_t>(10 - kPairingDepth));
  EXPECT_EQ(p.dropped[0].front(), 0);
  p.pairing.set_depth(1);
  p.add(0, 1000, 10);
  EXPECT_EQ(p.pairing.waiting(0), 1);
}

TEST(V4l2Pairing, RefusesStampsThatDoNotRise) {
  Pairing p(5);
  p.add(0, 100, 1);
  p.add(0, 100, 2);
  p.add(0, 99, 3);
  EXPECT_EQ(p.dropped[0], (std::vector<int>{2, 3}));
  EXPECT_EQ(p.pairing.counts().backwards[0], 2U);
}

// Random stamps, losses and order of arrival. A plain model keeps everything that waits and looks through it.
TEST(V4l2Pairing, HoldsForAnyStamps) {
  std::uint64_t all_pairs = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    testing::Random random(seed);
    const std::int64_t skew_ns = random.below(40);
    Pairing p(skew_ns);
    p.pairing.set_depth(1 + random.below(kPairingDepth));
    std::array<std::vector<TimedFrame>, 2> waiting;  // of the model
    std::array<std::int64_t, 2> stamp_ns{0, 0};
    std::array<std::int64_t, 2> last_ns{-1000, -1000};
    std::array<std::uint64_t, 2> paired{};
    int id = 0;
    for (int i = 0; i < 200; ++i) {
      const int side = random.below(2);
      const auto s = static_cast<std::size_t>(side);
      stamp_ns[s] += random.below(60) - 3;
      p.add(side, stamp_ns[s], id);
      waiting[s].push_back({stamp_ns[s], id++});
      for (std::size_t t = 0; t < 2; ++t)  // what was dropped is known from outside
        std::erase_if(waiting[t], [&](const TimedFrame& f) {
          return std::find(p.dropped[t].begin(), p.dropped[t].end(), f.id) != p.dropped[t].end();
        });
      if (random.below(3) == 0) continue;

      std::int64_t best_ns = -1000;
      for (const TimedFrame& l : waiting[0])
        for (const TimedFrame& r : waiting[1])
          if (std::max(l.stamp_ns, r.stamp_ns) - std::min(l.stamp_ns, r.stamp_ns) <= skew_ns)
            best_ns = std::max(best_ns, std::min(l.stamp_ns, r.stamp_ns));
      std::array<TimedFrame, 2> found{};
      const bool is_pair = p.newest(found[0], found[1]);
      ASSERT_EQ(is_pair, best_ns > -1000) << seed;
      if (!is_pair) continue;
      ASSERT_EQ(std::min(found[0].stamp_ns, found[1].stamp_ns), best_ns);
      ASSERT_LE(std::max(found[0].stamp_ns, found[1].stamp_ns) - best_ns, skew_ns);
      for (std::size_t t = 0; t < 2; ++t) {
        ASSERT_GT(found[t].stamp_ns, last_ns[t]);  // never backwards
        last_ns[t] = found[t].stamp_ns;
        ++paired[t];
        std::erase_if(waiting[t], [&](const TimedFrame& f) { return f.id == found[t].id; });
      }
    }
    const PairingCounts& counts = p.pairing.counts();
    all_pairs += counts.pairs;
    for (std::size_t t = 0; t < 2; ++t) {
      EXPECT_EQ(counts.pairs, paired[t]);
      EXPECT_EQ(counts.unpaired[t] + counts.superseded[t] + counts.backwards[t], p.dropped[t].size());
      EXPECT_EQ(counts.added[t], counts.pairs + p.dropped[t].size() +
                                     static_cast<std::uint64_t>(p.pairing.waiting(static_cast<int>(t))));
      std::vector<int> ids = p.dropped[t];
      std::sort(ids.begin(), ids.end());
      EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());  // each once
    }
  }
  EXPECT_GT(all_pairs, 30'000U);
}

}  // namespace
}  // namespace vergence::v4l2
