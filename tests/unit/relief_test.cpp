// Relief: a solid's depth is found and its pose is no longer biased; what is flat stays flat; where there is
// no target nothing is learned; and the same bits on every instruction set.
#include "algo/relief.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "tests/differential/every_target.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::Bench;
using testing::Picture;
using testing::World;

constexpr int kFrames = 24;
const Transform kTruth = to_transform({{10, -5, 420}, {0.06, -0.08, 0.05}});

const Transform kAhead{Matrix3::Identity(), {0, 0, 420}};
const Transform kTurnedAway = kAhead * to_transform({Vector3::Zero(), {0.2, 0, 0}});

World world_with(double bowl_mm) {
  World world(TargetKind::kPhoto);
  world.bowl_mm = bowl_mm;
  return world;
}

// Estimates of a target that stands still, from the first frame on.
std::vector<Estimate> watch(Bench& bench, int frames = kFrames) {
  const auto left = bench.world().look(bench.world().rig.left, kTruth);
  const auto right = bench.world().look(bench.world().rig.right, kTruth);
  std::vector<Estimate> estimates;
  for (int frame = 0; frame < frames; ++frame)
    estimates.push_back(bench.step(left, right, frame == 0 ? 2400 : 60));
  return estimates;
}

double error_mm(const Estimate& estimate) {
  return (estimate.pose.position_mm - kTruth.t_mm).norm();
}

double relief_error_mm(const Bench& bench, const World& world) {
  const auto& model = const_cast<Bench&>(bench).tracker().photo_model();
  double sum = 0;
  int count = 0;
  for (unsigned i = 0; i < static_cast<unsigned>(model.inner); ++i) {
    if (model.weight[i] == 0) continue;
    const double d = model.z_mm[i] - world.relief_mm(model.x_mm[i], model.y_mm[i]);
    sum += d * d;
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(Relief, FindsTheDepthOfASolidAndTheBiasGoes) {
  for (const double bowl_mm : {-14.0, 14.0}) {
    const World world = world_with(bowl_mm);
    Bench bench(world);
    const auto estimates = watch(bench);
    ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted) << bowl_mm;
    EXPECT_LT(relief_error_mm(bench, world), 2.0) << bowl_mm;
    EXPECT_LT(error_mm(estimates.back()), 1.0) << bowl_mm;
    EXPECT_LT(error_mm(estimates.back()), 0.5 * error_mm(estimates[1])) << bowl_mm;
  }
}

TEST(Relief, IsUsedFromTheFrameTheTargetIsFoundInAndGoodSoonAfter) {
  for (const double bowl_mm : {-14.0, 14.0}) {
    Bench flat(world_with(bowl_mm), 1, Method::kVergence, Stage::kRefined);
    const double biased_mm = error_mm(watch(flat, 1).front());
    Bench bench(world_with(bowl_mm));
    (void)watch(bench, 1);
    EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted) << bowl_mm;
    EXPECT_LT(error_mm(watch(bench, 4).back()), 0.5 * biased_mm) << bowl_mm;
  }
}

// What is stated of a pose holds at each step of learning, and shrinks with it.
TEST(Relief, LeavesThePoseAsOpenAsItsErrorsAre) {
  for (const double bowl_mm : {-14.0, 14.0}) {
    Bench bench(world_with(bowl_mm));
    const auto estimates = watch(bench);
    const auto deviation_mm = [](const Estimate& estimate) {
      return std::sqrt(estimate.covariance.diagonal().head<3>().sum());
    };
    for (const Estimate& estimate : estimates) EXPECT_LT(error_mm(estimate), 3 * deviation_mm(estimate));
    EXPECT_LT(deviation_mm(estimates.back()), 0.5 * deviation_mm(estimates.front())) << bowl_mm;
    EXPECT_LT(deviation_mm(estimates.back()), 1.0) << bowl_mm;
  }
  // A flat card, which the flat model fits, is not stated as open as a solid.
  Bench card(world_with(0));
  EXPECT_LT(std::sqrt(watch(card, 3).back().covariance(2, 2)), 0.5);
}

