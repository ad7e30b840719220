#include "tools/render/scene_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/render/creatures.hpp"
#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

using tools::kPositive;
using tools::TomlReader;

Pose pose_from(const TomlReader& table, std::string_view key) {
  const auto v = table.numbers(key, 6);
  Pose pose{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
  if (!is_valid(pose)) {
    table.fail(key, "e1, e2, e3 are no part of a unit quaternion", "their length must be at most 1");
  }
  return pose;
}

Rgb colour_from(const TomlReader& table, double hue_deg, double saturation, double value) {
  return from_hsv(table.number_or("hue_deg", hue_deg, {-360, 360}),
                  table.number_or("saturation", saturation, {0, 1}), table.number_or("value", value, {0, 1}));
}

// Red, green and blue, each at its own depth, so that all six components show.
std::vector<Ball> default_balls() {
  return {{{-45, 30, 20}, 20, 0, 20}, {{45, 25, -15}, 20, 120, 20}, {{5, -45, 0}, 20, 240, 20}};
}

SceneTarget read_marker(const TomlReader& table) {
  table.allow_only({"kind", "ball", "hidden_s", "absent"});
  SceneTarget target;
  target.kind = TargetKind::kMarker;
  target.name = "marker";
  target.balls = default_balls();
  if (table.has("ball")) target.balls.clear();
  for (const TomlReader& entry : table.tables("ball", true)) {
    entry.allow_only({"centre_mm", "radius_mm", "hue_deg", "tolerance_deg"});
    const auto c = entry.numbers("centre_mm", 3);
    target.balls.push_back({{c[0], c[1], c[2]},
                            entry.number_or("radius_mm", 20, {0.5, 1000}),
                            entry.number("hue_deg", {-360, 360}),
                            entry.number_or("tolerance_deg", 20, {0.1, 179})});
  }
  if (target.balls.size() > kMaxBalls)
    table.fail("ball", "too many balls", "at most " + std::to_string(kMaxBalls));
  for (const Ball& ball : target.balls) {
    target.mesh.append(make_ball(ball.centre_mm, ball.radius_mm, from_hsv(ball.hue_deg, 0.86, 0.86)));
  }
  return target;
}

SceneTarget read_creature(const TomlReader& table, const SceneOverrides& overrides) {
  table.allow_only({"kind", "creature", "mesh_mm", "hidden_s", "absent"});
  const std::string name = overrides.target.value_or(table.text_or("creature", "C12"));
  const Creature* creature = find_creature(name);
  if (creature == nullptr) {
    std::string known;
    for (const Creature& c : creatures())
      known += (known.empty() ? "" : ", ") + std::string(c.code) + " " + std::string(c.name);
    table.fail("creature", "'" + name + "' is unknown", known);
  }
  SceneTarget target;
  target.name = std::string(creature->code) + " " + std::string(creature->name);
  target.mesh = make_creature(*creature, table.number_or("mesh_mm", 0.8, {0.3, 10}));
  return target;
}

SceneTarget read_card(const TomlReader& table) {
  table.allow_only({"kind", "size_mm", "picture", "seed", "hidden_s", "absent"});
  const std::vector<double> size =
      table.has("size_mm") ? table.numbers("size_mm", 2) : std::vector<double>{120, 90};
  for (const double v : size) {
    if (!(v >= 5 && v <= 2000)) table.fail("size_mm", "must lie in [5, 2000]");
  }
  SceneTarget target;
  target.name = "card";
  tools::RgbImage picture;
  if (table.has("picture")) {
    picture = tools::read_png_rgb(table.file().parent_path() / table.text("picture"));
  } else {
    const int seed = table.integer_or("seed", 3, 0, 1 << 30);
    picture = make_card_picture(4 * static_cast<int>(size[0]), 4 * static_cast<int>(size[1]),
                                static_cast<std::uint64_t>(seed));
  }
  target.mesh = make_card(size[0], size[1], picture, 0.6);
  return target;
}

std::vector<std::array<double, 2>> read_hidden(const TomlReader& table) {
  constexpr double kAlways_s = 1e9;
  if (table.boolean_or("absent", false)) return {{-kAlways_s, kAlways_s}};
  if (!table.has("hidden_s")) return {};
  const std::vector<double> times = table.numbers("hidden_s", 0);
  if (times.size() % 2 != 0) table.fail("hidden_s", "a span has no end", "[from, to, from, to, ...]");
  std::vector<std::array<double, 2>> spans;
  for (std::size_t i = 0; i + 1 < times.size(); i += 2) spans.push_back({times[i], times[i + 1]});
  return spans;
}

}  // namespace

tools::RgbImage make_card_picture(int width_px, int height_px, std::uint64_t seed) {
  BackdropOptions options;
  options.kind = BackdropOptions::Kind::kClutter;
  options.hue_deg = 40;
  options.saturation = 0.55;
  options.value = 0.80;
  options.hue_spread_deg = 70;
  options.feature_mm = 120;
  options.objects = 260;
  options.distance_mm = 1000;
  options.seed = seed;
  const Backdrop painting(options);
  tools::RgbImage picture(width_px, height_px);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      const Rgb c = painting.along({x * 1.2, y * 1.2, 0}, {0, 0, 1});
      const auto byte = [](float v) {
        return static_cast<std::uint8_t>(255 * encode_srgb(std::clamp(v, 0.0F, 1.0F)) + 0.5F);
      };
      std::uint8_t* p = picture.at(x, y);
      p[0] = byte(c.r);
      p[1] = byte(c.g);
      p[2] = byte(c.b);
    }
  }
  return picture;
}

