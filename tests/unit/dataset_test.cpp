// Reading data sets: what is in the files arrives, and what is wrong is named. (Every bad input again,
// through the command line: cli/bad_input_test.cpp.)
#include "tools/io/dataset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/small_dataset.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

using test::TempDirectory;

template <class Read>
std::string complaint(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(Dataset, GivesWhatThePhotoDatasetSays) {
  const TempDirectory directory;
  test::write_small_photo_dataset(directory.path());
  const Dataset dataset = read_dataset(directory.path());
  EXPECT_EQ(dataset.rig.left.width_px, 320);
  EXPECT_EQ(dataset.rig.right.height_px, 240);
  EXPECT_EQ(dataset.rig.left.fx_px, 400);
  EXPECT_EQ(dataset.rig.left.cx_px, 159.5);
  EXPECT_EQ(dataset.rig.left.T_H_C.t_mm[0], -60);
  EXPECT_EQ(dataset.rig.right.T_H_C.t_mm[0], 60);
  EXPECT_EQ(dataset.target.kind, TargetKind::kPhoto);
  EXPECT_EQ(dataset.target.roi.width, 100);
  EXPECT_EQ(dataset.target.distance_mm, 400);
  // The background is painted (60, 100, 150): hue 240 - 60 * 40 / 90 degrees.
  EXPECT_NEAR(dataset.target.background_hue_deg, 213.3, 0.8);
  EXPECT_EQ(dataset.box.centre[2], 500);
  EXPECT_EQ(dataset.box.half_range[5], 0.2);
  ASSERT_EQ(dataset.frames.size(), static_cast<std::size_t>(test::kSmallFrames));
  EXPECT_EQ(dataset.frames[2].number, 2);
  EXPECT_EQ(dataset.frames[2].right.filename(), "000002.png");
  EXPECT_EQ(dataset.truth.at(1).T_H_M.position_mm, test::small_pose(1).position_mm);
  EXPECT_DOUBLE_EQ(dataset.time_of(2), 2 / 30.0);
  const auto [left, right] = read_frame(dataset, dataset.frames[0]);
  EXPECT_EQ(left.width_px, 320);
  EXPECT_NE(left.data, right.data);
}

TEST(Dataset, GivesTheBallsOfAMarker) {
  const TempDirectory directory;
  test::write_small_marker_dataset(directory.path());
  const Target target = read_target(directory / "model");
  EXPECT_EQ(target.kind, TargetKind::kMarker);
  ASSERT_EQ(target.balls.size(), 3U);
  EXPECT_EQ(target.balls[1].centre_mm, Vector3(70, 0, 0));
  EXPECT_EQ(target.balls[1].hue_deg, 120);
  EXPECT_EQ(target.balls[1].tolerance_deg, 20);
}

TEST(Dataset, TakesTimesFromTruthAndIgnoresUnknownKeys) {
  const TempDirectory directory;
  test::write_small_marker_dataset(directory.path());
  test::write_file(directory / "truth.csv", "frame,t_s,x_mm,y_mm,z_mm,e1,e2,e3\n1, 7.5, 1,2,3, 0,0,0.5\r\n");
  test::replace_in_file(directory / "rig.toml", "[image]", "note = \"mine\"\n[image]\nexposure_ms = 4");
  const Dataset dataset = read_dataset(directory.path());
  EXPECT_EQ(dataset.time_of(1), 7.5);
  EXPECT_EQ(dataset.truth.at(1).T_H_M.e[2], 0.5);
  EXPECT_DOUBLE_EQ(dataset.time_of(0), 0);
}

TEST(Dataset, TurnsTheEyesAsTheMotionSays) {
  const TempDirectory directory;
  test::write_small_marker_dataset(directory.path());
  test::write_file(directory / "motion.csv",
                   "frame,x_mm,y_mm,z_mm,e1,e2,e3,tilt_rad,pan_right_rad,pan_left_rad\n"
                   "0,1,2,3,0,0,0,0,0,0\n1,1,2,3,0,0,0,0,0.3,0.2\n2,1,2,3,0,0,0,0.1,0,0\n");
  const Dataset dataset = read_dataset(directory.path());
  EXPECT_EQ(dataset.motion_of(0).T_W_H.t_mm, Vector3(1, 2, 3));
  EXPECT_EQ(dataset.motion_of(0).T_H_CL.R, Matrix3::Identity());
  const Vector3 forward = Vector3::UnitZ();
  EXPECT_NEAR((dataset.motion_of(1).T_H_CL.R * forward).x(), std::sin(0.2), 1e-12);   // to the right
  EXPECT_NEAR((dataset.motion_of(1).T_H_CR.R * forward).x(), -std::sin(0.3), 1e-12);  // to the left
  EXPECT_NEAR((dataset.motion_of(2).T_H_CL.R * forward).y(), std::sin(0.1), 1e-12);   // down
  EXPECT_EQ(dataset.motion_of(1).T_H_CR.t_mm, Vector3(60, 0, 0));
}

TEST(Dataset, MakesRotationsExact) {
  const TempDirectory directory;
  test::write_small_marker_dataset(directory.path());
  // A turn of 0.3 rad about y, rounded to four digits.
  test::replace_in_file(directory / "rig.toml", "[1,0,0,-60, 0,1,0,0, 0,0,1,0,",
                        "[0.9553,0,0.2955,-60, 0,1,0,0, -0.2955,0,0.9553,0,");
  const Matrix3 R = read_rig(directory / "rig.toml").left.T_H_C.R;
  EXPECT_LT((R * R.transpose() - Matrix3::Identity()).norm(), 1e-14);
  EXPECT_NEAR(R(0, 2), std::sin(0.3), 1e-4);
}

TEST(Dataset, MeanHueIsCircular) {
  RgbImage image(20, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 20; ++x) {
      // 20 degrees on either side of red.
      image.at(x, y)[0] = 180;
      image.at(x, y)[x < 10 ? 1 : 2] = 60;
    }
  }
  const auto hue = mean_hue_deg(image);
  ASSERT_TRUE(hue);
  EXPECT_LT(std::min(*hue, 360 - *hue), 0.8);
  image.data.assign(image.data.size(), 100);
  EXPECT_FALSE(mean_hue_deg(image)) << "grey has no hue";
}

TEST(Dataset, SaysFileFieldAndRemedy) {
  const TempDirectory directory;
  test::write_small_photo_dataset(directory.path());
  test::replace_in_file(directory / "rig.toml", "fx = 400.0", "fx = -4");
  const std::string what = complaint([&] { static_cast<void>(read_dataset(directory.path())); });
  EXPECT_NE(what.find((directory / "rig.toml").string()), std::string::npos) << what;
  EXPECT_NE(what.find("left.fx"), std::string::npos) << what;
  EXPECT_NE(what.find("-4"), std::string::npos) << what;
  EXPECT_EQ(complaint([&] { static_cast<void>(read_target(directory / "model")); }), "no complaint");
}

TEST(Dataset, FramesNeedNotBeConsecutive) {
  const TempDirectory directory;
  test::write_small_marker_dataset(directory.path());
  for (const char* side : {"left", "right"}) {
    std::filesystem::rename(directory.path() / side / "000001.png", directory.path() / side / "000417.png");
  }
  const Dataset dataset = read_dataset(directory.path());
  ASSERT_EQ(dataset.frames.size(), 3U);
  EXPECT_EQ(dataset.frames.back().number, 417);
}

}  // namespace
}  // namespace vergence::tools
