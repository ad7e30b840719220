// Whole frames of the tracker, found, followed, lost and searched for, without one call of the allocator.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/noheap/heap_counter.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::HeapCounter;

TEST(HeapCounter, CountsWhatAllocates) {
  const HeapCounter counter;
  const auto block = std::make_unique<std::vector<int>>(100);
  EXPECT_GE(counter.calls(), 2) << block->size();
}

TEST(NoHeap, FramesOfTheTrackerDoNotAllocate) {
  for (const TargetKind kind : {TargetKind::kMarker, TargetKind::kPhoto}) {
    for (const Method method : {Method::kVergence, Method::kThesis}) {
      testing::World world(kind);
      testing::Bench bench(world, 1, method);
      std::vector<std::pair<testing::Picture, testing::Picture>> frames;
      for (int frame = 0; frame < 6; ++frame) {
        const Transform truth = to_transform({{10.0 + frame, 0, 480}, {0, 0.1, 0}});
        world.present = frame != 3 && frame != 4;
        frames.emplace_back(world.look(world.rig.left, truth), world.look(world.rig.right, truth));
      }
      (void)bench.step(frames[0].first, frames[0].second, 10);  // Highway chooses its instruction set once
      const HeapCounter counter;
      for (const auto& [left, right] : frames) (void)bench.step(left, right, 600);
      EXPECT_EQ(counter.calls(), 0);
    }
  }
}

}  // namespace
}  // namespace vergence