TEST(Relief, IsUnlearnedWithAllElse) {
  Bench bench(world_with(14));
  (void)watch(bench, 3);
  ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  bench.tracker().unlearn();
  EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kFlat);
  const auto& z_mm = bench.tracker().photo_model().z_mm;
  EXPECT_TRUE(std::all_of(z_mm.begin(), z_mm.end(), [](float z) { return z == 0; }));
}

// Shading is no texture: it does not go along with the target when the lamp goes another way.
TEST(Relief, IsNotDraggedAlongWhereTheLampHasMoved) {
  for (const double lamp_moved : {-0.6, 0.6}) {
    World world = world_with(14);
    world.lamp_moved = lamp_moved;
    Bench bench(world);
    const auto estimates = watch(bench);
    ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted) << lamp_moved;
    EXPECT_LT(error_mm(estimates.back()), 0.6) << lamp_moved;
    const Vector3 off = estimates.back().pose.e - quaternion_vector_from_rotation(kTruth.R);
    EXPECT_LT(off.norm(), 0.008) << lamp_moved;
  }
}

// A relief without a tracker, shown the target standing still.
class Alone {
 public:
  explicit Alone(const World& world, const Transform& T_H_M = kTruth) : world_(world), rig_(world.rig) {
    show(T_H_M);
    world.make_model(*model);
    relief->start(*model);
  }
  void show(const Transform& T_H_M) {
    EXPECT_EQ(make_colour_pyramid(world_.look(rig_.left, T_H_M).view(), *left_), Status::kOk);
    EXPECT_EQ(make_colour_pyramid(world_.look(rig_.right, T_H_M).view(), *right_), Status::kOk);
  }
  // For some frames at a known pose.
  void watch(const Transform& T_H_M, int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      Transform T = T_H_M;
      if (observe(T) == ReliefAdvice::kAdopt) relief->adopt(*model, T);
    }
  }
  ReliefAdvice observe(const Transform& T_H_M) {
    return relief->observe(rig_, *left_, *right_, *model, T_H_M, true);
  }

  std::unique_ptr<PhotoModel> model = std::make_unique<PhotoModel>();
  std::unique_ptr<Relief> relief = std::make_unique<Relief>();

 private:
  World world_;
  StereoRig rig_;
  std::unique_ptr<ColourPyramid> left_ = std::make_unique<ColourPyramid>();
  std::unique_ptr<ColourPyramid> right_ = std::make_unique<ColourPyramid>();
};

double turned(const Transform& T_H_M) {
  return quaternion_vector_from_rotation(kTruth.R.transpose() * T_H_M.R).norm();
}

// A model whose silhouette is an ellipse in the card.
std::unique_ptr<PhotoModel> masked_model() {
  auto model = std::make_unique<PhotoModel>();
  world_with(0).make_model(*model);
  model->masked = true;
  for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
    const float x = model->x_mm[i] / 35;
    const float y = model->y_mm[i] / 25;
    model->weight[i] = x * x + y * y < 1 ? 1 : 0;
  }
  return model;
}

TEST(Relief, InflatesASilhouetteAlongTheRaysOfThePhoto) {
  const auto flat = masked_model();
  const auto relief = std::make_unique<Relief>();
  relief->start(*flat);
  auto model = std::make_unique<PhotoModel>(*flat);
  for (const double share : {1.5, 0.5}) {
    relief->inflate_model(share, *model);
    double sum = 0;
    double nearest_mm = 0;
    for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
      const Vector3 from = flat->optical_centre_mm;
      const Vector3 ray = Vector3(flat->x_mm[i], flat->y_mm[i], 0) - from;
      const Vector3 seen = Vector3(model->x_mm[i], model->y_mm[i], model->z_mm[i]) - from;
      EXPECT_LT(ray.cross(seen).norm() / ray.norm(), 1e-3);
      sum += model->weight[i] * static_cast<double>(model->z_mm[i]);
      nearest_mm = std::min(nearest_mm, static_cast<double>(model->z_mm[i]));
    }
    EXPECT_NEAR(sum / model->inner, 0, 1e-3);
    // An ellipsoid of a half axis of 25 to 35 mm would be nearest by a third of that.
    EXPECT_NEAR(nearest_mm, -10 * share, 3 * share);
  }
  relief->inflate_model(0, *model);
  EXPECT_EQ(model->normals.z, flat->normals.z);
  EXPECT_EQ(model->x_mm, flat->x_mm);
  EXPECT_EQ(model->y_mm, flat->y_mm);
  EXPECT_EQ(model->z_mm, flat->z_mm);
}