SceneTarget read_target(const TomlReader& table, const SceneOverrides& overrides,
                        const PhotoOptionsOfScene& photo) {
  const std::string kind = table.text("kind");
  if (kind != "creature" && overrides.target) {
    table.fail("kind", "is '" + kind + "', so no creature can be put in its place", "kind = \"creature\"");
  }
  if (kind == "marker") {
    SceneTarget marker = read_marker(table);
    marker.hidden_s = read_hidden(table);
    return marker;
  }
  SceneTarget target;
  if (kind == "creature") {
    target = read_creature(table, overrides);
  } else if (kind == "card") {
    target = read_card(table);
  } else {
    table.fail("kind", "is '" + kind + "'", "\"marker\", \"creature\" or \"card\"");
  }
  target.hidden_s = read_hidden(table);
  settle_model_frame(target, photo);
  if (target.roi.width < 2 || target.roi.height < 2 || target.roi.x <= 0 || target.roi.y <= 0 ||
      target.roi.x + target.roi.width >= photo.camera.width_px ||
      target.roi.y + target.roi.height >= photo.camera.height_px) {
    table.fail("kind", "the target does not fit into the model photo", "a larger model.distance_mm");
  }
  return target;
}

Motion read_motion(const TomlReader& table, const Motion& fallback) {
  table.allow_only({"kind", "pose", "amplitude", "omega_rad_s", "phase_rad", "swing_deg", "swing_deg_s",
                    "pivot_mm", "rest_s", "key", "in_view"});
  Motion motion = fallback;
  if (table.has("pose")) motion.pose = pose_from(table, "pose");
  const std::string kind = table.text_or("kind", "still");
  const auto amplitude = [&] {
    const auto a = table.numbers("amplitude", 6);
    std::copy(a.begin(), a.end(), motion.amplitude.begin());
    const double reach =
        (Vector3(std::abs(a[3]), std::abs(a[4]), std::abs(a[5])) * (kind == "cosine" ? 2 : 1) +
         motion.pose.e.cwiseAbs())
            .norm();
    if (reach > 1) table.fail("amplitude", "turns beyond half a turn", "e1, e2, e3 together at most 1");
  };
  using Kind = Motion::Kind;
  if (kind == "still") {
    motion.kind = Kind::kStill;
  } else if (kind == "sine" || kind == "cosine") {
    motion.kind = kind == "sine" ? Kind::kSine : Kind::kCosine;
    amplitude();
    motion.omega_rad_s = table.number_or("omega_rad_s", 0.628, {0, 1000});
    motion.phase_rad = table.number_or("phase_rad", 0, {-1000, 1000});
  } else if (kind == "swing") {
    motion.kind = Kind::kSwing;
    motion.swing_rad = table.number_or("swing_deg", 20, {0.01, 170}) * std::numbers::pi / 180;
    motion.swing_rad_s = table.number_or("swing_deg_s", 4.5, {1e-3, 1e4}) * std::numbers::pi / 180;
    motion.pivot_mm = motion.pose.position_mm;
    if (table.has("pivot_mm")) {
      const auto p = table.numbers("pivot_mm", 3);
      motion.pivot_mm = {p[0], p[1], p[2]};
    }
  } else if (kind == "steps20") {
    motion.kind = Kind::kKeys;
    motion.keys = twenty_steps(motion.pose, table.number_or("rest_s", 1, {0, 1000}));
  } else if (kind == "keys") {
    motion.kind = Kind::kKeys;
    for (const TomlReader& entry : table.tables("key")) {
      entry.allow_only({"t_s", "pose", "teleport"});
      PoseKey key{entry.number("t_s", {-1e6, 1e6}), pose_from(entry, "pose"),
                  entry.boolean_or("teleport", false)};
      if (!motion.keys.empty() && key.t_s < motion.keys.back().t_s) {
        entry.fail("t_s", "is earlier than the key before", "keys by rising time");
      }
      motion.keys.push_back(key);
    }
  } else if (kind == "random") {
    motion.kind = Kind::kRandom;
    motion.in_view = table.boolean_or("in_view", false);
    amplitude();
  } else {
    table.fail("kind", "is '" + kind + "'",
               "\"still\", \"sine\", \"cosine\", \"swing\", \"steps20\", \"keys\" or \"random\"");
  }
  return motion;
}

Occluder read_occluder(const TomlReader& table, const Motion& fallback) {
  table.allow_only(
      {"width_mm", "depth_mm", "length_mm", "direction", "hue_deg", "saturation", "value", "motion"});
  const double radius = table.number_or("width_mm", 20, {0.5, 1000}) / 2;
  const double half = table.number_or("length_mm", 600, {1, 10000}) / 2;
  Vector3 direction(0, 1, 0);
  if (table.has("direction")) {
    const auto d = table.numbers("direction", 3);
    direction = {d[0], d[1], d[2]};
    if (!(direction.norm() > 1e-9)) table.fail("direction", "has no direction", "not all zero");
    direction.normalize();
  }
  Occluder occluder{make_bar(-half * direction, half * direction, radius, colour_from(table, 30, 0.45, 0.55)),
                    {}};
  // A board: the bar pressed flat along z.
  if (table.has("depth_mm")) {
    occluder.mesh.press(table.number("depth_mm", {0.5, 1000}) / (2 * radius));
  }
  Motion still = fallback;
  still.pose.position_mm = {0, 0, 400};
  occluder.motion = read_motion(table.table_or_empty("motion"), still);
  return occluder;
}

}  // namespace vergence::render
