// Stereo calibration on rendered boards: what it finds of cameras that are known, and what it says of its
// errors.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <numbers>
#include <vector>

#include "algo/rotation_vector.hpp"
#include "tests/support/chessboard.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/calibrate/find_corners.hpp"
#include "tools/calibrate/rig_file.hpp"
#include "tools/calibrate/stereo.hpp"
#include "tools/calibrate/view_quality.hpp"
#include "tools/io/dataset.hpp"

namespace vergence::test {
namespace {

using calibrate::Board;
using calibrate::CornerPair;
using calibrate::Corners;

constexpr Board kBoard{9, 6, 20};
constexpr double kNoise = 2;  // levels of 255
constexpr double kDegree = std::numbers::pi / 180;

Corners projected(const CameraModel& camera, const Transform& T_C_B, const Board& board) {
  Corners corners(board.corners());
  for (std::size_t i = 0; i < corners.size(); ++i)
    EXPECT_TRUE(project(camera, T_C_B * board.corner_mm(i), corners[i]));
  return corners;
}

double rms_px(const Corners& a, const Corners& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]).squaredNorm();
  return std::sqrt(squares / static_cast<double>(a.size()));
}

// Sightings without pictures: corners projected, with noise.
calibrate::Sightings exact_sightings(const StereoRig& rig, const std::vector<Transform>& T_H_B,
                                     const Board& board, double noise_px, std::uint64_t seed) {
  testing::Random random(seed);
  calibrate::Sightings sightings{640, 480, {}, {}};
  for (std::size_t i = 0; i < T_H_B.size(); ++i) {
    calibrate::Sighting sighting;
    sighting.pair.number = static_cast<int>(i);
    for (const std::size_t side : {0U, 1U}) {
      const CameraModel& camera = side == 0 ? rig.left : rig.right;
      sighting.corners[side] = projected(camera, camera.T_H_C.inverse() * T_H_B[i], board);
      for (Vector2& uv : sighting.corners[side]) uv += noise_px * normal3(random).head<2>();
    }
    sightings.seen.push_back(sighting);
  }
  return sightings;
}

TEST(CalibrateCorners, AreWithinAThirtiethOfAPixel) {
  const StereoRig rig = true_rig();
  const ChessboardPainter painter(rig.left);
  for (const Transform& T_H_B : board_poses(rig, kBoard, 4, 3)) {
    const Transform T_C_B = rig.left.T_H_C.inverse() * T_H_B;
    const auto corners = calibrate::find_corners(painter.paint(T_C_B, kBoard, kNoise, 1), kBoard);
    ASSERT_TRUE(corners);
    EXPECT_LT(rms_px(*corners, projected(rig.left, T_C_B, kBoard)), 0.033);
  }
}

TEST(CalibrateCorners, AreInTheSameOrderHoweverTheBoardIsTurned) {
  const StereoRig rig = true_rig();
  const ChessboardPainter painter(rig.left);
  for (const double roll : {0.0, 80.0, 120.0, 180.0, -100.0}) {
    Transform T_C_B{turn_deg(20, {1, 0.3, 0}) * turn_deg(roll, {0, 0, 1}), {}};
    T_C_B.t_mm = Vector3(0, 0, 600) - T_C_B.R * kBoard.centre_mm();
    const auto corners = calibrate::find_corners(painter.paint(T_C_B, kBoard, kNoise, 1), kBoard);
    ASSERT_TRUE(corners) << roll;
    EXPECT_LT(rms_px(*corners, projected(rig.left, T_C_B, kBoard)), 0.05) << roll;
  }
}

TEST(CalibrateCorners, OfASymmetricBoardFollowTheDirection) {
  const ChessboardPainter painter(true_rig().left);
  for (const Board board : {Board{8, 6, 20}, Board{7, 7, 20}}) {
    Transform T_C_B{turn_deg(20, {1, 0.3, 0}), {}};
    T_C_B.t_mm = Vector3(0, 0, 500) - T_C_B.R * board.centre_mm();
    const tools::GreyImage image = painter.paint(T_C_B, board, kNoise, 1);
    for (const Vector2& direction : {Vector2{1, 0.2}, Vector2{-1, 0.1}}) {
      const auto corners = calibrate::find_corners(image, board, direction);
      ASSERT_TRUE(corners);
      EXPECT_GT(calibrate::row_direction(*corners, board).normalized().dot(direction.normalized()), 0.9);
    }
  }
}

TEST(CalibrateCorners, AreNotFoundWhereThereIsNoBoard) {
  tools::GreyImage image{320, 240, {}};
  testing::Random random(1);
  for (int i = 0; i < 320 * 240; ++i) image.data.push_back(static_cast<std::uint8_t>(random.below(256)));
  EXPECT_FALSE(calibrate::find_corners(image, kBoard));
}

TEST(CalibrateStereo, RayIsTheInverseOfProjection) {
  for (const CameraModel& camera : {true_rig().left, true_rig().right}) {
    for (const Vector2& pixel : {Vector2{0, 0}, Vector2{639, 0}, Vector2{200, 479}, Vector2{322.3, 236.8}}) {
      Vector2 uv;
      ASSERT_TRUE(project(camera, 500 * calibrate::ray(camera, pixel), uv));
      EXPECT_NEAR((uv - pixel).norm(), 0, 1e-8);
    }
  }
}

