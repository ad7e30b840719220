#include "tools/bench/bench_scene.hpp"

#include <cmath>

namespace vergence::tools {
namespace {

// Colourful texture with detail at several scales, of coordinates in mm.
std::array<std::uint8_t, 3> texture(double x, double y) {
  const auto wave = [&](double fx, double fy, double phase) { return std::sin(fx * x + fy * y + phase); };
  const double a = wave(0.06, 0.02, 0.3) + 0.6 * wave(-0.11, 0.23, 1.0) + 0.3 * wave(0.5, 0.4, 0);
  const double b = wave(0.03, -0.07, 2.0) + 0.6 * wave(0.19, 0.13, 0.5) + 0.3 * wave(-0.4, 0.6, 1);
  const auto byte = [](double v) {
    return static_cast<std::uint8_t>(std::fmax(0, std::fmin(255, 128 + 60 * v)));
  };
  return {byte(a), byte(b), byte(-0.5 * (a + b))};
}

void fill(RgbImage& image, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = r;
      p[1] = g;
      p[2] = b;
    }
  }
}

void fill_noise(RgbImage& image, std::uint64_t seed) {
  CounterRandom random(seed, 0);
  for (auto& byte : image.data) byte = static_cast<std::uint8_t>(random.next() >> 56);
}

void paint_marker(const CameraModel& camera, const Transform& T_H_M, const std::vector<Ball>& balls,
                  RgbImage& image) {
  constexpr std::uint8_t kColours[3][3] = {{200, 30, 30}, {30, 180, 40}, {40, 50, 200}};
  const Transform T_C_M = target_in_camera(camera, T_H_M);
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const Vector3 centre = T_C_M * balls[b].centre_mm;
    Vector2 uv;
    if (!project(camera, centre, uv)) continue;
    const double radius = camera.fx_px * balls[b].radius_mm / centre[2];
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        if (std::hypot(x - uv[0], y - uv[1]) < radius)
          std::copy(kColours[b % 3], kColours[b % 3] + 3, image.at(x, y));
      }
    }
  }
}

// A card of the photo's size, its texture the photo's, posed head-on: a pixel sees the card's point by
// similar triangles.
void paint_card(const CameraModel& camera, const Vector3& centre_H_mm, double half_width_mm,
                double half_height_mm, RgbImage& image) {
  const Vector3 c = camera.T_H_C.inverse() * centre_H_mm;
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const double X = (x - camera.cx_px) / camera.fx_px * c[2] - c[0];
      const double Y = (y - camera.cy_px) / camera.fy_px * c[2] - c[1];
      if (std::abs(X) > half_width_mm || std::abs(Y) > half_height_mm) continue;
      const auto colour = texture(X, Y);
      std::copy(colour.begin(), colour.end(), image.at(x, y));
    }
  }
}

}  // namespace

const char* to_string(BenchContent content) {
  switch (content) {
    case BenchContent::kPresent: return "present";
    case BenchContent::kAbsent: return "absent";
    case BenchContent::kNoise: return "noise";
    case BenchContent::kBlack: return "black";
    case BenchContent::kSaturated: return "saturated";
  }
  return "unknown";
}

BenchScene make_bench_scene(TargetKind kind, BenchContent content) {
  BenchScene scene;
  Dataset& dataset = scene.dataset;
  dataset.rig.left.T_H_C.t_mm = {-60, 0, 0};
  dataset.rig.right.T_H_C.t_mm = {60, 0, 0};
  scene.truth = {{20, -15, 520}, {0, 0, 0}};
  dataset.target.kind = kind;
  constexpr double kDistance_mm = 400;
  constexpr int kRoi_px = 160;
  if (kind == TargetKind::kMarker) {
    dataset.target.balls = {
        {{-50, 20, 0}, 20, 0, 20}, {{50, 20, 15}, 20, 120, 20}, {{0, -40, -15}, 20, 240, 20}};
  } else {
    Target& target = dataset.target;
    target.photo = RgbImage(640, 480);
    target.distance_mm = kDistance_mm;
    target.roi = {240, 160, kRoi_px, kRoi_px};
    target.background_hue_deg = 210;
    fill(target.photo, 90, 110, 130);
    CameraModel straight = target.camera;
    // The rectangle's centre lies half a pixel beside its first pixel's multiple.
    const double uc = target.roi.x + 0.5 * (kRoi_px - 1);
    const double vc = target.roi.y + 0.5 * (kRoi_px - 1);
    const Vector3 centre{(uc - straight.cx_px) * kDistance_mm / straight.fx_px,
                         (vc - straight.cy_px) * kDistance_mm / straight.fy_px, kDistance_mm};
    const double half_mm = 0.5 * kRoi_px * kDistance_mm / straight.fx_px;
    paint_card(straight, centre, half_mm, half_mm, target.photo);
  }
  scene.left = RgbImage(640, 480);
  scene.right = RgbImage(640, 480);
  for (RgbImage* image : {&scene.left, &scene.right}) {
    const CameraModel& camera = image == &scene.left ? dataset.rig.left : dataset.rig.right;
    switch (content) {
      case BenchContent::kPresent:
      case BenchContent::kAbsent: fill(*image, 90, 110, 130); break;
      case BenchContent::kNoise: fill_noise(*image, image == &scene.left ? 1 : 2); break;
      case BenchContent::kBlack: fill(*image, 0, 0, 0); break;
      case BenchContent::kSaturated: fill(*image, 255, 255, 255); break;
    }
    if (content != BenchContent::kPresent) continue;
    if (kind == TargetKind::kMarker) {
      paint_marker(camera, to_transform(scene.truth), dataset.target.balls, *image);
    } else {
      const double half_mm = 0.5 * kRoi_px * kDistance_mm / dataset.target.camera.fx_px;
      paint_card(camera, scene.truth.position_mm, half_mm, half_mm, *image);
    }
  }
  return scene;
}

}  // namespace vergence::tools
