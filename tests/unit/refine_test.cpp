// Refinement: sub-pixel from a rough start, never worse by its own measure, equal work everywhere.
#include "algo/refine.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::World;

struct Stage {
  explicit Stage(const World& of) : world(of) { world.make_model(photo); }

  void see(const Transform& T_H_M) {
    ASSERT_EQ(make_colour_pyramid(world.look(world.rig.left, T_H_M).view(), left), Status::kOk);
    ASSERT_EQ(make_colour_pyramid(world.look(world.rig.right, T_H_M).view(), right), Status::kOk);
  }
  void refine(const RefinePass& pass, Transform& T) {
    refine_photo_pose(photo, world.rig, left, right, pass, workspace, T);
  }
  double cost(int level, const Transform& T) {
    return alignment_cost(photo, world.rig, left, right, {level, 500, 0}, workspace, T);
  }

  World world;
  PhotoModel photo;
  ColourPyramid left;
  ColourPyramid right;
  RefineWorkspace workspace;
};

double turn(const Transform& a, const Transform& b) {
  return quaternion_vector_from_rotation(a.R.transpose() * b.R).norm();
}

TEST(Refine, FindsThePoseBelowAPixelFromAFewMillimetresOff) {
  const auto stage = std::make_unique<Stage>(World(TargetKind::kPhoto));
  const Transform truth = to_transform({{12, -8, 460}, {0.08, -0.05, 0.1}});
  stage->see(truth);
  CounterRandom random(1, 0);
  const auto within = [&](double half) {
    return half * (2 * static_cast<double>(random.next() >> 11) / 9007199254740992.0 - 1);
  };
  for (int trial = 0; trial < 15; ++trial) {
    Transform T = to_transform({truth.t_mm + Vector3(within(5), within(5), within(15)),
                                Vector3(0.08 + within(0.06), -0.05 + within(0.06), 0.1 + within(0.06))});
    const double before = stage->cost(0, T);
    stage->refine({2, 200, 8}, T);
    stage->refine({1, 400, 6}, T);
    stage->refine({0, 500, 6}, T);
    EXPECT_LT(stage->cost(0, T), before);
    EXPECT_LT((T.t_mm - truth.t_mm).head<2>().norm(), 0.3) << trial;
    EXPECT_LT(std::abs(T.t_mm[2] - truth.t_mm[2]), 1.5) << trial;
    EXPECT_LT(turn(T, truth), 0.02) << trial;
  }
}

TEST(Refine, DoesNotMindTheLight) {
  World world(TargetKind::kPhoto);
  const auto stage = std::make_unique<Stage>(world);
  stage->world.light = 0.4;  // the photo was taken in full light
  const Transform truth = to_transform({{12, -8, 460}, {0.08, -0.05, 0.1}});
  stage->see(truth);
  Transform T = to_transform({{14, -6, 466}, {0.05, -0.03, 0.12}});
  for (const RefinePass& pass : {RefinePass{2, 200, 8}, RefinePass{1, 400, 6}, RefinePass{0, 500, 6}})
    stage->refine(pass, T);
  EXPECT_LT((T.t_mm - truth.t_mm).norm(), 1.5);
}

TEST(Refine, StaysFiniteWhereThereIsNothingToSee) {
  const auto stage = std::make_unique<Stage>(World(TargetKind::kPhoto));
  stage->world.present = false;
  stage->see(Transform{});
  for (const Vector3& t :
       {Vector3(0, 0, 400), Vector3(5000, 0, 400), Vector3(0, 0, -300), Vector3(0, 0, 0)}) {
    Transform T{Matrix3::Identity(), t};
    for (const RefinePass& pass : {RefinePass{2, 200, 8}, RefinePass{0, 500, 6}}) stage->refine(pass, T);
    EXPECT_TRUE(is_valid(to_pose(T)));
    const double cost = stage->cost(1, T);
    EXPECT_GE(cost, 0);
    EXPECT_LE(cost, 4);
  }
}

}  // namespace
}  // namespace vergence