TEST(Relief, InflatesNothingWithoutASilhouette) {
  const auto flat = masked_model();
  flat->masked = false;
  const auto relief = std::make_unique<Relief>();
  relief->start(*flat);
  auto model = std::make_unique<PhotoModel>(*flat);
  relief->inflate_model(1, *model);
  EXPECT_EQ(model->z_mm, flat->z_mm);
}

// The flat model's pose may be tilted, and what is learned there has that tilt in it.
TEST(Relief, LosesTheTiltItWasFirstLearnedWith) {
  for (const double tilt_e : {-0.2, 0.2}) {
    Alone alone(world_with(14));
    Transform T_H_M = kTruth * to_transform({{0, 0, 0}, {0, tilt_e, 0}});
    for (int frame = 0; frame < 6; ++frame) {
      if (alone.observe(T_H_M) == ReliefAdvice::kAdopt) alone.relief->adopt(*alone.model, T_H_M);
    }
    EXPECT_EQ(alone.relief->state(), ReliefState::kAdopted) << tilt_e;
    EXPECT_LT(turned(T_H_M), 0.005) << tilt_e;
  }
}

// Farther off no relief that is learned near that tilt leads back: other tilts are tried, once.
TEST(Relief, LeavesATiltFarOffTheRightOne) {
  for (const double bowl_mm : {-30.0, 30.0}) {
    for (const Vector3& tilt_e : {Vector3{-0.42, 0, 0}, {0.42, 0, 0}, {0, -0.42, 0}, {0, 0.42, 0}}) {
      Alone alone(world_with(bowl_mm));
      Transform T_H_M = kTruth * to_transform({Vector3::Zero(), tilt_e});
      for (int frame = 0; frame < 7; ++frame) {
        if (alone.observe(T_H_M) == ReliefAdvice::kAdopt) alone.relief->adopt(*alone.model, T_H_M);
      }
      EXPECT_EQ(alone.relief->state(), ReliefState::kAdopted) << bowl_mm << ", " << tilt_e.transpose();
      EXPECT_LT(turned(T_H_M), 0.005) << bowl_mm << ", " << tilt_e.transpose();
    }
  }
}

// Seen more from the side than before, a target hides part of what its photo shows: no view to learn from for
// long.
TEST(Relief, IsLeftAsItIsWhereTheEyesSeeItFromTheSide) {
  Alone alone(world_with(14), kAhead);
  alone.watch(kAhead, 10);
  ASSERT_EQ(alone.relief->state(), ReliefState::kAdopted);
  alone.show(kTurnedAway);
  alone.watch(kTurnedAway, 1);  // the first of a view is learned from
  const int frames = alone.relief->frames();
  const auto z_mm = alone.model->z_mm;
  alone.watch(kTurnedAway, 10);
  EXPECT_EQ(alone.relief->frames(), frames);
  EXPECT_EQ(alone.model->z_mm, z_mm);
  alone.show(kAhead);
  alone.watch(kAhead, 5);
  EXPECT_EQ(alone.relief->frames(), frames + 5);
}

