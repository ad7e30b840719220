// A small world for tests: a marker or a printed card before a wall, seen by two cameras, painted with + - *
// / and sqrt only, so that the pictures are the same bytes on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "algo/rm_ga.hpp"
#include "algo/target_model.hpp"
#include "algo/tracker.hpp"

namespace vergence::testing {

struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;

  [[nodiscard]] ImageView view() const {
    return {rgb.data(),          width_px, height_px, static_cast<std::size_t>(width_px) * 3,
            PixelFormat::kRgb24, nullptr,  0};
  }
};

struct Rgb {
  double r, g, b;
};

// Smooth noise in [0, 1].
inline double noise(double x, double y, std::uint64_t seed) {
  const auto lattice = [seed](std::int64_t i, std::int64_t j) {
    CounterRandom random(seed,
                         static_cast<std::uint64_t>(i * 73856093) ^ static_cast<std::uint64_t>(j * 19349663));
    return static_cast<double>(random.next() >> 11) / 9007199254740992.0;
  };
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const double u = x - fx;
  const double v = y - fy;
  const auto i = static_cast<std::int64_t>(fx);
  const auto j = static_cast<std::int64_t>(fy);
  return (lattice(i, j) * (1 - u) + lattice(i + 1, j) * u) * (1 - v) +
         (lattice(i, j + 1) * (1 - u) + lattice(i + 1, j + 1) * u) * v;
}

inline Rgb card_colour(double x_mm, double y_mm) {
  const double a = noise(x_mm / 14, y_mm / 14, 1);
  const double b = noise(x_mm / 9, y_mm / 9, 2);
  const double c = noise(x_mm / 20, y_mm / 20, 3);
  return {30 + 210 * a, 30 + 210 * b, 30 + 210 * c};
}

inline Rgb wall_colour(double x_mm, double y_mm) {
  const double n = noise(x_mm / 60, y_mm / 60, 4);
  return {60 + 30 * n, 90 + 30 * n, 120 + 40 * n};
}

inline constexpr double kCardWidth_mm = 90;
inline constexpr double kCardHeight_mm = 70;

inline std::vector<Ball> marker_balls() {
  return {{{-50, 20, 0}, 20, 0, 20}, {{50, 30, 20}, 20, 120, 20}, {{5, -45, -20}, 20, 240, 20}};
}

struct World {
  TargetKind kind = TargetKind::kPhoto;
  bool present = true;
  double light = 1;                          // times all colours
  Rgb cast{1, 1, 1};                         // times each
  std::vector<Ball> balls = marker_balls();  // as they stand in the world; the model's are always those
  double lamp_moved = 0;  // the card is lit so much more on its right, less on its left, than in its photo
  double bowl_mm = 0;  // the card's relief: z = bowl (X^2 + Y^2 - 2/3), X and Y from -1 to 1 over it; mean 0
  bool oval = false;   // it is known of the model that the target is an ellipse within the card
  bool cut_out = false;    // and that is all there is of it
  Rgb left_wall{1, 1, 1};  // times the wall's colours, left and right of the middle: not in the photo
  Rgb right_wall{1, 1, 1};
  StereoRig rig;

  explicit World(TargetKind of) : kind(of) {
    for (CameraModel* camera : {&rig.left, &rig.right}) {
      camera->width_px = 320;
      camera->height_px = 240;
      camera->fx_px = camera->fy_px = 400;
      camera->cx_px = 159.5;
      camera->cy_px = 119.5;
    }
    rig.left.T_H_C.t_mm = {-60, 0, 0};
    rig.right.T_H_C.t_mm = {60, 0, 0};
  }

