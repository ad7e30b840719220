// Work shared by threads is done once each, and errors come back.
#include "tools/run/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace vergence::tools {
namespace {

TEST(InParallel, DoesEveryPieceOnce) {
  for (const int threads : {0, 1, 3, 50}) {
    std::vector<std::atomic<int>> done(37);
    in_parallel(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    for (const auto& times : done) EXPECT_EQ(times, 1);
  }
  in_parallel(0, 4, [](std::size_t) { FAIL(); });
}

TEST(InParallel, RethrowsAndBeginsNothingMore) {
  std::atomic<int> begun = 0;
  const auto work = [&](std::size_t) {
    ++begun;
    throw std::runtime_error("no");
  };
  EXPECT_THROW(in_parallel(1000, 2, work), std::runtime_error);
  EXPECT_LE(begun, 2);
}

}  // namespace
}  // namespace vergence::tools
