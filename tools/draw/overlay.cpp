#include "tools/draw/overlay.hpp"

#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algo/hue.hpp"

namespace vergence::tools {
namespace {

const cv::Scalar kWhite(255, 255, 255);
const cv::Scalar kRim(150, 150, 150);
const cv::Scalar kEstimate(255, 0, 255);
constexpr int kPointsShown = 160;  // of S_in; its first ones are spread over the target

// Depths of the relief, and their colours: near is yellow, far is blue.
struct ReliefScale {
  double near_mm = 0;
  double far_mm = 0;

  [[nodiscard]] bool is_flat() const { return far_mm - near_mm < 1e-3; }
  [[nodiscard]] cv::Scalar colour(double z_mm) const {
    const double t = std::clamp((z_mm - near_mm) / (far_mm - near_mm), 0.0, 1.0);
    // Brightness falls all the way, so that it reads in grey too.
    return {255 * (1 - t) * (1 - 0.2 * t), 235 * (1 - t) + 40 * t, 40 + 190 * t};
  }
};

ReliefScale relief_of(const PhotoModel& model) {
  const auto [near_z, far_z] = std::minmax_element(model.z_mm.begin(), model.z_mm.begin() + model.inner);
  return {*near_z, *far_z};
}

cv::Mat wrap(RgbImage& image) {
  return {image.height_px, image.width_px, CV_8UC3, image.data.data()};
}

cv::Scalar colour_of_hue(double degrees) {
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + degrees / 60, 6.0);
    return 255 * (1 - std::max(0.0, std::min({k, 4 - k, 1.0})));
  };
  return {channel(5), channel(3), channel(1)};
}

// Image coordinates with sub-pixel shift for OpenCV's drawing functions.
constexpr int kShift = 4;
cv::Point fixed_point(const Vector2& uv) {
  const double limit = 1e5;
  return {static_cast<int>(std::lround(std::clamp(uv[0], -limit, limit) * (1 << kShift))),
          static_cast<int>(std::lround(std::clamp(uv[1], -limit, limit) * (1 << kShift)))};
}

class EyePainter {
 public:
  EyePainter(cv::Mat image, const CameraModel& camera, const Transform& T_H_M)
      : image_(std::move(image)), camera_(camera), T_C_M_(target_in_camera(camera, T_H_M)) {}

  void line(const Vector3& a_mm, const Vector3& b_mm, const cv::Scalar& colour, int thickness) {
    Vector2 a;
    Vector2 b;
    if (!project(camera_, T_C_M_ * a_mm, a) || !project(camera_, T_C_M_ * b_mm, b)) return;
    cv::line(image_, fixed_point(a), fixed_point(b), colour, thickness, cv::LINE_AA, kShift);
  }

  void dot(const Vector3& p_mm, const cv::Scalar& colour) {
    Vector2 uv;
    if (!project(camera_, T_C_M_ * p_mm, uv)) return;
    cv::circle(image_, fixed_point(uv), 1 << kShift, colour, cv::FILLED, cv::LINE_AA, kShift);
  }

  void ball(const Ball& ball, const cv::Scalar& colour, int thickness) {
    const Vector3 centre = T_C_M_ * ball.centre_mm;
    Vector2 uv;
    if (!project(camera_, centre, uv)) return;
    const double radius = camera_.fx_px * ball.radius_mm / centre[2];
    cv::circle(image_, fixed_point(uv), static_cast<int>(std::min(radius, 1e4) * (1 << kShift)), colour,
               thickness, cv::LINE_AA, kShift);
  }

