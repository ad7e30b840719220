// Scenes from TOML: every key of docs/render.md, strictly.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "algo/trigonometry.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"
#include "tools/render/creatures.hpp"
#include "tools/render/random.hpp"
#include "tools/render/scene.hpp"
#include "tools/render/scene_parts.hpp"

namespace vergence::render {
namespace {

using tools::kPositive;
using tools::TomlReader;

Transform turned_about_y(double angle_rad, const Vector3& t_mm) {
  const auto [s, c] = sin_cos(angle_rad);
  Transform T;
  T.R << c, 0, s, 0, 1, 0, -s, 0, c;
  T.t_mm = t_mm;
  return T;
}

StereoRig read_rig(const TomlReader& root, double scale, EyeAngles& eyes, bool& eyes_on_target) {
  const TomlReader image = root.table_or_empty("image");
  image.allow_only({"width", "height", "fps", "frames"});
  const TomlReader table = root.table_or_empty("rig");
  table.allow_only({"kind", "baseline_mm", "above_mm", "converge_mm", "fx", "fy", "cx", "cy", "distortion",
                    "left_distortion", "right_distortion", "gaze", "tilt_rad", "pan_right_rad",
                    "pan_left_rad"});
  const std::string kind = table.text_or("kind", "photo");
  if (kind != "photo" && kind != "eyes") table.fail("kind", "is '" + kind + "'", "\"photo\" or \"eyes\"");
  const bool moving = kind == "eyes";

  CameraModel camera;
  const int width = image.integer_or("width", 640, 16, 4096);
  const int height = image.integer_or("height", 480, 16, 4096);
  camera.width_px = std::max(16, static_cast<int>(std::lround(width * scale)));
  camera.height_px = std::max(16, static_cast<int>(std::lround(height * scale)));
  if (camera.width_px > kMaxImageWidth || camera.height_px > kMaxImageHeight) {
    image.fail("width", "the images are too large",
               "at most " + std::to_string(kMaxImageWidth) + " x " + std::to_string(kMaxImageHeight));
  }
  camera.fx_px = scale * table.number_or("fx", 800, {1, 1e5});
  camera.fy_px = scale * table.number_or("fy", camera.fx_px / scale, {1, 1e5});
  // Pixel (0,0) is a centre, so the corner of the image is at -0.5.
  camera.cx_px = scale * (table.number_or("cx", width / 2.0, {-1e4, 1e4}) + 0.5) - 0.5;
  camera.cy_px = scale * (table.number_or("cy", height / 2.0, {-1e4, 1e4}) + 0.5) - 0.5;

  const double half = table.number_or("baseline_mm", moving ? 240 : 323, {0, 5000}) / 2;
  const double above = table.number_or("above_mm", moving ? 100 : 0, {-5000, 5000});
  // Turned inwards to meet on the axis at that distance; 0: parallel. A quarter of an angle's error matters
  // not: the pose written is the pose rendered.
  const double converge = table.number_or("converge_mm", moving ? 0 : 500, {0, 1e6});
  const double pan = converge > 0 ? std::nearbyint(std::atan2(half, converge) * 1e9) * 1e-9 : 0;
  StereoRig rig{camera, camera};
  rig.left.T_H_C = turned_about_y(pan, {-half, -above, 0});
  rig.right.T_H_C = turned_about_y(-pan, {half, -above, 0});
  const auto distortion = [&](std::string_view key, CameraModel& model) {
    if (!table.has(key)) return;
    const auto k = table.numbers(key, 5);
    for (const double value : k) {
      if (std::abs(value) > 1)
        table.fail(key, "holds a value beyond 1", "k1, k2, p1, p2, k3 as OpenCV has them");
    }
    std::copy(k.begin(), k.end(), model.distortion.begin());
  };
  distortion("distortion", rig.left);
  distortion("distortion", rig.right);
  distortion("left_distortion", rig.left);
  distortion("right_distortion", rig.right);

  const std::string gaze = table.text_or("gaze", moving ? "target" : "fixed");
  if (gaze != "fixed" && gaze != "target") table.fail("gaze", "is '" + gaze + "'", "\"fixed\" or \"target\"");
  if (gaze == "target" && !moving)
    table.fail("gaze", "the photo rig's cameras do not move", "kind = \"eyes\"");
  eyes_on_target = gaze == "target";
  eyes.tilt_rad = table.number_or("tilt_rad", 0, {-1.5, 1.5});
  eyes.pan_right_rad = table.number_or("pan_right_rad", 0, {-1.5, 1.5});
  eyes.pan_left_rad = table.number_or("pan_left_rad", 0, {-1.5, 1.5});
  return rig;
}

BackdropOptions read_backdrop(const TomlReader& table, BackdropOptions o) {
  table.allow_only({"kind", "hue_deg", "saturation", "value", "contrast", "hue_spread_deg", "feature_mm",
                    "objects", "hues_deg", "distance_mm", "seed"});
  using Kind = BackdropOptions::Kind;
  if (table.has("kind")) {
    const std::string kind = table.text("kind");
    if (kind == "plain") {
      o.kind = Kind::kPlain;
    } else if (kind == "noise") {
      o.kind = Kind::kNoise;
    } else if (kind == "clutter") {
      o.kind = Kind::kClutter;
    } else {
      table.fail("kind", "is '" + kind + "'", "\"plain\", \"noise\" or \"clutter\"");
    }
  }
  o.hue_deg = table.number_or("hue_deg", o.hue_deg, {-360, 360});
  o.saturation = table.number_or("saturation", o.saturation, {0, 1});
  o.value = table.number_or("value", o.value, {0, 1});
  o.contrast = table.number_or("contrast", o.contrast, {0, 1});
  o.hue_spread_deg = table.number_or("hue_spread_deg", o.hue_spread_deg, {0, 180});
  o.feature_mm = table.number_or("feature_mm", o.feature_mm, {4, 1500});
  o.objects = table.integer_or("objects", o.objects, 0, 2000);
  if (table.has("hues_deg")) o.hues_deg = table.numbers("hues_deg", 0);
  o.distance_mm = table.number_or("distance_mm", o.distance_mm, {50, 1e5});
  o.seed = static_cast<std::uint64_t>(table.integer_or("seed", static_cast<int>(o.seed), 0, 1 << 30));
  return o;
}

Light read_light(const TomlReader& table, Light light) {
  if (table.has("preset")) {
    const std::string name = table.text("preset");
    const auto preset = light_preset(name);
    if (!preset) table.fail("preset", "'" + name + "' is unknown", std::string(light_preset_names()));
    light = *preset;
  }
  light.lux = table.number_or("lux", light.lux, {0.1, 1e5});
  light.ambient = table.number_or("ambient", light.ambient, {0, 1});
  light.saturation = table.number_or("saturation", light.saturation, {0, 2});
  light.veil = table.number_or("veil", light.veil, {0, 10});
  if (table.has("cast")) {
    const auto c = table.numbers("cast", 3);
    for (const double v : c) {
      if (v < 0 || v > 4) table.fail("cast", "must hold factors of red, green, blue in [0, 4]");
    }
    light.cast = {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
  }
  if (table.has("towards_lamp")) {
    const auto d = table.numbers("towards_lamp", 3);
    const Vector3 direction(d[0], d[1], d[2]);
    if (!(direction.norm() > 1e-9)) table.fail("towards_lamp", "has no direction", "not all zero");
    light.towards_lamp = direction.normalized();
  }
  return light;
}

std::vector<LightStep> read_lights(const TomlReader& table) {
  table.allow_only({"preset", "lux", "ambient", "saturation", "veil", "cast", "towards_lamp", "step"});
  std::vector<LightStep> lights{{0, read_light(table, {})}};
  for (const TomlReader& step : table.tables("step", true)) {
    step.allow_only({"t_s", "preset", "lux", "ambient", "saturation", "veil", "cast", "towards_lamp"});
    const double t_s = step.number("t_s", {0, 1e6});
    if (t_s < lights.back().t_s) step.fail("t_s", "is earlier than the step before", "steps by rising time");
    lights.push_back({t_s, read_light(step, lights.back().light)});
  }
  return lights;
}

SensorOptions read_sensor(const TomlReader& table, Scene& scene) {
  table.allow_only({"samples", "noise", "auto_exposure", "full_well_e", "read_noise_e", "blur_px",
                    "vignetting", "shutter_ms", "shutter_samples"});
  SensorOptions o;
  o.noise = table.boolean_or("noise", true);
  o.auto_exposure = table.number_or("auto_exposure", o.auto_exposure, {0, 1});
  o.full_well_e = table.number_or("full_well_e", o.full_well_e, {10, 1e7});
  o.read_noise_e = table.number_or("read_noise_e", o.read_noise_e, {0, 1e5});
  o.blur_px = table.number_or("blur_px", o.blur_px, {0, 20});
  o.vignetting = table.number_or("vignetting", o.vignetting, {0, 1});
  const int samples = table.integer_or("samples", 4, 4, 16);
  if (samples != 4 && samples != 8 && samples != 16) table.fail("samples", "must be 4, 8 or 16");
  scene.sampling = static_cast<Sampling>(samples);
  scene.shutter_s = table.number_or("shutter_ms", 0, {0, 1000}) / 1000;
  scene.shutter_samples = table.integer_or("shutter_samples", scene.shutter_s > 0 ? 5 : 1, 1, 64);
  return o;
}

SearchBox read_search(const TomlReader& table, TargetKind kind) {
  table.allow_only({"centre", "half_range"});
  SearchBox box;
  // The search areas of Eqs. 4.6 and 5.21.
  if (kind == TargetKind::kMarker) box = {{0, -95, 550, 0, 0, 0}, {200, 100, 200, 0.35, 0.35, 0.35}};
  const auto six = [&](std::string_view key, std::array<double, kGenes>& to) {
    if (!table.has(key)) return;
    const auto values = table.numbers(key, 6);
    std::copy(values.begin(), values.end(), to.begin());
  };
  six("centre", box.centre);
  six("half_range", box.half_range);
  if (check(box) != Status::kOk) {
    table.fail("half_range", "is no search box", "half ranges above 0, and e1, e2, e3 inside the unit ball");
  }
  return box;
}

Water read_water(const TomlReader& table) {
  table.allow_only({"strength", "surface_mm", "wavelength_mm", "speed", "coverage"});
  Water w;
  w.strength = table.number_or("strength", 0, {0, 10});
  w.surface_mm = table.number_or("surface_mm", w.surface_mm, {0, 1e5});
  w.wavelength_mm = table.number_or("wavelength_mm", w.wavelength_mm, {1, 1e4});
  w.speed = table.number_or("speed", w.speed, {0, 100});
  w.coverage = table.number_or("coverage", w.coverage, {0.001, 1});
  return w;
}

// Poses at which both eyes, at the fixed angles, see all of the target, a margin around it.
std::function<bool(const Pose&)> seen_by_both(const StereoRig& rig, const EyeAngles& eyes, const Mesh& mesh) {
  constexpr std::size_t kVertices = 400;
  constexpr double kMargin_px = 4;
  std::vector<Vector3> points_mm;
  const std::size_t step = std::max<std::size_t>(1, mesh.vertices.size() / kVertices);
  for (std::size_t i = 0; i < mesh.vertices.size(); i += step) {
    points_mm.push_back(mesh.vertices[i].position_mm);
  }
  const Transform T_CL_H = left_eye_in_hand(rig.left.T_H_C, eyes).inverse();
  const Transform T_CR_H = right_eye_in_hand(rig.right.T_H_C, eyes).inverse();
  return [rig, points_mm, T_CL_H, T_CR_H](const Pose& pose) {
    const Transform T_H_M = to_transform(pose);
    const auto sees = [&](const CameraModel& camera, const Transform& T_C_M) {
      return std::all_of(points_mm.begin(), points_mm.end(), [&](const Vector3& p_mm) {
        Vector2 uv;
        return project(camera, T_C_M * p_mm, uv) && uv[0] >= kMargin_px && uv[1] >= kMargin_px &&
               uv[0] < camera.width_px - kMargin_px && uv[1] < camera.height_px - kMargin_px;
      });
    };
    return sees(rig.left, T_CL_H * T_H_M) && sees(rig.right, T_CR_H * T_H_M);
  };
}

Scene scene_from(const TomlReader& root, const SceneOverrides& overrides) {
  root.allow_only({"image", "rig", "target", "motion", "hand", "background", "light", "camera", "water",
                   "occluder", "model", "search", "seed"});
  Scene scene;
  scene.file = root.file();
  scene.seed = overrides.seed.value_or(static_cast<std::uint64_t>(root.integer_or("seed", 1, 0, 1 << 30)));
  scene.rig = read_rig(root, overrides.scale, scene.eyes, scene.eyes_on_target);
  const TomlReader image = root.table_or_empty("image");
  scene.fps = image.number_or("fps", 30, {0.01, 10000});
  scene.frames = image.integer_or("frames", 1, 1, 999999);

  const TomlReader background = root.table_or_empty("background");
  BackdropOptions backdrop;
  backdrop.seed = hash(scene.seed, 5) >> 40;
  scene.backdrop_options = read_backdrop(background, backdrop);
  scene.lights = read_lights(root.table_or_empty("light"));
  scene.sensor = read_sensor(root.table_or_empty("camera"), scene);
  scene.water = read_water(root.table_or_empty("water"));

  const TomlReader model = root.table_or_empty("model");
  model.allow_only({"distance_mm", "mask", "light", "background"});
  scene.photo.distance_mm = model.number_or("distance_mm", 400, {50, 10000});
  scene.photo.mask = model.boolean_or("mask", false);
  const TomlReader lamp = model.table_or_empty("light");
  lamp.allow_only({"preset", "lux", "ambient", "saturation", "veil", "cast", "towards_lamp"});
  scene.photo.light = read_light(lamp, {});
  // Without clutter, unless asked for: the photo is taken in order.
  BackdropOptions behind = scene.backdrop_options;
  if (behind.kind == BackdropOptions::Kind::kClutter) behind.kind = BackdropOptions::Kind::kNoise;
  behind.distance_mm = scene.photo.distance_mm + 300;
  scene.photo_backdrop_options = read_backdrop(model.table_or_empty("background"), behind);

  Motion still;
  still.pose.position_mm = {0, 0, 500};
  still.fps = scene.fps;
  still.seed = hash(scene.seed, 6);
  scene.target_motion = read_motion(root.table_or_empty("motion"), still);
  if (root.has("hand")) {
    Motion hand = still;
    hand.pose = {};
    hand.seed = hash(scene.seed, 7);
    scene.hand_motion = read_motion(root.table("hand"), hand);
  }
  for (const TomlReader& table : root.tables("occluder", true)) {
    scene.occluders.push_back(read_occluder(table, still));
  }
  scene.target = read_target(root.table("target"), overrides, scene.photo);
  if (scene.target_motion.in_view) {
    if (scene.eyes_on_target)
      root.fail("motion", "in_view needs eyes that stand still", "rig.gaze = \"fixed\"");
    scene.target_motion.accepts = seen_by_both(scene.rig, scene.eyes, scene.target.mesh);
  }
  scene.search = read_search(root.table_or_empty("search"), scene.target.kind);
  // What takes time comes last, so that mistakes are told at once.
  scene.left_rays = pixel_rays(scene.rig.left);
  scene.right_rays = pixel_rays(scene.rig.right);
  scene.backdrop = std::make_shared<Backdrop>(scene.backdrop_options);
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& file, const SceneOverrides& overrides) {
  return scene_from(TomlReader::from_file(file, overrides.patch), overrides);
}

Scene load_scene_text(const std::filesystem::path& name, const std::string& text,
                      const SceneOverrides& overrides) {
  return scene_from(TomlReader::from_text(name, text, overrides.patch), overrides);
}

}  // namespace vergence::render
