// What is behind the target: found in the images, kept out of the model, and no hindrance to recognizing it.
#include "algo/backdrop.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "algo/correlation.hpp"
#include "algo/rm_ga.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::Bench;
using testing::Picture;
using testing::Rgb;
using testing::World;

constexpr Rgb kTan{1.9, 1.0, 0.45};  // times the wall, which is blue
constexpr Rgb kGreen{0.6, 1.5, 0.45};
constexpr Rgb kGrey{1.6, 1.07, 0.8};

// One colour on the left, another on the right of `split_px`.
Picture split(const YCbCr& left, const YCbCr& right, int split_px) {
  Picture picture{320, 240, std::vector<std::uint8_t>(320 * 240 * 3)};
  const auto byte = [](double v) { return static_cast<std::uint8_t>(v < 0 ? 0 : v > 255 ? 255 : v + 0.5); };
  for (int i = 0; i < 320 * 240; ++i) {
    const YCbCr& c = i % 320 < split_px ? left : right;
    std::uint8_t* rgb = &picture.rgb[static_cast<std::size_t>(i) * 3];
    rgb[0] = byte(c.luma + 1.402 * (c.cr - 128));
    rgb[1] = byte(c.luma - 0.344 * (c.cb - 128) - 0.714 * (c.cr - 128));
    rgb[2] = byte(c.luma + 1.772 * (c.cb - 128));
  }
  return picture;
}

Backdrop backdrop_of(const Picture& picture, bool limited_range = false) {
  const auto pyramid = std::make_unique<ColourPyramid>();
  EXPECT_EQ(make_colour_pyramid(picture.view(), *pyramid), Status::kOk);
  return find_backdrop(*pyramid, *pyramid, limited_range);
}

void expect_near(const YCbCr& a, const YCbCr& b, int tolerance) {
  EXPECT_NEAR(a.luma, b.luma, tolerance);
  EXPECT_NEAR(a.cb, b.cb, tolerance);
  EXPECT_NEAR(a.cr, b.cr, tolerance);
}

TEST(Backdrop, IsWhatMostOfTheImagesShow) {
  constexpr YCbCr kWall{120, 150, 110};
  constexpr YCbCr kThing{60, 90, 180};
  for (const int wall_px : {320, 250, 200}) {
    const Backdrop backdrop = backdrop_of(split(kWall, kThing, wall_px));
    expect_near(backdrop.colour, kWall, 2);
    EXPECT_TRUE(backdrop.plain) << wall_px;
  }
  EXPECT_FALSE(backdrop_of(split(kWall, kThing, 170)).plain);
  EXPECT_FALSE(backdrop_of(split({40, 128, 128}, {200, 128, 128}, 160)).plain);  // of luma alone
}

TEST(Backdrop, IsOfFullRangeAsPhotosAre) {
  expect_near(backdrop_of(split({235, 128, 128}, {235, 128, 128}, 320), true).colour, {255, 128, 128}, 1);
  expect_near(backdrop_of(split({16, 128, 128}, {16, 128, 128}, 320), true).colour, {0, 128, 128}, 1);
  expect_near(backdrop_of(split({126, 154, 100}, {126, 154, 100}, 320), true).colour, {128, 158, 96}, 3);
}

PhotoBackdrop plain_photo(const YCbCr& mean) {
  PhotoBackdrop backdrop;
  backdrop.mean = mean;
  backdrop.plain = true;
  return backdrop;
}

TEST(Backdrop, IsTheSameInOtherLightAndAnotherInAnotherColour) {
  constexpr YCbCr kBlue{95, 164, 99};
  const auto photo = std::make_unique<PhotoBackdrop>(plain_photo(kBlue));
  for (const double light : {0.4, 0.7, 1.0, 1.5, 2.0}) {
    const auto lit = [&](int chroma) { return static_cast<std::uint8_t>(128 + light * (chroma - 128)); };
    const YCbCr seen{static_cast<std::uint8_t>(light * kBlue.luma), lit(kBlue.cb), lit(kBlue.cr)};
    EXPECT_EQ(backdrop_change(*photo, {seen, true}), 0) << light;
  }
  EXPECT_EQ(backdrop_change(*photo, {{118, 94, 159}, true}), 256);  // tan
  EXPECT_EQ(backdrop_change(*photo, {{95, 128, 128}, true}), 256);  // grey
  const int between = backdrop_change(*photo, {{95, 150, 110}, true});
  EXPECT_GT(between, 0);
  EXPECT_LT(between, 256);
  photo->plain = false;  // of many colours
  EXPECT_EQ(backdrop_change(*photo, {kBlue, true}), 256);
}

// A model whose silhouette is known, of a target that is nothing but that.
World cut_out_world() {
  World world(TargetKind::kPhoto);
  world.oval = true;
  world.cut_out = true;
  return world;
}

std::unique_ptr<PhotoModel> cut_out_model() {
  auto model = std::make_unique<PhotoModel>();
  cut_out_world().make_model(*model);
  return model;
}

