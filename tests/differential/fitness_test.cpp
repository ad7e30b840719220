// The vector evaluator against the plain one, on every instruction set, for any pose, lens and image.
#include "algo/fitness.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <memory>
#include <vector>

#include "algo/rm_ga.hpp"
#include "tests/differential/every_target.hpp"
#include "tests/differential/scalar_fitness.hpp"

namespace vergence {
namespace {

double uniform(CounterRandom& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random.next() >> 11) / 9007199254740992.0;
}

CameraModel any_camera(CounterRandom& random, bool distorted) {
  CameraModel camera;
  camera.width_px = 16 + static_cast<int>(random.below(320));
  camera.height_px = 16 + static_cast<int>(random.below(240));
  camera.fx_px = uniform(random, 100, 900);
  camera.fy_px = uniform(random, 100, 900);
  camera.cx_px = uniform(random, 0, camera.width_px);
  camera.cy_px = uniform(random, 0, camera.height_px);
  if (distorted) {
    for (double& k : camera.distortion) k = uniform(random, -0.3, 0.3);
  }
  return camera;
}

Transform any_pose(CounterRandom& random) {
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    pose.position_mm[i] = uniform(random, -300, 300);
    pose.e[i] = uniform(random, -0.6, 0.6);
  }
  // Also beside the image, across the camera's plane and behind it.
  pose.position_mm[2] = uniform(random, -100, 900);
  return to_transform(pose);
}

void any_plane(CounterRandom& random, const CameraModel& camera, HuePlane& plane) {
  plane.width_px = camera.width_px;
  plane.height_px = camera.height_px;
  for (int i = 0; i < camera.width_px * camera.height_px; ++i) {
    plane.code[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(random.below(255));
  }
  plane.code[static_cast<std::size_t>(plane.outside_index())] = kHueOutside;
}

TEST(MarkerVotes, EqualThePlainEvaluator) {
  const auto plane = std::make_unique<HuePlane>();
  const auto model = std::make_unique<MarkerModel>();
  for_every_target([&] {
    CounterRandom random(11, 0);
    for (int trial = 0; trial < 400; ++trial) {
      const CameraModel camera = any_camera(random, trial % 2 == 1);
      any_plane(random, camera, *plane);
      std::vector<Ball> balls(1 + random.below(kMaxBalls));
      for (Ball& ball : balls) {
        ball.centre_mm = {uniform(random, -80, 80), uniform(random, -80, 80), uniform(random, -80, 80)};
        ball.radius_mm = uniform(random, 2, 60);
        ball.hue_deg = uniform(random, 0, 360);
        ball.tolerance_deg = uniform(random, 1, 90);
      }
      MarkerOptions options;
      options.inner_samples = 1 + static_cast<int>(random.below(kMaxInnerSamples));
      options.outer_samples = 1 + static_cast<int>(random.below(kMaxOuterSamples));
      ASSERT_EQ(build_marker_model(balls.data(), static_cast<int>(balls.size()), options, *model),
                Status::kOk);
      for (int k = 0; k < 20; ++k) {
        const Transform T_C_M = any_pose(random);
        ASSERT_EQ(marker_votes(*model, camera, *plane, T_C_M),
                  reference::marker_votes(*model, camera, *plane, T_C_M));
      }
    }
  });
}

TEST(PhotoVotes, EqualThePlainEvaluator) {
  const auto plane = std::make_unique<HuePlane>();
  const auto model = std::make_unique<PhotoModel>();
  for_every_target([&] {
    CounterRandom random(12, 0);
    for (int trial = 0; trial < 200; ++trial) {
      const CameraModel camera = any_camera(random, trial % 2 == 1);
      any_plane(random, camera, *plane);
      model->inner = 1 + static_cast<int>(random.below(900));
      model->outer = static_cast<int>(random.below(300));
      model->background_hue = static_cast<std::uint8_t>(random.below(253));
      for (unsigned i = 0; i < static_cast<unsigned>(model->points()); ++i) {
        model->x_mm[i] = static_cast<float>(uniform(random, -90, 90));
        model->y_mm[i] = static_cast<float>(uniform(random, -90, 90));
        model->z_mm[i] = trial % 3 == 0 ? 0.0F : static_cast<float>(uniform(random, -40, 40));
        model->hue[i] = static_cast<std::uint8_t>(random.below(255));
      }
      for (int k = 0; k < 20; ++k) {
        const Transform T_C_M = any_pose(random);
        ASSERT_EQ(photo_votes(*model, camera, *plane, T_C_M),
                  reference::photo_votes(*model, camera, *plane, T_C_M));
      }
    }
  });
}

// A plane painted with the marker itself, seen at a pose: the fitness there is the maximum of Eq. 3.20.
TEST(MarkerFitness, ReachesItsMaximumOnAPerfectImage) {
  const auto plane = std::make_unique<HuePlane>();
  const auto model = std::make_unique<MarkerModel>();
  const Ball balls[3] = {{{-60, 0, 0}, 20, 0, 20}, {{60, 20, -10}, 20, 120, 20}, {{0, -50, 15}, 20, 240, 20}};
  ASSERT_EQ(build_marker_model(balls, 3, {}, *model), Status::kOk);
  ASSERT_EQ(model->samples_per_camera(), 180);
  const CameraModel camera;
  const Transform T_C_M = to_transform({{10, -20, 500}, {0.05, -0.1, 0.2}});
  plane->width_px = camera.width_px;
  plane->height_px = camera.height_px;
  plane->code.fill(kHueUndefined);
  plane->code[static_cast<std::size_t>(plane->outside_index())] = kHueOutside;
  for (const Ball& ball : balls) {
    const Vector3 centre = T_C_M * ball.centre_mm;
    Vector2 uv;
    ASSERT_TRUE(project(camera, centre, uv));
    const double radius = camera.fx_px * ball.radius_mm / centre[2] * 1.1;  // S_in lies within, S_out beyond
    for (int y = 0; y < plane->height_px; ++y) {
      for (int x = 0; x < plane->width_px; ++x) {
        const bool on_ball = (x - uv[0]) * (x - uv[0]) + (y - uv[1]) * (y - uv[1]) < radius * radius;
        if (on_ball)
          plane->code[static_cast<std::size_t>(y * plane->width_px + x)] =
              hue_code_from_degrees(ball.hue_deg);
      }
    }
  }
  const std::int32_t votes = marker_votes(*model, camera, *plane, T_C_M);
  EXPECT_EQ(votes, 180);
  EXPECT_DOUBLE_EQ(marker_fitness(*model, 2 * votes), 180.0 / 108.0);
}

TEST(Fitness, ATargetBehindTheCamerasOnlyVotesOtherwise) {
  const auto plane = std::make_unique<HuePlane>();
  const auto model = std::make_unique<MarkerModel>();
  const Ball ball{{0, 0, 0}, 20, 0, 20};
  ASSERT_EQ(build_marker_model(&ball, 1, {}, *model), Status::kOk);
  plane->width_px = 640;
  plane->height_px = 480;  // all red
  plane->code[static_cast<std::size_t>(plane->outside_index())] = kHueOutside;
  EXPECT_EQ(marker_votes(*model, {}, *plane, to_transform({{0, 0, -500}, {0, 0, 0}})), -36 + 24);
  EXPECT_EQ(marker_votes(*model, {}, *plane, to_transform({{0, 0, 500}, {0, 0, 0}})), 36 - 24);
  EXPECT_EQ(marker_votes(*model, {}, *plane, to_transform({{9000, 0, 500}, {0, 0, 0}})), -36 + 24);
}

}  // namespace
}  // namespace vergence
