// The tracker as a whole: found from nowhere, followed, lost, found again; and the same bits every time.
#include "algo/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::Bench;
using testing::World;

double distance_mm(const Estimate& estimate, const Transform& T) {
  return (estimate.pose.position_mm - T.t_mm).norm();
}
double turn(const Estimate& estimate, const Transform& T) {
  return multiply_quaternion_vectors(-quaternion_vector_from_rotation(T.R), estimate.pose.e).norm();
}

Transform some_pose(std::uint64_t seed) {
  CounterRandom random(seed, 99);
  const auto within = [&](double half) {
    return half * (2 * static_cast<double>(random.next() >> 11) / 9007199254740992.0 - 1);
  };
  const double x = within(50);
  const double y = within(35);
  const double z = within(60);
  return to_transform({{x, y, 480 + z}, {within(0.2), within(0.2), within(0.2)}});
}

class TrackerTest : public ::testing::TestWithParam<TargetKind> {};
INSTANTIATE_TEST_SUITE_P(Targets, TrackerTest, ::testing::Values(TargetKind::kMarker, TargetKind::kPhoto));

TEST_P(TrackerTest, FindsTheTargetInItsFirstFrame) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Bench bench(World(GetParam()), seed);
    ASSERT_EQ(bench.status(), Status::kOk);
    const Transform truth = some_pose(seed);
    const Estimate estimate = bench.step(truth, 2400);
    EXPECT_EQ(estimate.state, TrackState::kTracking) << seed;
    EXPECT_LT(distance_mm(estimate, truth), GetParam() == TargetKind::kMarker ? 1 : 8) << seed;
    EXPECT_LT(turn(estimate, truth), 0.02) << seed;
  }
}

TEST_P(TrackerTest, FollowsAMovingTarget) {
  Bench bench{World(GetParam())};
  (void)bench.step(some_pose(3), 2400);
  for (int frame = 1; frame <= 45; ++frame) {
    Transform truth = some_pose(3);
    truth.t_mm[0] += 4.0 * (frame < 23 ? frame : 45 - frame);  // 120 mm/s, and back at once
    const Estimate estimate = bench.step(truth, 60);
    EXPECT_EQ(estimate.state, TrackState::kTracking) << frame;
    EXPECT_LT(distance_mm(estimate, truth), 8) << frame;
  }
}

// What was found first may be something like it, and would be followed from then on.
TEST(Tracker, SearchesAgainForAPhotoModelItHasJustFound) {
  Bench bench{World(TargetKind::kPhoto)};
  const std::array<bool, 5> follows{false, false, false, true, true};
  for (std::size_t frame = 0; frame < follows.size(); ++frame) {
    Transform truth = some_pose(3);
    truth.t_mm[0] += 4.0 * static_cast<double>(frame);
    const Estimate estimate = bench.step(truth, follows[frame] ? 60 : 2400);
    EXPECT_EQ(bench.tracker().is_following(), follows[frame]) << frame;
    EXPECT_EQ(estimate.state, TrackState::kTracking) << frame;
    EXPECT_LT(distance_mm(estimate, truth), 8) << frame;
  }
}