TEST(Backdrop, OfThePhotoIsKnown) {
  const auto model = cut_out_model();
  EXPECT_TRUE(model->masked);
  EXPECT_TRUE(model->backdrop.plain);
  const testing::Rgb wall = testing::wall_colour(0, 0);
  EXPECT_NEAR(model->backdrop.mean.luma, 0.3 * wall.r + 0.59 * wall.g + 0.11 * wall.b, 15);
  EXPECT_GT(model->backdrop.mean.cb, 134);
  int rim = 0;
  for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
    const int share = model->backdrop.share[0][i];
    EXPECT_EQ(share, model->weight[i] == 0 ? 255 : 0) << i;  // a pixel is of one or the other
    rim += model->weight[i] == 0 ? 1 : 0;
    const double from_middle = std::hypot(model->x_mm[i] / (0.4 * testing::kCardWidth_mm),
                                          model->y_mm[i] / (0.4 * testing::kCardHeight_mm));
    if (from_middle < 0.7) {
      EXPECT_EQ(model->backdrop.share[3][i], 0) << i;
    } else if (from_middle > 0.95 && from_middle < 1.05) {
      EXPECT_GT(model->backdrop.share[3][i], 40) << i;
      EXPECT_LT(model->backdrop.share[3][i], 215) << i;
    }
  }
  EXPECT_GT(rim, 100);
  World speckled(TargetKind::kPhoto);
  speckled.oval = true;  // the rest of the card is behind it
  speckled.make_model(*model);
  EXPECT_FALSE(model->backdrop.plain);
}

TEST(Backdrop, TakesThePlaceOfThePhotosAndNothingElse) {
  const auto model = cut_out_model();
  const auto as_photographed = model->colour;
  constexpr YCbCr kSeen{200, 90, 160};
  put_before({kSeen, true}, 0, as_photographed, *model);
  for (unsigned level = 0; level < kColourLevels; ++level) {
    EXPECT_EQ(model->colour[level].luma, as_photographed[level].luma);
    EXPECT_EQ(model->colour[level].cr, as_photographed[level].cr);
  }
  for (const int change : {256, 100}) {
    put_before({kSeen, true}, change, as_photographed, *model);
    for (unsigned level = 0; level < kColourLevels; ++level) {
      for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
        const double share = model->backdrop.share[level][i] / 255.0 * change / 256;
        const double moved = share * (kSeen.luma - model->backdrop.colour[level].luma[i]);
        EXPECT_NEAR(model->colour[level].luma[i], as_photographed[level].luma[i] + moved, 0.51 + 1e-9);
        if (model->backdrop.share[level][i] == 255 && change == 256) {
          EXPECT_EQ(model->colour[level].cb[i], kSeen.cb);
          EXPECT_EQ(model->colour[level].cr[i], kSeen.cr);
        }
      }
    }
  }
}

// Whatever is there, a rim that is left out has no say.
TEST(Backdrop, OfManyColoursLeavesTheRimOut) {
  World world = cut_out_world();
  const auto model = cut_out_model();
  leave_rim_out(true, *model);
  const auto measure = std::make_unique<CorrelationModel>();
  build_correlation_model(*model, 0, 600, HiddenPoints::kLeftOut, *measure);
  const Transform T_H_M{Matrix3::Identity(), {5, -3, 420}};
  const auto pyramid = std::make_unique<ColourPyramid>();
  const auto likeness = [&](const Rgb& left, const Rgb& right) {
    world.left_wall = left;
    world.right_wall = right;
    EXPECT_EQ(make_colour_pyramid(world.look(world.rig.left, T_H_M).view(), *pyramid), Status::kOk);
    return static_cast<double>(correlation(*measure, *model, world.rig.left, level_of(*pyramid, 0),
                                           target_in_camera(world.rig.left, T_H_M))) /
           static_cast<double>(kCorrelationOne);
  };
  const double before_its_own = likeness({1, 1, 1}, {1, 1, 1});
  EXPECT_GT(before_its_own, 0.9);
  EXPECT_NEAR(likeness(kTan, kGreen), before_its_own, 0.05);  // what is left is the blur of its edge
  leave_rim_out(false, *model);
  build_correlation_model(*model, 0, 600, HiddenPoints::kLeftOut, *measure);
  EXPECT_LT(likeness(kTan, kGreen), before_its_own - 0.1);
}

// Found from nothing, as often as before its own wall.
TEST(Backdrop, DoesNotHinderTheTargetFromBeingFound) {
  struct Walls {
    Rgb left;
    Rgb right;
    double light;
  };
  const std::vector<Walls> all{{{1, 1, 1}, {1, 1, 1}, 1}, {kTan, kTan, 1},   {kGreen, kGreen, 0.7},
                               {kGrey, kGrey, 1.1},       {kTan, kGreen, 1}, {{2, 2, 2}, {2, 2, 2}, 1}};
  CounterRandom random(5, 1);
  const auto within = [&random](double range) {
    return range * (static_cast<double>(random.next() >> 11) / 4503599627370496.0 - 1);
  };
  for (const Walls& walls : all) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      World world = cut_out_world();
      world.left_wall = walls.left;
      world.right_wall = walls.right;
      world.light = walls.light;
      Bench bench(world, seed);
      const Transform truth = to_transform(
          {{within(60), within(50), 450 + within(60)}, {within(0.15), within(0.15), within(0.25)}});
      Estimate estimate;
      for (int frame = 0; frame < 2 && estimate.state != TrackState::kTracking; ++frame) {
        estimate = bench.step(truth, 1500);
      }
      EXPECT_EQ(estimate.state, TrackState::kTracking)
          << walls.left.r << ' ' << walls.right.g << ' ' << seed << ": " << estimate.confidence;
      EXPECT_LT((estimate.pose.position_mm - truth.t_mm).norm(), 4) << walls.left.r << ' ' << seed;
    }
  }
}

// Nor is it seen where it is not.
TEST(Backdrop, IsNoTarget) {
  for (const auto& [left, right] : {std::pair{kTan, kTan}, {kTan, kGreen}, {kGrey, kGrey}}) {
    World world = cut_out_world();
    world.left_wall = left;
    world.right_wall = right;
    world.present = false;
    Bench bench(world, 1);
    for (int frame = 0; frame < 3; ++frame) {
      EXPECT_NE(bench.step(Transform{Matrix3::Identity(), {0, 0, 450}}, 600).state, TrackState::kTracking);
    }
  }
}

}  // namespace
}  // namespace vergence
