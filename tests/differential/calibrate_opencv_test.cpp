// Stereo calibration on photographs against OpenCV's functions used plainly: corners in windows of 11 pixels,
// each camera by itself, then stereoCalibrate with its defaults. Prints the numbers of docs/calibrate.md.
//
// VERGENCE_CHESSBOARD names a folder of photographs of a board of 9 x 6 inner corners, 25 mm apart (OpenCV's
// samples have thirteen pairs); without it there is nothing to compare.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tools/calibrate/opencv_types.hpp"
#include "tools/calibrate/picture_file.hpp"
#include "tools/calibrate/stereo.hpp"

namespace vergence::calibrate {
namespace {

constexpr Board kBoard{9, 6, 25};

struct Result {
  std::array<CameraModel, 2> cameras;
  Transform T_CR_CL;
  double rms_px = 0;  // of both cameras together
};

// As OpenCV's sample finds them. The order of a board's corners is made ours, so that both can be held
// together.
Corners plain_corners(const tools::GreyImage& image, const Corners& ours) {
  const cv::Mat grey(image.height_px, image.width_px, CV_8U, const_cast<std::uint8_t*>(image.data.data()));
  std::vector<cv::Point2f> points;
  EXPECT_TRUE(cv::findChessboardCorners(grey, {kBoard.columns, kBoard.rows}, points));
  cv::cornerSubPix(grey, points, {11, 11}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01});
  Corners corners;
  for (const cv::Point2f& point : points) corners.emplace_back(point.x, point.y);
  if ((corners.front() - ours.front()).norm() > (corners.back() - ours.front()).norm())
    return {corners.rbegin(), corners.rend()};
  return corners;
}

Result plain_calibration(const std::vector<CornerPair>& views, const cv::Size& size) {
  const std::vector<std::vector<cv::Point3f>> objects(views.size(), board_points(kBoard));
  std::array<std::vector<std::vector<cv::Point2f>>, 2> images;
  for (const CornerPair& view : views) {
    for (std::size_t side = 0; side < 2; ++side) images[side].push_back(image_points(view[side]));
  }
  std::array<cv::Mat, 2> K;
  std::array<cv::Mat, 2> k;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  for (std::size_t side = 0; side < 2; ++side)
    cv::calibrateCamera(objects, images[side], size, K[side], k[side], rotations, translations);
  cv::Mat R;
  cv::Mat t;
  cv::Mat essential;
  cv::Mat fundamental;
  Result result;
  result.rms_px = cv::stereoCalibrate(objects, images[0], images[1], K[0], k[0], K[1], k[1], size, R, t,
                                      essential, fundamental);
  result.T_CR_CL = transform_of(R, t);
  for (std::size_t side = 0; side < 2; ++side) result.cameras[side] = camera_of(K[side], k[side], size);
  return result;
}

Result our_calibration(const Sightings& sightings) {
  const StereoCalibration calibration = calibrate_stereo("", sightings, kBoard, {});
  return {{calibration.rig.left, calibration.rig.right},
          calibration.T_CR_CL,
          std::sqrt(0.5 * (calibration.rms_px[0] * calibration.rms_px[0] +
                           calibration.rms_px[1] * calibration.rms_px[1]))};
}

std::vector<CornerPair> corners_of(const Sightings& sightings) {
  std::vector<CornerPair> views;
  for (const Sighting& sighting : sightings.seen) views.push_back(sighting.corners);
  return views;
}

struct Report {
  double rms_px = 0;
  double epipolar_px = 0;
  double held_out_px = 0;  // RMS of the epipolar errors of each view, with what the others say
  double baseline_mm = 0;
};

template <class CalibrateWithout>
Report judge(const std::vector<CornerPair>& views, const Result& all, CalibrateWithout&& calibrate_without) {
  double squares = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Result rest = calibrate_without(v);
    const double error = epipolar_error(rest.cameras, rest.T_CR_CL, {views[v]}).rms_px;
    squares += error * error;
  }
  return {all.rms_px, epipolar_error(all.cameras, all.T_CR_CL, views).rms_px,
          std::sqrt(squares / static_cast<double>(views.size())), all.T_CR_CL.t_mm.norm()};
}

TEST(CalibrateOpenCv, OnPhotographsIsNoWorse) {
  const char* folder = std::getenv("VERGENCE_CHESSBOARD");
  if (folder == nullptr) GTEST_SKIP() << "VERGENCE_CHESSBOARD names no folder of photographs of a 9x6 board";
  const Sightings sightings = find_board(list_pairs(folder), kBoard);
  const cv::Size size(sightings.width_px, sightings.height_px);
  const std::vector<CornerPair> ours = corners_of(sightings);
  std::vector<CornerPair> plain;
  for (const Sighting& sighting : sightings.seen) {
    plain.push_back({plain_corners(read_picture(sighting.pair.files[0]), sighting.corners[0]),
                     plain_corners(read_picture(sighting.pair.files[1]), sighting.corners[1])});
  }

  const auto without = [](auto views, std::size_t v) {
    views.erase(views.begin() + static_cast<std::ptrdiff_t>(v));
    return views;
  };
  const Report report_ours = judge(ours, our_calibration(sightings), [&](std::size_t v) {
    Sightings rest = sightings;
    rest.seen = without(rest.seen, v);
    return our_calibration(rest);
  });
  const auto judge_plain = [&](const std::vector<CornerPair>& views) {
    return judge(views, plain_calibration(views, size),
                 [&](std::size_t v) { return plain_calibration(without(views, v), size); });
  };
  const Report report_plain = judge_plain(plain);
  const Report report_mixed = judge_plain(ours);
  const auto print = [&](const char* what, double Report::*value) {
    std::printf("%-34s %7.3f %7.3f %7.3f\n", what, report_ours.*value, report_plain.*value,
                report_mixed.*value);
  };
  std::printf("ours; OpenCV, plain; OpenCV with our corners\n");
  print("reprojection RMS, px", &Report::rms_px);
  print("epipolar RMS, px", &Report::epipolar_px);
  print("the same, of a view held out, px", &Report::held_out_px);
  print("baseline, mm", &Report::baseline_mm);
  EXPECT_LT(report_ours.rms_px, report_plain.rms_px);
  EXPECT_LT(report_ours.epipolar_px, report_plain.epipolar_px);
  EXPECT_LT(report_ours.held_out_px, report_plain.held_out_px);
}

}  // namespace
}  // namespace vergence::calibrate
