// The photo a photo-model is made of, and the frame the target is posed in.
#include <algorithm>
#include <cmath>

#include "tools/render/random.hpp"
#include "tools/render/scene.hpp"

namespace vergence::render {
namespace {

constexpr float kHalf = 0.5F;

Visibility look(const SceneTarget& target, const PhotoOptionsOfScene& photo, const Transform& T_C_M,
                Sampling sampling) {
  LinearImage image(photo.camera.width_px, photo.camera.height_px);
  Visibility visibility;
  const Placed placed{&target.mesh, T_C_M, true};
  draw(photo.camera, Transform{}, {&placed, 1}, photo.light, sampling, image, &visibility);
  return visibility;
}

// The smallest rectangle around the pixels that are at least half target.
Rectangle bounds(const Visibility& visibility, int width) {
  int left = 1 << 20;
  int right = -1;
  int top = 1 << 20;
  int bottom = -1;
  for (std::size_t i = 0; i < visibility.coverage.size(); ++i) {
    if (visibility.coverage[i] < kHalf) continue;
    const int x = static_cast<int>(i) % width;
    const int y = static_cast<int>(i) / width;
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  return {left, top, right - left + 1, bottom - top + 1};
}

double mean_depth(const Visibility& visibility) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < visibility.coverage.size(); ++i) {
    if (visibility.coverage[i] < kHalf) continue;
    sum += visibility.depth_mm[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

Vector3 centre_of(const Rectangle& roi, const PhotoOptionsOfScene& photo) {
  const double u = roi.x + (roi.width - 1) / 2.0;
  const double v = roi.y + (roi.height - 1) / 2.0;
  return {(u - photo.camera.cx_px) * photo.distance_mm / photo.camera.fx_px,
          (v - photo.camera.cy_px) * photo.distance_mm / photo.camera.fy_px, photo.distance_mm};
}

}  // namespace

void settle_model_frame(SceneTarget& target, const PhotoOptionsOfScene& photo) {
  const Transform ahead{Matrix3::Identity(), {0, 0, photo.distance_mm}};
  constexpr int kRounds = 4;  // the depth settles within a hundredth of a millimetre
  for (int i = 0; i < kRounds; ++i) {
    const Visibility visibility = look(target, photo, ahead, Sampling::k16);
    target.roi = bounds(visibility, photo.camera.width_px);
    if (target.roi.width < 2) return;  // not in sight
    const Vector3 middle = centre_of(target.roi, photo);
    const double deeper = i + 1 < kRounds ? photo.distance_mm - mean_depth(visibility) : 0;
    target.mesh.move({-middle[0], -middle[1], deeper});
  }
}

ModelPhoto take_model_photo(const Scene& scene) {
  const PhotoOptionsOfScene& photo = scene.photo;
  const Backdrop backdrop(scene.photo_backdrop_options);
  const std::vector<Vector2> rays = pixel_rays(photo.camera);
  const Rgb lit = shade(photo.light, {1, 1, 1}, 1, 0, {0, 0, -1}, {0, 0, -1});
  LinearImage bare(photo.camera.width_px, photo.camera.height_px);
  for (std::size_t first = 0; first < rays.size(); first += Rays::kMost) {
    const std::size_t count = std::min(Rays::kMost, rays.size() - first);
    const Rays directions = turned(Matrix3::Identity(), std::span(rays).subspan(first, count));
    backdrop.along(Vector3::Zero(), directions, std::span(bare.data).subspan(first, count));
  }
  for (Rgb& pixel : bare.data) pixel = pixel * lit;
  LinearImage with = bare;
  // The model frame's origin, where the rectangle's middle shows it.
  const Transform T_C_M{Matrix3::Identity(), centre_of(scene.target.roi, photo)};
  const Placed placed{&scene.target.mesh, T_C_M, true};
  Visibility visibility;
  draw(photo.camera, Transform{}, {&placed, 1}, photo.light, Sampling::k16, with, &visibility);
  ModelPhoto result;
  develop(with, scene.sensor, photo.light, hash(scene.seed, 1001), result.photo);
  develop(bare, scene.sensor, photo.light, hash(scene.seed, 1002), result.background);
  result.mask = {photo.camera.width_px, photo.camera.height_px, {}};
  for (const float coverage : visibility.coverage) result.mask.data.push_back(coverage >= kHalf ? 255 : 0);
  return result;
}

}  // namespace vergence::render