  // Around where the points fall in the picture.
  void hull(const PhotoModel& model, const cv::Scalar& colour) {
    std::vector<cv::Point2f> points;
    for (unsigned k = 0; k < static_cast<unsigned>(model.inner); ++k) {
      Vector2 uv;
      if (!project(camera_, T_C_M_ * Vector3{model.x_mm[k], model.y_mm[k], model.z_mm[k]}, uv)) return;
      points.emplace_back(static_cast<float>(uv[0]), static_cast<float>(uv[1]));
    }
    if (points.size() < 3) return;
    std::vector<cv::Point2f> around;
    cv::convexHull(points, around);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const cv::Point2f& a = around[i];
      const cv::Point2f& b = around[(i + 1) % around.size()];
      cv::line(image_, fixed_point({a.x, a.y}), fixed_point({b.x, b.y}), colour, 1, cv::LINE_AA, kShift);
    }
  }

  void axes(double length_mm) {
    line({0, 0, 0}, {length_mm, 0, 0}, {255, 40, 40}, 2);
    line({0, 0, 0}, {0, length_mm, 0}, {40, 255, 40}, 2);
    line({0, 0, 0}, {0, 0, length_mm}, {80, 80, 255}, 2);
  }

 private:
  cv::Mat image_;
  CameraModel camera_;
  Transform T_C_M_;
};

// Corners of the photo's rectangle in the target frame.
std::vector<Vector3> rectangle_corners(const Target& target) {
  const double x = 0.5 * target.roi.width * target.distance_mm / target.camera.fx_px;
  const double y = 0.5 * target.roi.height * target.distance_mm / target.camera.fy_px;
  return {{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}};
}

void outline(EyePainter& painter, const Target& target, const cv::Scalar& colour, int thickness) {
  if (target.kind == TargetKind::kMarker) {
    for (const Ball& ball : target.balls) painter.ball(ball, colour, thickness);
    return;
  }
  const auto corners = rectangle_corners(target);
  for (std::size_t i = 0; i < 4; ++i) painter.line(corners[i], corners[(i + 1) % 4], colour, thickness);
}

double axis_length_mm(const Target& target) {
  if (target.kind == TargetKind::kMarker) {
    double length = 0;
    for (const Ball& ball : target.balls) length = std::max(length, ball.centre_mm.norm());
    return std::max(length, 20.0);
  }
  return 0.5 * std::min(target.roi.width, target.roi.height) * target.distance_mm / target.camera.fx_px;
}

void label(cv::Mat image, const std::string& text) {
  const cv::Point at(8, image.rows - 10);
  int below = 0;
  const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, &below).width;
  const double scale = 0.5 * std::min(1.0, (image.cols - 16.0) / width);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, kWhite, 1, cv::LINE_AA);
}

void relief_legend(cv::Mat image, const ReliefScale& scale) {
  constexpr int kWidth = 160;
  constexpr int kHeight = 10;
  constexpr int kLeft = 8;
  constexpr int kTop = 24;
  for (int x = 0; x < kWidth; ++x) {
    const double z_mm = scale.near_mm + (scale.far_mm - scale.near_mm) * x / (kWidth - 1);
    cv::line(image, {kLeft + x, kTop}, {kLeft + x, kTop + kHeight}, scale.colour(z_mm));
  }
  char text[80];
  std::snprintf(text, sizeof text, "relief z %+.1f to %+.1f mm", scale.near_mm, scale.far_mm);
  for (const auto& [colour, thickness] : {std::pair{cv::Scalar(0, 0, 0), 3}, std::pair{kWhite, 1}}) {
    cv::putText(image, text, {kLeft, kTop - 7}, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, thickness,
                cv::LINE_AA);
  }
}

}  // namespace

