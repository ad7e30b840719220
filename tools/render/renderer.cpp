// From a scene's state to pictures.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "tools/render/desk.hpp"
#include "tools/render/random.hpp"
#include "tools/render/scene.hpp"
#include "tools/render/wide.hpp"

namespace vergence::render {
namespace {

// `glints`, where there is water, gets those of every pixel.
VERGENCE_WIDE void draw_backdrop(const Backdrop& backdrop, const Water& water, const Light& light,
                                 const Transform& T_W_C, const std::vector<Vector2>& rays, double t_s,
                                 LinearImage& image, std::vector<float>& glints) {
  // The plane faces the viewer and is matt: one shade for all of it.
  const Rgb lit = shade(light, {1, 1, 1}, 1, 0, {0, 0, -1}, {0, 0, -1});
  const bool wet = water.strength > 0;
  if (wet) glints.resize(rays.size());
  for (std::size_t first = 0; first < rays.size(); first += Rays::kMost) {
    const std::size_t count = std::min(Rays::kMost, rays.size() - first);
    const Rays directions = turned(T_W_C.R, std::span(rays).subspan(first, count));
    const std::span<Rgb> pixels = std::span(image.data).subspan(first, count);
    backdrop.along(T_W_C.t_mm, directions, pixels);
    for (Rgb& pixel : pixels) pixel = pixel * lit;
    if (!wet) continue;
    glint(water, T_W_C.t_mm, directions, t_s, std::span(glints).subspan(first, count));
    for (std::size_t i = first; i < first + count; ++i) image.data[i] += {glints[i], glints[i], glints[i]};
  }
}

// Water lies over the target as well where its surface is nearer.
void draw_glints(const Water& water, const Transform& T_W_C, const std::vector<Vector2>& rays,
                 const std::vector<float>& glints, const Visibility& visibility, LinearImage& image) {
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (visibility.coverage[i] <= 0) continue;
    const Vector3 direction = T_W_C.R * Vector3(rays[i][0], rays[i][1], 1);
    if (T_W_C.t_mm[2] + visibility.depth_mm[i] * direction[2] < water.surface_mm) continue;
    const float g = glints[i] * visibility.coverage[i];
    image.data[i] += Rgb{g, g, g};
  }
}

// One instant's light, in `desk.image`.
void expose(const Scene& scene, const SceneState& state, const SceneMoment& moment, Eye eye, Desk& desk) {
  const Light& light = state.light;
  const bool left = eye == Eye::kLeft;
  const CameraModel& camera = left ? scene.rig.left : scene.rig.right;
  const std::vector<Vector2>& rays = left ? scene.left_rays : scene.right_rays;
  const Transform T_H_C =
      left ? left_eye_in_hand(camera.T_H_C, moment.eyes) : right_eye_in_hand(camera.T_H_C, moment.eyes);
  const Transform T_W_C = moment.T_W_H * T_H_C;
  desk.image.resize(camera.width_px, camera.height_px);
  draw_backdrop(*scene.backdrop, scene.water, light, T_W_C, rays, moment.t_s, desk.image, desk.glints);
  desk.placed.clear();
  if (state.target_there) desk.placed.push_back({&scene.target.mesh, moment.T_W_M, true});
  for (std::size_t i = 0; i < scene.occluders.size(); ++i) {
    desk.placed.push_back({&scene.occluders[i].mesh, moment.T_W_occluder[i], false});
  }
  const bool wet = scene.water.strength > 0;
  desk.rasteriser.draw(camera, T_W_C, desk.placed, light, scene.sampling, desk.image,
                       wet ? &desk.visibility : nullptr);
  if (wet) draw_glints(scene.water, T_W_C, rays, desk.glints, desk.visibility, desk.image);
}

}  // namespace