TEST(CalibrateStereo, IsExactOnExactCorners) {
  const StereoRig rig = true_rig();
  const auto result =
      calibrate_stereo("", exact_sightings(rig, board_poses(rig, kBoard, 12, 1), kBoard, 0, 1), kBoard, {});
  EXPECT_NEAR(result.rig.left.fx_px, rig.left.fx_px, 1e-4);
  EXPECT_NEAR(result.rig.right.cy_px, rig.right.cy_px, 1e-4);
  EXPECT_NEAR(result.rig.right.distortion[1], rig.right.distortion[1], 1e-5);
  EXPECT_NEAR(result.baseline_mm, (rig.left.T_H_C.t_mm - rig.right.T_H_C.t_mm).norm(), 1e-4);
  EXPECT_LT(result.epipolar.largest_px, 1e-4);
}

// The stated deviations are right: over many calibrations, squared errors over stated variances are near one.
TEST(CalibrateStereo, StatesItsUncertaintyRight) {
  const StereoRig rig = true_rig();
  constexpr int kRuns = 30;
  constexpr double kCornerNoise_px = 0.1;
  const double baseline_mm = (rig.left.T_H_C.t_mm - rig.right.T_H_C.t_mm).norm();
  double squares = 0;
  int count = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    const auto poses = board_poses(rig, kBoard, 10, 100 + seed);
    const auto result =
        calibrate_stereo("", exact_sightings(rig, poses, kBoard, kCornerNoise_px, seed), kBoard, {});
    const auto add = [&](double error, double sigma) {
      squares += error * error / (sigma * sigma);
      ++count;
    };
    add(result.rig.left.fx_px - rig.left.fx_px, result.sigma[0][0]);
    add(result.rig.left.cx_px - rig.left.cx_px, result.sigma[0][2]);
    add(result.rig.right.fy_px - rig.right.fy_px, result.sigma[1][1]);
    add(result.rig.right.cy_px - rig.right.cy_px, result.sigma[1][3]);
    add(result.baseline_mm - baseline_mm, result.baseline_sigma_mm);
    EXPECT_NEAR(result.rms_px[0], kCornerNoise_px * std::sqrt(2.0), 0.01);
  }
  // 150 squares; those of one run hang together, so the mean of chi squares scatters by about 0.2.
  EXPECT_GT(squares / count, 0.5);
  EXPECT_LT(squares / count, 1.8);
}

// From pictures. Tolerances: four of the deviations that the fit itself states (their truth is the test
// above), and the limits that a user counts on.
TEST(CalibrateStereo, RecoversTheCamerasFromPictures) {
  const StereoRig rig = true_rig();
  const TempDirectory directory;
  write_board_pictures(directory.path(), rig, board_poses(rig, kBoard, 20, 1), kBoard, kNoise, 1);
  const auto sightings = calibrate::find_board(calibrate::list_pairs(directory.path()), kBoard);
  ASSERT_EQ(sightings.seen.size(), 20U);
  const auto result = calibrate_stereo(directory.path(), sightings, kBoard, {});
  for (const std::size_t side : {0U, 1U}) {
    const CameraModel& truth = side == 0 ? rig.left : rig.right;
    const CameraModel& found = side == 0 ? result.rig.left : result.rig.right;
    const double errors[] = {found.fx_px - truth.fx_px, found.fy_px - truth.fy_px, found.cx_px - truth.cx_px,
                             found.cy_px - truth.cy_px};
    for (int i = 0; i < 4; ++i) {
      EXPECT_LT(std::abs(errors[i]), 4 * result.sigma[side][i]) << side << ' ' << i;
      EXPECT_LT(std::abs(errors[i]), 0.3) << side << ' ' << i;
    }
    EXPECT_LT(result.rms_px[side], 0.05);
  }
  const Transform T_CR_CL = rig.right.T_H_C.inverse() * rig.left.T_H_C;
  EXPECT_NEAR(result.baseline_mm, T_CR_CL.t_mm.norm(), 0.05);
  EXPECT_LT(vector_from_rotation(result.T_CR_CL.R * T_CR_CL.R.transpose()).norm() / kDegree, 0.02);
  EXPECT_LT(result.epipolar.rms_px, 0.05);
  EXPECT_EQ(result.views.size(), 20U);
  for (const auto& view : result.views) EXPECT_TRUE(view.used) << view.number;
}

TEST(CalibrateStereo, LeavesOutAPairOfTwoMomentsAndSaysWhich) {
  const StereoRig rig = true_rig();
  const auto poses = board_poses(rig, kBoard, 12, 5);
  auto sightings = exact_sightings(rig, poses, kBoard, 0.1, 1);
  for (Vector2& uv : sightings.seen[7].corners[1])
    uv += Vector2(6, -3);  // the board moved between the pictures
  const auto result = calibrate_stereo("", sightings, kBoard, {});
  for (const auto& view : result.views) EXPECT_EQ(view.used, view.number != 7) << view.number;
  EXPECT_GT(result.views[7].rms_px[1], 1);
  EXPECT_LT(std::abs(result.rig.left.fx_px - rig.left.fx_px), 4 * result.sigma[0][0]);
}

