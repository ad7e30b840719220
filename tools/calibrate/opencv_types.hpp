// Our values in OpenCV's types, and back.
#pragma once

#include <opencv2/calib3d.hpp>
#include <vector>

#include "algo/camera_model.hpp"
#include "tools/calibrate/board.hpp"

namespace vergence::calibrate {

[[nodiscard]] inline std::vector<cv::Point3f> board_points(const Board& board) {
  std::vector<cv::Point3f> points;
  for (std::size_t i = 0; i < board.corners(); ++i) {
    const Vector3 p = board.corner_mm(i);
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
  }
  return points;
}

[[nodiscard]] inline std::vector<cv::Point2f> image_points(const Corners& corners) {
  std::vector<cv::Point2f> points;
  for (const Vector2& uv : corners)
    points.emplace_back(static_cast<float>(uv.x()), static_cast<float>(uv.y()));
  return points;
}

[[nodiscard]] inline cv::Matx33d camera_matrix(const CameraModel& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

[[nodiscard]] inline std::vector<double> distortion_of(const CameraModel& camera) {
  return {camera.distortion.begin(), camera.distortion.end()};
}

[[nodiscard]] inline CameraModel camera_of(const cv::Mat& matrix, const cv::Mat& distortion,
                                           const cv::Size& size) {
  CameraModel camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  camera.fx_px = matrix.at<double>(0, 0);
  camera.fy_px = matrix.at<double>(1, 1);
  camera.cx_px = matrix.at<double>(0, 2);
  camera.cy_px = matrix.at<double>(1, 2);
  for (int i = 0; i < 5; ++i) camera.distortion[static_cast<std::size_t>(i)] = distortion.at<double>(i);
  return camera;
}

// From a rotation, as a matrix or a rotation vector, and a translation.
[[nodiscard]] inline Transform transform_of(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat matrix = rotation;
  if (rotation.total() == 3) cv::Rodrigues(rotation, matrix);
  Transform T;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) T.R(row, column) = matrix.at<double>(row, column);
    T.t_mm[row] = translation.at<double>(row);
  }
  return T;
}

[[nodiscard]] inline cv::Mat rotation_of(const Transform& T) {
  cv::Mat matrix(3, 3, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix.at<double>(row, column) = T.R(row, column);
  }
  return matrix;
}

[[nodiscard]] inline cv::Mat translation_of(const Transform& T) {
  return (cv::Mat_<double>(3, 1) << T.t_mm[0], T.t_mm[1], T.t_mm[2]);
}

}  // namespace vergence::calibrate
