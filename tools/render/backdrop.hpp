// What is behind the target: an endless plane facing the room's z axis, plain, painted or cluttered; and, for
// the pool, glints on the water in front.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "algo/pose.hpp"
#include "tools/render/colour_math.hpp"
#include "tools/render/rays.hpp"

namespace vergence::render {

struct BackdropOptions {
  enum class Kind {
    kPlain,
    kNoise,    // clouds of brightness and hue, like a sea floor or painted canvas
    kClutter,  // noise with coloured discs and bars on it
  };
  Kind kind = Kind::kNoise;
  double hue_deg = 212;
  double saturation = 0.65;
  double value = 0.62;
  double contrast = 0.5;         // of the noise, [0, 1]
  double hue_spread_deg = 12;    // of the noise
  double feature_mm = 90;        // size of its clouds
  int objects = 90;              // clutter: how many
  std::vector<double> hues_deg;  // clutter: hues to pick from; empty = any
  double distance_mm = 900;      // of the plane from the world's origin, along z
  std::uint64_t seed = 1;
};

class Backdrop {
 public:
  explicit Backdrop(const BackdropOptions& options);

  // Reflectance where a ray (world frame) meets the plane; the plain colour where it does not.
  [[nodiscard]] Rgb along(const Vector3& from_mm, const Vector3& direction) const;
  // The same along several rays.
  void along(const Vector3& from_mm, const Rays& directions, std::span<Rgb> out) const;
  [[nodiscard]] double distance_mm() const { return options_.distance_mm; }
  [[nodiscard]] const Rgb& plain() const { return plain_; }

 private:
  // Red, green, blue and nothing: four numbers that any processor takes in one (GCC and Clang).
  using Texel [[gnu::vector_size(4 * sizeof(float))]] = float;

  [[nodiscard]] std::vector<Rgb> paint_noise() const;
  void scatter_objects(std::vector<Rgb>& picture) const;
  void keep(const std::vector<Rgb>& picture);

  BackdropOptions options_;
  Rgb plain_;
  std::vector<Texel> texture_;  // repeated; its last row and column are the first again; empty when plain
};

struct Water {
  double strength = 0;        // radiance of the glints; 0 = no water
  double surface_mm = 450;    // of the water from the world's origin, along z
  double wavelength_mm = 60;  // size of the glints
  double speed = 1.2;         // how fast they change, cells a second
  double coverage = 0.12;     // share of the surface that glints
};

// Light added by the water along rays at a time.
void glint(const Water& water, const Vector3& from_mm, const Rays& directions, double t_s,
           std::span<float> out);

}  // namespace vergence::render