TEST(CalibrateStereo, LeavesOutWhatIsAboveTheGivenLimit) {
  const StereoRig rig = true_rig();
  auto sightings = exact_sightings(rig, board_poses(rig, kBoard, 12, 5), kBoard, 0.1, 1);
  testing::Random random(2);
  for (Vector2& uv : sightings.seen[3].corners[0]) uv += 0.15 * normal3(random).head<2>();
  const auto by_default = calibrate_stereo("", sightings, kBoard, {});
  EXPECT_TRUE(by_default.views[3].used);
  const auto strict = calibrate_stereo("", sightings, kBoard, {0.17});
  EXPECT_FALSE(strict.views[3].used);
}

TEST(CalibrateStereo, PutsTheHandMidway) {
  const StereoRig truth = true_rig();
  StereoRig rig = truth;
  const Transform T_CR_CL = truth.right.T_H_C.inverse() * truth.left.T_H_C;
  calibrate::put_hand_midway(T_CR_CL, rig);
  const double half = 0.5 * T_CR_CL.t_mm.norm();
  EXPECT_NEAR((rig.left.T_H_C.t_mm - Vector3(-half, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((rig.right.T_H_C.t_mm - Vector3(half, 0, 0)).norm(), 0, 1e-9);
  const Transform between = rig.right.T_H_C.inverse() * rig.left.T_H_C;
  EXPECT_NEAR((between.R - T_CR_CL.R).norm(), 0, 1e-9);
  EXPECT_NEAR((between.t_mm - T_CR_CL.t_mm).norm(), 0, 1e-9);
  // Both look forward, equally up and down.
  const Vector3 forward = rig.left.T_H_C.R.col(2) + rig.right.T_H_C.R.col(2);
  EXPECT_NEAR(forward.y(), 0, 1e-9);
  EXPECT_GT(forward.z(), 1.9);
  EXPECT_NEAR(rig.left.T_H_C.R.determinant(), 1, 1e-9);
}

TEST(CalibrateStereo, WhatIsWrittenIsReadBack) {
  const StereoRig rig = true_rig();
  const TempDirectory directory;
  calibrate::write_rig(directory / "rig.toml", rig, {"a note"});
  const StereoRig back = tools::read_rig(directory / "rig.toml");
  EXPECT_EQ(back.left.width_px, 640);
  EXPECT_NEAR(back.left.fx_px, rig.left.fx_px, 1e-6);
  EXPECT_NEAR(back.right.cy_px, rig.right.cy_px, 1e-6);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(back.right.distortion[i], rig.right.distortion[i], 1e-9);
  EXPECT_NEAR((back.right.T_H_C.t_mm - rig.right.T_H_C.t_mm).norm(), 0, 1e-5);
  EXPECT_NEAR((back.right.T_H_C.R - rig.right.T_H_C.R).norm(), 0, 1e-10);
}

TEST(CalibrateViews, AreJudged) {
  const StereoRig rig = true_rig();
  std::vector<Transform> poses = board_poses(rig, kBoard, 14, 1);
  const auto judge = [&] {
    const auto sightings = exact_sightings(rig, poses, kBoard, 0, 1);
    std::vector<calibrate::ViewOfBoard> views;
    for (std::size_t i = 0; i < poses.size(); ++i)
      views.push_back(
          {static_cast<int>(i), rig.left.T_H_C.inverse() * poses[i], &sightings.seen[i].corners[0]});
    std::string all;
    for (const std::string& warning : calibrate::judge_views(views, 640)) all += warning + "\n";
    return all;
  };
  EXPECT_EQ(judge(), "");
  const std::vector<Transform> good = poses;
  poses[5] = poses[4];
  EXPECT_NE(judge().find("4 and 5"), std::string::npos) << judge();
  poses = good;
  poses.resize(6);
  EXPECT_NE(judge().find("only 6 views"), std::string::npos) << judge();
  poses = good;
  for (Transform& pose : poses) pose.R = rig.left.T_H_C.R;
  EXPECT_NE(judge().find("hardly tilted"), std::string::npos) << judge();
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i].R = rig.left.T_H_C.R * turn_deg(i % 2 == 0 ? 25 : -25, {0, 1, 0});
  EXPECT_NE(judge().find("one axis only"), std::string::npos) << judge();
}

TEST(CalibrateViews, CoverageIsTheShareOfCells) {
  const Corners left_half{{0, 0}, {70, 100}, {130, 200}};
  EXPECT_DOUBLE_EQ(calibrate::image_coverage({&left_half}, 640, 480), 2.0 / 48 + 1.0 / 48);
  EXPECT_DOUBLE_EQ(calibrate::image_coverage({&left_half, &left_half}, 640, 480), 3.0 / 48);
}

}  // namespace
}  // namespace vergence::test