TEST(Relief, IsLearnedAnewWhereItWasLearnedFromTheSide) {
  Alone alone(world_with(14), kTurnedAway);
  alone.watch(kTurnedAway, 60);
  ASSERT_EQ(alone.relief->state(), ReliefState::kAdopted);
  EXPECT_FALSE(alone.relief->learning());
  alone.show(kAhead);
  alone.watch(kAhead, 10);
  EXPECT_TRUE(alone.relief->learning());
  EXPECT_FALSE(alone.relief->is_young()) << "it has been proved";
  EXPECT_EQ(alone.relief->state(), ReliefState::kAdopted);
}

// A crop of what the right eye sees, said to have been taken straight on: a relief that explains it with the
// left eye turns the target, and spoils the right eye's likeness.
TEST(Relief, IsNotAdoptedWhereThePhotoIsNotWhatItsCameraSaw) {
  for (const double bowl_mm : {-14.0, 14.0}) {
    const World world = world_with(bowl_mm);
    const Transform T_H_M{Matrix3::Identity(), {-20, 0, 400}};  // 80 mm left of the right eye
    Alone alone(world, T_H_M);
    const Picture photo = world.look(world.rig.right, T_H_M);
    PhotoSource source;
    source.photo = photo.view();
    source.roi = {35, 85, 90, 70};
    source.distance_mm = 400;
    source.camera = world.rig.right;
    source.camera.cx_px = 79.5;
    source.background_hue_deg = 210;
    PhotoOptions options;
    options.points = 600;
    ASSERT_EQ(build_photo_model(source, options, {}, *alone.model), Status::kOk);
    alone.relief->start(*alone.model);
    Transform T = T_H_M;
    for (int frame = 0; frame < kFrames; ++frame) {
      if (alone.observe(T) == ReliefAdvice::kAdopt) alone.relief->adopt(*alone.model, T);
    }
    EXPECT_NE(alone.relief->state(), ReliefState::kAdopted) << bowl_mm;
  }
}

// What is learned of a flat card at a wrong pose explains that pose. At the right one the flat model does as
// well.
TEST(Relief, IsGivenBackWhereTheFlatModelDoesAsWell) {
  Alone alone(world_with(0));
  Transform T_H_M = kTruth * to_transform({{0, 0, 0}, {0, 0.25, 0}});
  ASSERT_EQ(alone.observe(T_H_M), ReliefAdvice::kAdopt);
  alone.relief->adopt(*alone.model, T_H_M);
  ASSERT_EQ(alone.observe(T_H_M), ReliefAdvice::kGiveBack);
  alone.relief->give_back(*alone.model);
  for (const float z : alone.model->z_mm) EXPECT_EQ(z, 0);
  EXPECT_LT((alone.relief->flat_pose().t_mm - kTruth.t_mm).norm(), 1.0);
  EXPECT_LT(turned(alone.relief->flat_pose()), 0.01);
}

// What it was learned from may have been something else.
TEST(Relief, IsGivenBackWhereItIsYoungAndTheTargetGone) {
  Bench bench(world_with(14));
  const PhotoModel flat = bench.tracker().photo_model();
  (void)watch(bench, 2);
  ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  bench.world().present = false;
  (void)watch(bench, 1);
  EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kFlat);
  const PhotoModel& model = bench.tracker().photo_model();
  EXPECT_EQ(model.x_mm, flat.x_mm);
  EXPECT_EQ(model.y_mm, flat.y_mm);
  EXPECT_EQ(model.z_mm, flat.z_mm);
  EXPECT_EQ(model.weight, flat.weight);
}

// A card of the same picture has come in the solid's place. Every second frame of a search does without what
// was learned.
TEST(Relief, IsGivenBackWhereTheTargetIsRecognizedWithoutItOnly) {
  Bench bench(world_with(-55));
  (void)watch(bench);
  ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  bench.tracker().forget();
  bench.world().bowl_mm = 0;
  const Transform turned_away{kTruth.R * rotation_from_quaternion_vector({0, -0.25, 0}), kTruth.t_mm};
  EXPECT_NE(bench.step(turned_away, 3900).state, TrackState::kTracking);
  EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  const Estimate estimate = bench.step(turned_away, 3900);
  EXPECT_EQ(estimate.state, TrackState::kTracking);
  EXPECT_NE(bench.tracker().relief_state(), ReliefState::kAdopted);
  EXPECT_LT((estimate.pose.position_mm - turned_away.t_mm).norm(), 0.5);
}