  [[nodiscard]] Picture look(const CameraModel& camera, const Transform& T_H_M) const {
    Picture picture{camera.width_px, camera.height_px, {}};
    picture.rgb.resize(static_cast<std::size_t>(camera.width_px * camera.height_px) * 3);
    const Transform T_C_M = target_in_camera(camera, T_H_M);
    const Transform T_M_C = T_C_M.inverse();
    constexpr int kSide = 3;  // samples along a pixel's side
    std::size_t at = 0;
    for (int y = 0; y < camera.height_px; ++y) {
      for (int x = 0; x < camera.width_px; ++x) {
        Rgb sum{0, 0, 0};
        for (int k = 0; k < kSide * kSide; ++k) {
          const double u = x + (k % kSide + 0.5) / kSide - 0.5;
          const double v = y + (static_cast<double>(k / kSide) + 0.5) / kSide - 0.5;
          const Vector3 ray{(u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px, 1};
          const Rgb c = see(ray, T_C_M, T_M_C, camera);
          sum = {sum.r + c.r, sum.g + c.g, sum.b + c.b};
        }
        const auto byte = [&](double value, double factor) {
          const double scaled = value / (kSide * kSide) * (light * factor) + 0.5;
          return static_cast<std::uint8_t>(scaled > 255 ? 255 : scaled);
        };
        picture.rgb[at++] = byte(sum.r, cast.r);
        picture.rgb[at++] = byte(sum.g, cast.g);
        picture.rgb[at++] = byte(sum.b, cast.b);
      }
    }
    return picture;
  }

  // The model as a user would have it: balls as they are, or a photo taken straight on at 400 mm.
  void make_model(MarkerModel& model) const {
    const auto of_model = marker_balls();
    (void)build_marker_model(of_model.data(), static_cast<int>(of_model.size()), {}, model);
  }
  void make_model(PhotoModel& model, int points = 600) const {
    CameraModel camera;
    camera.width_px = 320;
    camera.height_px = 240;
    camera.fx_px = camera.fy_px = 400;
    camera.cx_px = 159.5;
    camera.cy_px = 119.5;
    World bright = *this;
    bright.light = 1;
    bright.lamp_moved = 0;
    bright.present = true;
    bright.left_wall = bright.right_wall = {1, 1, 1};
    const Picture photo = bright.look(camera, {Matrix3::Identity(), {0, 0, 400}});
    PhotoSource source;
    source.photo = photo.view();
    source.roi = {115, 85, 90, 70};  // the card, exactly: 90 x 70 mm at 1 px a mm
    source.distance_mm = 400;
    source.camera = camera;
    source.background_hue_deg = 210;
    std::vector<std::uint8_t> within;
    if (oval) within.resize(static_cast<std::size_t>(camera.width_px * camera.height_px));
    for (std::size_t i = 0; i < within.size(); ++i) {
      const double x_mm = static_cast<double>(i % 320) - 159.5;
      const double y_mm = static_cast<double>(i / 320) - 119.5;
      within[i] = is_in_oval(x_mm, y_mm) ? 1 : 0;
    }
    if (oval) source.target = within.data();
    PhotoOptions options;
    options.points = points;
    (void)build_photo_model(source, options, {}, model);
  }

  [[nodiscard]] double relief_mm(double x_mm, double y_mm) const {
    const double x = 2 * x_mm / kCardWidth_mm;
    const double y = 2 * y_mm / kCardHeight_mm;
    return bowl_mm * (x * x + y * y - 2.0 / 3);
  }

 private:
  [[nodiscard]] static bool is_in_oval(double x_mm, double y_mm) {
    const double x = x_mm / (0.4 * kCardWidth_mm);
    const double y = y_mm / (0.4 * kCardHeight_mm);
    return x * x + y * y < 1;
  }
  [[nodiscard]] Rgb see(const Vector3& ray, const Transform& T_C_M, const Transform& T_M_C,
                        const CameraModel& camera) const {
    if (present && kind == TargetKind::kPhoto) {
      const Vector3 direction = T_M_C.R * ray;
      double t = -T_M_C.t_mm[2] / direction[2];
      Vector3 p = T_M_C.t_mm + t * direction;
      // Shallow enough that this closes in on where the ray meets the relief.
      for (int i = 0; i < (bowl_mm != 0 ? 12 : 0); ++i) {
        t = (relief_mm(p[0], p[1]) - T_M_C.t_mm[2]) / direction[2];
        p = T_M_C.t_mm + t * direction;
      }
      if (t > 0 && std::abs(p[0]) <= kCardWidth_mm / 2 && std::abs(p[1]) <= kCardHeight_mm / 2 &&
          (!cut_out || is_in_oval(p[0], p[1]))) {
        const Rgb c = card_colour(p[0], p[1]);
        const double lit = 1 + lamp_moved * 2 * p[0] / kCardWidth_mm;
        return {c.r * lit, c.g * lit, c.b * lit};
      }
    }
    if (present && kind == TargetKind::kMarker) {
      double nearest = 1e30;
      Rgb seen{0, 0, 0};
      for (std::size_t i = 0; i < balls.size(); ++i) {
        const Vector3 c = T_C_M * balls[i].centre_mm;
        const double a = ray.squaredNorm();
        const double b = ray.dot(c);
        const double d = b * b - a * (c.squaredNorm() - balls[i].radius_mm * balls[i].radius_mm);
        if (d < 0) continue;
        const double t = (b - std::sqrt(d)) / a;
        if (t <= 0 || t >= nearest) continue;
        nearest = t;
        const double facing = (c - t * ray).dot(Vector3(0.3, 0.5, 0.8)) / balls[i].radius_mm;
        const double shade = 0.6 + 0.4 * (facing > 0 ? facing : 0);
        seen = i == 0 ? Rgb{210 * shade, 35 * shade, 35 * shade}
                      : (i == 1 ? Rgb{35 * shade, 190 * shade, 35 * shade}
                                : Rgb{35 * shade, 35 * shade, 210 * shade});
      }
      if (nearest < 1e29) return seen;
    }
    const double depth = 800 - camera.T_H_C.t_mm[2];
    const double x_mm = camera.T_H_C.t_mm[0] + ray[0] * depth;
    const Rgb c = wall_colour(x_mm, ray[1] * depth);
    const Rgb& factor = x_mm < 0 ? left_wall : right_wall;
    return {c.r * factor.r, c.g * factor.g, c.b * factor.b};
  }
};

// A tracker on a world, driven frame by frame at 30 Hz with the hand standing still.
class Bench {
 public:
  explicit Bench(World world, std::uint64_t seed = 1, Method method = Method::kVergence,
                 std::optional<Stage> last_stage = {})
      : world_(std::move(world)), tracker_(std::make_unique<Tracker>()) {
    TrackerSettings settings = default_settings(method, world_.kind);
    settings.seed = seed;
    settings.last_stage = last_stage.value_or(settings.last_stage);
    settings.box = {{0, 0, 500, 0, 0, 0}, {100, 80, 150, 0.3, 0.3, 0.3}};
    if (world_.kind == TargetKind::kMarker) {
      const auto model = std::make_unique<MarkerModel>();
      world_.make_model(*model);
      status_ = tracker_->configure(world_.rig, *model, settings);
    } else {
      const auto model = std::make_unique<PhotoModel>();
      world_.make_model(*model);
      status_ = tracker_->configure(world_.rig, *model, settings);
    }
  }

  Estimate step(const Transform& T_H_M, int generations) {
    return step(world_.look(world_.rig.left, T_H_M), world_.look(world_.rig.right, T_H_M), generations);
  }
  Estimate step(const Picture& left, const Picture& right, int generations) {
    FrameMotion motion;
    motion.t_s = frame_ / 30.0;
    motion.T_H_CL = world_.rig.left.T_H_C;
    motion.T_H_CR = world_.rig.right.T_H_C;
    status_ = tracker_->begin_frame(static_cast<std::uint64_t>(frame_++), left.view(), right.view(), motion);
    for (int g = 0; g < generations; ++g) tracker_->evolve(static_cast<double>(g) / generations);
    return tracker_->end_frame();
  }

  [[nodiscard]] World& world() { return world_; }
  [[nodiscard]] Tracker& tracker() { return *tracker_; }
  [[nodiscard]] Status status() const { return status_; }

 private:
  World world_;
  std::unique_ptr<Tracker> tracker_;
  Status status_ = Status::kOk;
  int frame_ = 0;
};

}  // namespace vergence::testing