std::vector<Vector2> pixel_rays(const CameraModel& camera) {
  std::vector<Vector2> rays;
  rays.reserve(static_cast<std::size_t>(camera.width_px) * static_cast<std::size_t>(camera.height_px));
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const Vector2 seen((u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px);
      Vector2 ray = seen;
      // Fixed point: what is distorted to where the pixel is.
      for (int i = 0; i < (camera.has_distortion() ? 25 : 0); ++i) {
        const double r2 = ray.squaredNorm();
        const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
        const Vector2 tangential(2 * p1 * ray[0] * ray[1] + p2 * (r2 + 2 * ray[0] * ray[0]),
                                 p1 * (r2 + 2 * ray[1] * ray[1]) + 2 * p2 * ray[0] * ray[1]);
        ray = (seen - tangential) / radial;
      }
      rays.push_back(ray);
    }
  }
  return rays;
}

EyeAngles gaze_at(const StereoRig& rig, const Vector3& p_H_mm) {
  // To a nano-radian, so that the angles of motion.csv are exactly those of the pictures.
  const auto angle = [](double y, double x) { return std::nearbyint(std::atan2(y, x) * 1e9) * 1e-9; };
  const Vector3 left = rig.left.T_H_C.inverse() * p_H_mm;
  const Vector3 right = rig.right.T_H_C.inverse() * p_H_mm;
  const double y = (left[1] + right[1]) / 2;
  const double z = (left[2] + right[2]) / 2;
  const double range = std::sqrt(y * y + z * z);
  return {angle(y, z), angle(-right[0], range), angle(left[0], range)};
}

void render_eye(const Scene& scene, const SceneState& state, Eye eye, std::uint64_t frame_seed,
                tools::RgbImage& out) {
  const DeskLoan desk;
  expose(scene, state, state.moments.front(), eye, *desk);
  if (state.moments.size() > 1) {
    LinearImage& sum = desk->sum;
    sum = desk->image;
    for (std::size_t i = 1; i < state.moments.size(); ++i) {
      expose(scene, state, state.moments[i], eye, *desk);
      for (std::size_t k = 0; k < sum.data.size(); ++k) sum.data[k] += desk->image.data[k];
    }
    for (Rgb& pixel : sum.data) pixel = pixel * (1 / static_cast<float>(state.moments.size()));
    std::swap(desk->image, sum);
  }
  develop(desk->image, scene.sensor, state.light, hash(frame_seed, eye == Eye::kLeft ? 0 : 1), out);
}

void render_pair(const Scene& scene, const SceneState& state, std::uint64_t frame_seed, tools::RgbImage& left,
                 tools::RgbImage& right) {
  std::jthread other([&] { render_eye(scene, state, Eye::kRight, frame_seed, right); });
  render_eye(scene, state, Eye::kLeft, frame_seed, left);
}

SceneState state_at(const Scene& scene, double t_s) {
  SceneState state;
  state.light = scene.lights.front().light;
  for (const LightStep& step : scene.lights) {
    if (step.t_s <= t_s + 1e-9) state.light = step.light;
  }
  for (const auto& [from_s, to_s] : scene.target.hidden_s) {
    state.target_there = state.target_there && !(t_s + 1e-9 >= from_s && t_s + 1e-9 < to_s);
  }
  const Transform T_W_M = to_transform(scene.target_motion.at(t_s));
  for (int i = scene.shutter_samples - 1; i >= 0; --i) {
    // The exposure is centred on the frame's time; random targets do not move within it.
    const double offset = scene.shutter_samples > 1
                              ? scene.shutter_s * (0.5 - static_cast<double>(i) / (scene.shutter_samples - 1))
                              : 0;
    SceneMoment moment;
    moment.t_s = t_s + offset;
    if (scene.hand_motion) moment.T_W_H = to_transform(scene.hand_motion->at(t_s + offset));
    moment.T_W_M = scene.target_motion.kind == Motion::Kind::kRandom
                       ? T_W_M
                       : to_transform(scene.target_motion.at(t_s + offset));
    for (const Occluder& occluder : scene.occluders) {
      moment.T_W_occluder.push_back(to_transform(occluder.motion.at(t_s + offset)));
    }
    moment.eyes = scene.eyes;
    if (scene.eyes_on_target) {
      const Transform T_W_H = scene.hand_motion ? to_transform(scene.hand_motion->at(t_s)) : Transform{};
      moment.eyes = gaze_at(scene.rig, T_W_H.inverse() * T_W_M.t_mm);
    }
    state.moments.push_back(std::move(moment));
  }
  return state;
}

}  // namespace vergence::render