TEST(Relief, IsTakenUpAgainAfterASearchWithoutIt) {
  Bench bench(world_with(14));
  (void)watch(bench);
  const PhotoModel learned = bench.tracker().photo_model();
  bench.world().present = false;
  for (int frames = 1; frames <= 4; ++frames) {
    (void)watch(bench, 1);
    ASSERT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted) << frames;
    EXPECT_EQ(bench.tracker().photo_model().z_mm, learned.z_mm) << frames;
    EXPECT_EQ(bench.tracker().photo_model().weight, learned.weight) << frames;
  }
  bench.world().present = true;
  // Four frames, of which the first was the one it was lost in: this one does without.
  EXPECT_LT(error_mm(watch(bench, 1).front()), 1.0);
  EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  EXPECT_EQ(bench.tracker().photo_model().z_mm, learned.z_mm);
}

// A frame of such a search that is begun again, or forgotten, before its end.
TEST(Relief, IsTakenUpAgainWhereASearchWithoutItIsNotEnded) {
  Bench bench(world_with(14));
  (void)watch(bench);
  const PhotoModel learned = bench.tracker().photo_model();
  bench.world().present = false;
  (void)watch(bench, 2);
  const Picture left = bench.world().look(bench.world().rig.left, kTruth);
  const Picture right = bench.world().look(bench.world().rig.right, kTruth);
  FrameMotion motion;
  motion.T_H_CL = bench.world().rig.left.T_H_C;
  motion.T_H_CR = bench.world().rig.right.T_H_C;
  for (int begun = 0; begun < 2; ++begun) {
    ASSERT_EQ(bench.tracker().begin_frame(100, left.view(), right.view(), motion), Status::kOk);
    EXPECT_NE(bench.tracker().photo_model().z_mm, learned.z_mm);
  }
  bench.tracker().forget();
  EXPECT_EQ(bench.tracker().photo_model().z_mm, learned.z_mm);
  EXPECT_EQ(bench.tracker().photo_model().weight, learned.weight);
}

TEST(Relief, LeavesAFlatCardFlat) {
  Bench bench(world_with(0));
  const auto estimates = watch(bench);
  EXPECT_NE(bench.tracker().relief_state(), ReliefState::kAdopted);
  for (const float z : bench.tracker().photo_model().z_mm) EXPECT_EQ(z, 0);
  EXPECT_LT(error_mm(estimates.back()), error_mm(estimates[1]) + 0.05);
}

TEST(Relief, LearnsNothingWhereThereIsNoTarget) {
  Bench bench(world_with(14));
  bench.world().present = false;
  (void)watch(bench, 20);
  EXPECT_NE(bench.tracker().relief_state(), ReliefState::kAdopted);
}

TEST(Relief, IsKeptWhereTheTargetIsLostAndFoundAgain) {
  Bench bench(world_with(14));
  (void)watch(bench);
  bench.tracker().forget();
  EXPECT_EQ(bench.tracker().relief_state(), ReliefState::kAdopted);
  EXPECT_LT(error_mm(watch(bench, 1).front()), 1.0);
}

TEST(Relief, HasTheSameBitsOnEveryTarget) {
  std::uint64_t first = 0;
  for_every_target([&] {
    Bench bench(world_with(14));
    (void)watch(bench, 18);
    std::uint64_t hash = 0xCBF29CE484222325ULL;
    for (const float z : bench.tracker().photo_model().z_mm)
      hash = (hash ^ std::bit_cast<std::uint32_t>(z)) * 0x100000001B3ULL;
    if (first == 0) first = hash;
    EXPECT_EQ(hash, first);
  });
  EXPECT_EQ(first, 0xD32B2E0F17EBA753ULL) << "the same on every processor";
}

}  // namespace
}  // namespace vergence
