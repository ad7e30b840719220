#include "tools/render/backdrop.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

constexpr int kSize = 1024;        // texels a side of the texture
constexpr double kTexel_mm = 1.5;  // so that it repeats every 1.5 m

Rgb& texel(std::vector<Rgb>& texture, int x, int y) {
  return texture[static_cast<std::size_t>(y & (kSize - 1)) * kSize +
                 static_cast<std::size_t>(x & (kSize - 1))];
}

}  // namespace

Backdrop::Backdrop(const BackdropOptions& options)
    : options_(options), plain_(from_hsv(options.hue_deg, options.saturation, options.value)) {
  if (options.kind == BackdropOptions::Kind::kPlain) return;
  paint_noise();
  if (options.kind == BackdropOptions::Kind::kClutter) scatter_objects();
}

void Backdrop::paint_noise() {
  texture_.resize(static_cast<std::size_t>(kSize) * kSize);
  const int cells = std::max(1, static_cast<int>(std::lround(kSize * kTexel_mm / options_.feature_mm)));
  const double scale = static_cast<double>(cells) / kSize;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Vector3 p(x * scale, y * scale, 0);
      const double light = fractal_noise(p, options_.seed, 5, cells);
      const double tint = fractal_noise(p, options_.seed + 50, 3, cells);
      const double value = std::clamp(options_.value * (1 + 0.9 * options_.contrast * light), 0.02, 1.0);
      const double saturation =
          std::clamp(options_.saturation * (1 - 0.25 * options_.contrast * light), 0.0, 1.0);
      texel(texture_, x, y) =
          from_hsv(options_.hue_deg + 2 * options_.hue_spread_deg * tint, saturation, value);
    }
  }
}

void Backdrop::scatter_objects() {
  for (int i = 0; i < options_.objects; ++i) {
    std::uint64_t draw = 0;
    const std::uint64_t seed = hash(options_.seed, 1000 + static_cast<std::uint64_t>(i));
    const auto random = [&] { return uniform(seed, draw++); };
    const Vector2 centre(random() * kSize, random() * kSize);
    const double radius = (10 + 32 * random()) / kTexel_mm;
    const double slender = random() < 0.5 ? 1.0 : 0.15 + 0.5 * random();  // discs, or ellipses and bars
    const auto [sine, cosine] = sin_cos(2 * std::numbers::pi * random());
    const bool box = random() < 0.4;
    const double any = 360 * random();
    const double pick = random();
    const double hue =
        options_.hues_deg.empty()
            ? any
            : options_
                  .hues_deg[static_cast<std::size_t>(pick * static_cast<double>(options_.hues_deg.size()))];
    const Rgb colour = from_hsv(hue, 0.55 + 0.4 * random(), 0.45 + 0.5 * random());
    const int reach = static_cast<int>(radius * 1.5) + 2;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const double u = std::abs(cosine * dx + sine * dy);
        const double v = std::abs(cosine * dy - sine * dx) / slender;
        const double d = box ? std::max(u, v) : std::sqrt(u * u + v * v);
        const auto inside = static_cast<float>(std::clamp((radius - d) * slender + 0.5, 0.0, 1.0));
        if (inside <= 0) continue;
        Rgb& at = texel(texture_, static_cast<int>(centre[0]) + dx, static_cast<int>(centre[1]) + dy);
        at = mix(at, colour * static_cast<float>(1 - 0.25 * v / radius), inside);
      }
    }
  }
}

Rgb Backdrop::along(const Vector3& from_mm, const Vector3& direction) const {
  const double way = options_.distance_mm - from_mm[2];
  if (texture_.empty() || direction[2] <= 1e-6 || way <= 0) return plain_;
  const double scale = way / direction[2];
  const double u = (from_mm[0] + scale * direction[0]) / kTexel_mm + kSize / 2.0;
  const double v = (from_mm[1] + scale * direction[1]) / kTexel_mm + kSize / 2.0;
  if (std::abs(u) > 1e6 || std::abs(v) > 1e6) return plain_;
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const auto fx = static_cast<float>(u - x);
  const auto fy = static_cast<float>(v - y);
  const auto at = [&](int i, int k) {
    return texture_[static_cast<std::size_t>(k & (kSize - 1)) * kSize +
                    static_cast<std::size_t>(i & (kSize - 1))];
  };
  return mix(mix(at(x, y), at(x + 1, y), fx), mix(at(x, y + 1), at(x + 1, y + 1), fx), fy);
}

float glint(const Water& water, const Vector3& from_mm, const Vector3& direction, double t_s) {
  const double way = water.surface_mm - from_mm[2];
  if (direction[2] <= 1e-6 || way <= 0) return 0;
  const double scale = way / direction[2] / water.wavelength_mm;
  const Vector3 p(from_mm[0] / water.wavelength_mm + scale * direction[0],
                  from_mm[1] / water.wavelength_mm + scale * direction[1], water.speed * t_s);
  // Crests, bright where two wave trains meet: ridges of smooth noise.
  const double a = 1 - std::abs(value_noise(p, 77));
  const double b = 1 - std::abs(value_noise(1.7 * p + Vector3(5, 3, 1), 78));
  return static_cast<float>(water.strength * smooth_step(1 - 0.6 * water.coverage, 1, a * b));
}

}  // namespace vergence::render