RgbImage draw_overlay(const Overlay& overlay, const RgbImage& left, const RgbImage& right) {
  RgbImage sheet(left.width_px + right.width_px, std::max(left.height_px, right.height_px));
  cv::Mat canvas = wrap(sheet);
  std::array<RgbImage, 2> eyes = {left, right};
  int x = 0;
  for (std::size_t eye = 0; eye < 2; ++eye) {
    cv::Mat part = canvas(cv::Rect(x, 0, eyes[eye].width_px, eyes[eye].height_px));
    wrap(eyes[eye]).copyTo(part);
    x += eyes[eye].width_px;
    EyePainter painter(part, overlay.cameras[eye], to_transform(overlay.T_H_M));
    if (overlay.photo_model != nullptr) {
      const PhotoModel& model = *overlay.photo_model;
      const ReliefScale relief = relief_of(model);
      if (!relief.is_flat() && eye == 0) relief_legend(part, relief);
      for (int i = 0; i < std::min(model.inner, kPointsShown); ++i) {
        const auto k = static_cast<unsigned>(i);
        const cv::Scalar colour = !relief.is_flat()      ? relief.colour(model.z_mm[k])
                                  : is_hue(model.hue[k]) ? colour_of_hue(hue_degrees(model.hue[k]))
                                                         : cv::Scalar(128, 128, 128);
        painter.dot({model.x_mm[k], model.y_mm[k], model.z_mm[k]}, colour);
      }
      painter.hull(model, kEstimate);
    } else {
      for (const Ball& ball : overlay.target.balls) painter.dot(ball.centre_mm, kWhite);
    }
    painter.axes(axis_length_mm(overlay.target));
    outline(painter, overlay.target, kEstimate, 2);
    // On top and thin, so that both are seen where they agree.
    if (overlay.true_T_H_M) {
      EyePainter true_painter(part, overlay.cameras[eye], to_transform(*overlay.true_T_H_M));
      outline(true_painter, overlay.target, kWhite, 1);
    }
  }
  label(canvas, overlay.text);
  return sheet;
}

RgbImage draw_overlay(const Dataset& dataset, const Estimator& estimator, const FrameResult& result,
                      const RgbImage& left, const RgbImage& right) {
  const FrameMotion motion = dataset.motion_of(result.frame);
  const bool is_photo = dataset.target.kind == TargetKind::kPhoto;
  Overlay overlay{dataset.target,
                  is_photo ? &estimator.photo_model() : nullptr,
                  {dataset.rig.left, dataset.rig.right},
                  result.estimate.pose,
                  std::nullopt,
                  overlay_text(static_cast<std::uint64_t>(result.frame), result.estimate)};
  overlay.cameras[0].T_H_C = motion.T_H_CL;
  overlay.cameras[1].T_H_C = motion.T_H_CR;
  if (const auto truth = dataset.truth.find(result.frame); truth != dataset.truth.end()) {
    overlay.true_T_H_M = truth->second.T_H_M;
  }
  return draw_overlay(overlay, left, right);
}

std::string overlay_text(std::uint64_t frame, const Estimate& estimate) {
  const Pose& pose = estimate.pose;
  char text[200];
  std::snprintf(
      text, sizeof text, "frame %llu  %s  confidence %.2f  x %.1f y %.1f z %.1f mm  e %.3f %.3f %.3f",
      static_cast<unsigned long long>(frame), to_string(estimate.state), estimate.confidence,
      pose.position_mm[0], pose.position_mm[1], pose.position_mm[2], pose.e[0], pose.e[1], pose.e[2]);
  return text;
}

RgbImage draw_photo_model(const RgbImage& photo, const PhotoSource& source, const PhotoModel& model) {
  RgbImage picture = photo;
  cv::Mat canvas = wrap(picture);
  canvas *= 0.6;
  const double uc = source.roi.x + 0.5 * (source.roi.width - 1);
  const double vc = source.roi.y + 0.5 * (source.roi.height - 1);
  for (unsigned i = 0; i < static_cast<unsigned>(model.points()); ++i) {
    const Vector2 uv{uc + model.x_mm[i] * source.camera.fx_px / source.distance_mm,
                     vc + model.y_mm[i] * source.camera.fy_px / source.distance_mm};
    const bool inner = static_cast<int>(i) < model.inner;
    const cv::Scalar colour = !inner                 ? kWhite
                              : model.weight[i] == 0 ? kRim
                              : is_hue(model.hue[i]) ? colour_of_hue(hue_degrees(model.hue[i]))
                                                     : cv::Scalar(0, 0, 0);
    cv::circle(canvas, fixed_point(uv), (3 << kShift) / 2, colour, cv::FILLED, cv::LINE_AA, kShift);
  }
  cv::rectangle(canvas, cv::Rect(source.roi.x, source.roi.y, source.roi.width, source.roi.height),
                {255, 0, 255}, 1);
  label(canvas,
        std::to_string(model.inner) + " points S_in, " + std::to_string(model.outer) + " points S_out");
  return picture;
}

}  // namespace vergence::tools
