#include "tools/calibrate/draw_views.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace vergence::calibrate {
namespace {

const cv::Scalar kGreen(0, 220, 0);
const cv::Scalar kRed(255, 0, 0);
const cv::Scalar kMagenta(255, 0, 255);
constexpr int kFractionBits = 4;  // of the coordinates that are drawn to

cv::Point fine(const Vector2& uv) {
  constexpr double kScale = 1 << kFractionBits;
  return {static_cast<int>(std::lround(uv.x() * kScale)), static_cast<int>(std::lround(uv.y() * kScale))};
}

void draw_corners(cv::Mat& picture, const CameraModel& camera, const Transform& T_C_B, const Board& board,
                  const Corners& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    cv::circle(picture, fine(corners[i]), 5 << kFractionBits, i == 0 ? kRed : kGreen, 1, cv::LINE_AA,
               kFractionBits);
    Vector2 uv;
    if (!project(camera, T_C_B * board.corner_mm(i), uv)) continue;
    const Vector2 end = corners[i] + kErrorMagnified * (uv - corners[i]);
    // A view left out may err by hundreds of pixels.
    if ((end - corners[i]).norm() > 2.0 * camera.width_px) continue;
    cv::line(picture, fine(corners[i]), fine(end), kMagenta, 1, cv::LINE_AA, kFractionBits);
  }
}

}  // namespace

tools::RgbImage draw_view(const std::array<tools::GreyImage, 2>& images, const Sighting& sighting,
                          const StereoView& view, const StereoCalibration& calibration, const Board& board) {
  const int width = images[0].width_px;
  const int height = images[0].height_px;
  tools::RgbImage result(2 * width, height);
  cv::Mat sheet(height, 2 * width, CV_8UC3, result.data.data());
  for (std::size_t side = 0; side < 2; ++side) {
    const cv::Mat grey(height, width, CV_8U, const_cast<std::uint8_t*>(images[side].data.data()));
    cv::Mat picture = sheet(cv::Rect(side == 0 ? 0 : width, 0, width, height));
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2RGB);
    const CameraModel& camera = side == 0 ? calibration.rig.left : calibration.rig.right;
    const Transform T_C_B = side == 0 ? view.T_CL_B : calibration.T_CR_CL * view.T_CL_B;
    draw_corners(picture, camera, T_C_B, board, sighting.corners[side]);
    if (!view.used) cv::rectangle(picture, {0, 0, width, height}, kRed, 8);
  }
  return result;
}

}  // namespace vergence::calibrate