// Where a whole search was in vain, the places that it kept were wrong: they must not sway the next one.
TEST(Tracker, SearchesAnewAfterASearchInVain) {
  const int whole = Bench(World(TargetKind::kPhoto)).tracker().usual_generations();
  const auto find = [&](std::uint64_t first_frame) {
    Bench bench{World(TargetKind::kPhoto)};
    Estimate estimate;
    for (std::uint64_t frame = first_frame; frame <= 2; ++frame) {
      World& world = bench.world();
      world.present = frame == 2;
      FrameMotion motion;
      motion.t_s = static_cast<double>(frame) / 30;
      motion.T_H_CL = world.rig.left.T_H_C;
      motion.T_H_CR = world.rig.right.T_H_C;
      const auto left = world.look(world.rig.left, some_pose(7));
      const auto right = world.look(world.rig.right, some_pose(7));
      EXPECT_EQ(bench.tracker().begin_frame(frame, left.view(), right.view(), motion), Status::kOk);
      for (int g = 0; g < whole; ++g) bench.tracker().evolve(static_cast<double>(g) / whole);
      estimate = bench.tracker().end_frame();
      EXPECT_EQ(estimate.state == TrackState::kTracking, world.present) << frame;
    }
    return estimate;
  };
  const Estimate after_two_in_vain = find(0);
  const Estimate at_once = find(2);
  EXPECT_EQ(after_two_in_vain.evaluations, at_once.evaluations);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(after_two_in_vain.pose.position_mm[i], at_once.pose.position_mm[i]) << i;
    EXPECT_EQ(after_two_in_vain.pose.e[i], at_once.pose.e[i]) << i;
  }
}

// How near the middle of a solid is thought to be.
double depth_mm(const Tracker& tracker) {
  const auto& z_mm = tracker.photo_model().z_mm;
  return -static_cast<double>(*std::min_element(z_mm.begin(), z_mm.end()));
}

// A solid may be rounder than its silhouette says: every search looks for it in two shapes.
TEST(Tracker, SearchesForASolidInTwoShapesByTurns) {
  World world(TargetKind::kPhoto);
  world.oval = true;
  world.present = false;
  Bench bench(world);
  const auto left = bench.world().look(bench.world().rig.left, {});
  const auto right = bench.world().look(bench.world().rig.right, {});
  std::array<std::vector<double>, 3> depths_mm;  // one after the other, of each frame
  for (std::size_t frame = 0; frame < depths_mm.size(); ++frame) {
    FrameMotion motion;
    motion.t_s = static_cast<double>(frame) / 30;
    motion.T_H_CL = bench.world().rig.left.T_H_C;
    motion.T_H_CR = bench.world().rig.right.T_H_C;
    ASSERT_EQ(bench.tracker().begin_frame(frame, left.view(), right.view(), motion), Status::kOk);
    for (int g = 0; g < 600; ++g) {
      const double depth = depth_mm(bench.tracker());
      if (depths_mm[frame].empty() || std::abs(depth - depths_mm[frame].back()) > 0.01) {
        depths_mm[frame].push_back(depth);
      }
      bench.tracker().evolve(g / 600.0);
    }
    EXPECT_NE(bench.tracker().end_frame().state, TrackState::kTracking);
  }
  const double little_mm = depths_mm[0][0];
  EXPECT_GT(little_mm, 3);
  for (std::size_t frame = 0; frame < depths_mm.size(); ++frame) {
    const double much_mm = (frame % 2 == 0 ? 3 : 4) * little_mm;
    ASSERT_GE(depths_mm[frame].size(), 4U) << frame;
    for (std::size_t turn = 0; turn < depths_mm[frame].size(); ++turn) {
      const bool is_little = std::abs(depths_mm[frame][turn] - little_mm) < 0.01;
      EXPECT_TRUE(is_little || std::abs(depths_mm[frame][turn] - much_mm) < 0.01) << frame << ' ' << turn;
    }
  }
}

// A second search that finds nothing better leaves the shape alone in which the target was found.
TEST(Tracker, KeepsTheShapeItFollowsWhereASearchInAnotherFindsNoBetter) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    World world(TargetKind::kPhoto);
    world.oval = true;
    Bench bench(world, seed);
    const Transform truth = some_pose(seed);
    ASSERT_EQ(bench.step(truth, 2400).state, TrackState::kTracking) << seed;
    for (int frame = 1; frame <= 4; ++frame) {
      const Estimate estimate = bench.step(truth, frame < 3 ? 5 : 60);  // too few to find it
      EXPECT_EQ(estimate.state, TrackState::kTracking) << seed << ' ' << frame;
      EXPECT_LT(distance_mm(estimate, truth), 2) << seed << ' ' << frame;
      EXPECT_LT(turn(estimate, truth), 0.02) << seed << ' ' << frame;
      EXPECT_LT(depth_mm(bench.tracker()), 0.5) << seed << ' ' << frame;
    }
  }
}

TEST_P(TrackerTest, FindsTheTargetWhereItsBudgetIsCutShort) {
  Bench bench{World(GetParam())};
  const Transform truth = some_pose(5);
  const auto left = bench.world().look(bench.world().rig.left, truth);
  const auto right = bench.world().look(bench.world().rig.right, truth);
  FrameMotion motion;
  motion.T_H_CL = bench.world().rig.left.T_H_C;
  motion.T_H_CR = bench.world().rig.right.T_H_C;
  ASSERT_EQ(bench.tracker().begin_frame(0, left.view(), right.view(), motion), Status::kOk);
  for (int g = 0; g < 1200; ++g) bench.tracker().evolve(0.5 * g / 1200);  // never comes to settling
  const Estimate estimate = bench.tracker().end_frame();
  EXPECT_EQ(estimate.state, TrackState::kTracking);
  EXPECT_LT(distance_mm(estimate, truth), 8);
}

TEST_P(TrackerTest, SaysLostWhereThereIsNoTarget) {
  World world(GetParam());
  world.present = false;
  Bench bench(world);
  for (int frame = 0; frame < 5; ++frame)
    EXPECT_EQ(bench.step(some_pose(1), 1200).state, TrackState::kLost) << frame;
}

TEST_P(TrackerTest, IsSearchingUntilItHasLookedEverywhere) {
  World world(GetParam());
  world.present = false;
  Bench bench(world);
  EXPECT_EQ(bench.step(some_pose(1), 20).state, TrackState::kSearching);
}

TEST_P(TrackerTest, FindsTheTargetAgainAfterItVanishedAndJumped) {
  Bench bench{World(GetParam())};
  EXPECT_EQ(bench.step(some_pose(1), 2400).state, TrackState::kTracking);
  bench.world().present = false;
  EXPECT_EQ(bench.step(some_pose(1), 60).state, TrackState::kLost);
  EXPECT_EQ(bench.step(some_pose(1), 2400).state, TrackState::kLost);
  bench.world().present = true;
  const Estimate estimate = bench.step(some_pose(8), 2400);
  EXPECT_EQ(estimate.state, TrackState::kTracking);
  EXPECT_LT(distance_mm(estimate, some_pose(8)), 8);
}

TEST_P(TrackerTest, KeepsTheTargetThroughAChangeOfLight) {
  Bench bench{World(GetParam())};
  (void)bench.step(some_pose(2), 2400);
  for (const double light : {0.9, 0.6, 0.4, 0.7, 1.0, 1.15}) {
    bench.world().light = light;
    const Estimate estimate = bench.step(some_pose(2), 60);
    EXPECT_EQ(estimate.state, TrackState::kTracking) << light;
    EXPECT_LT(distance_mm(estimate, some_pose(2)), 8) << light;
  }
}

TEST(Tracker, FollowsAMarkerWhoseHuesShiftBeyondTheirTolerance) {
  Bench bench{World(TargetKind::kMarker)};
  const Transform truth = some_pose(2);
  (void)bench.step(truth, 2400);
  Estimate estimate;
  constexpr int kFrames = 50;
  for (int frame = 1; frame <= kFrames; ++frame) {
    const double share = static_cast<double>(frame) / kFrames;  // the blue ball turns by 26 degrees
    bench.world().cast = {1 + 0.5 * share, 1 - 0.2 * share, 1 - 0.6 * share};
    estimate = bench.step(truth, 60);
    ASSERT_EQ(estimate.state, TrackState::kTracking) << frame;
    EXPECT_LT(distance_mm(estimate, truth), 1) << frame;
  }
  Bench fresh{bench.world()};
  (void)fresh.step(truth, 60);
  EXPECT_GT(estimate.fitness, 1.3);
  EXPECT_LT(fresh.tracker().fitness_at(estimate.pose), 1.1);
}

TEST(Tracker, DoesNotTakeOtherBallsForTheMarker) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    World world(TargetKind::kMarker);
    world.balls[0].centre_mm = {-20, -30, 10};
    world.balls[2].centre_mm = {15, 60, -20};
    Bench bench(world, seed);
    for (int frame = 0; frame < 3; ++frame) {
      EXPECT_NE(bench.step(some_pose(seed), 800).state, TrackState::kTracking) << seed;
    }
  }
}

TEST(Tracker, GivesACovarianceToAMarkerThatItTracks) {
  Bench bench{World(TargetKind::kMarker)};
  const Estimate estimate = bench.step(some_pose(1), 2400);
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(estimate.covariance(i, i), 0);
    EXPECT_LT(std::sqrt(estimate.covariance(i, i)), i < 3 ? 0.5 : 0.01);
  }
}

TEST_P(TrackerTest, GivesTheSameBitsForTheSameFramesAndSeed) {
  const auto run = [&](std::uint64_t seed) {
    Bench bench(World(GetParam()), seed);
    std::vector<double> bits;
    for (int frame = 0; frame < 4; ++frame) {
      const Estimate e = bench.step(some_pose(4), 150);
      for (int i = 0; i < 3; ++i) {
        bits.push_back(e.pose.position_mm[i]);
        bits.push_back(e.pose.e[i]);
      }
      bits.push_back(e.confidence);
    }
    return bits;
  };
  const auto first = run(5);
  const auto again = run(5);
  EXPECT_EQ(std::memcmp(first.data(), again.data(), first.size() * sizeof(double)), 0);
  EXPECT_NE(first, run(6));
}

TEST_P(TrackerTest, EvaluatesTwentyAndThenOnlyTheNewOnes) {
  Bench bench(World(GetParam()), 1, Method::kThesis);
  const Estimate estimate = bench.step(some_pose(1), 9);
  EXPECT_EQ(estimate.generations, 9);
  EXPECT_EQ(estimate.evaluations, 20 + 9 * 8);
}

TEST(Tracker, ThesisSettingsAreThoseOfTheThesis) {
  const TrackerSettings settings = default_settings(Method::kThesis, TargetKind::kMarker);
  EXPECT_EQ(settings.ga.coding, GeneCoding::kBinary);
  EXPECT_EQ(settings.hue_limits.min_saturation_permille, 0);
  Bench bench(World(TargetKind::kMarker), 1, Method::kThesis);
  EXPECT_EQ(bench.tracker().usual_generations(), 9);
}

TEST(Tracker, RefusesImagesThatAreNotTheRigs) {
  Bench bench{World(TargetKind::kMarker)};
  testing::Picture small{160, 120, std::vector<std::uint8_t>(160 * 120 * 3)};
  FrameMotion motion;
  EXPECT_EQ(bench.tracker().begin_frame(0, small.view(), small.view(), motion), Status::kBadImage);
}

TEST(Tracker, RefusesAnEmptyBoxAndABadCamera) {
  const World world(TargetKind::kMarker);
  const auto model = std::make_unique<MarkerModel>();
  world.make_model(*model);
  const auto tracker = std::make_unique<Tracker>();
  TrackerSettings settings;
  settings.box.half_range[0] = 0;
  EXPECT_EQ(tracker->configure(world.rig, *model, settings), Status::kBadSearchBox);
  settings = {};
  StereoRig rig = world.rig;
  rig.left.fx_px = 0;
  EXPECT_EQ(tracker->configure(rig, *model, settings), Status::kBadCamera);
  EXPECT_EQ(tracker->configure(world.rig, MarkerModel{}, settings), Status::kBadModel);
}

}  // namespace
}  // namespace vergence
