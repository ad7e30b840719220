#include "tools/render/backdrop.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/random.hpp"
#include "tools/render/wide.hpp"

namespace vergence::render {
namespace {

constexpr int kSize = 1024;        // texels a side of the texture
constexpr double kTexel_mm = 1.5;  // so that it repeats every 1.5 m
constexpr std::size_t kRow = kSize + 1;

Rgb& texel(std::vector<Rgb>& texture, int x, int y) {
  return texture[static_cast<std::size_t>(y & (kSize - 1)) * kSize +
                 static_cast<std::size_t>(x & (kSize - 1))];
}

// As for Rgb.
template <typename Texel>
Texel mix(const Texel& a, const Texel& b, float t) {
  return a * (1 - t) + b * t;
}

}  // namespace

Backdrop::Backdrop(const BackdropOptions& options)
    : options_(options), plain_(from_hsv(options.hue_deg, options.saturation, options.value)) {
  if (options.kind == BackdropOptions::Kind::kPlain) return;
  std::vector<Rgb> picture = paint_noise();
  if (options.kind == BackdropOptions::Kind::kClutter) scatter_objects(picture);
  keep(picture);
}

std::vector<Rgb> Backdrop::paint_noise() const {
  std::vector<Rgb> picture(static_cast<std::size_t>(kSize) * kSize);
  const int cells = std::max(1, static_cast<int>(std::lround(kSize * kTexel_mm / options_.feature_mm)));
  const double scale = static_cast<double>(cells) / kSize;
  std::vector<double> xs(kSize);
  std::vector<double> ys(kSize);
  std::vector<double> light(kSize);
  std::vector<double> tint(kSize);
  for (std::size_t x = 0; x < kSize; ++x) xs[x] = static_cast<double>(x) * scale;
  for (int y = 0; y < kSize; ++y) {
    std::fill(ys.begin(), ys.end(), y * scale);
    fractal_noise(xs, ys, 0, options_.seed, 5, cells, light);
    fractal_noise(xs, ys, 0, options_.seed + 50, 3, cells, tint);
    for (int x = 0; x < kSize; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const double value = std::clamp(options_.value * (1 + 0.9 * options_.contrast * light[i]), 0.02, 1.0);
      const double saturation =
          std::clamp(options_.saturation * (1 - 0.25 * options_.contrast * light[i]), 0.0, 1.0);
      texel(picture, x, y) =
          from_hsv(options_.hue_deg + 2 * options_.hue_spread_deg * tint[i], saturation, value);
    }
  }
  return picture;
}

void Backdrop::keep(const std::vector<Rgb>& picture) {
  texture_.resize(kRow * kRow);
  for (std::size_t y = 0; y < kRow; ++y) {
    for (std::size_t x = 0; x < kRow; ++x) {
      const Rgb& c = picture[(y % kSize) * kSize + x % kSize];
      texture_[y * kRow + x] = Texel{c.r, c.g, c.b, 0};
    }
  }
}

void Backdrop::scatter_objects(std::vector<Rgb>& picture) const {
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
        Rgb& at = texel(picture, static_cast<int>(centre[0]) + dx, static_cast<int>(centre[1]) + dy);
        at = mix(at, colour * static_cast<float>(1 - 0.25 * v / radius), inside);
      }
    }
  }
}

Rgb Backdrop::along(const Vector3& from_mm, const Vector3& direction) const {
  Rays one;
  one.add(direction);
  Rgb colour;
  along(from_mm, one, {&colour, 1});
  return colour;
}

VERGENCE_WIDE void Backdrop::along(const Vector3& from_mm, const Rays& directions, std::span<Rgb> out) const {
  const std::size_t count = directions.count;
  const double way = options_.distance_mm - from_mm[2];
  if (texture_.empty() || way <= 0) {
    std::fill_n(out.begin(), count, plain_);
    return;
  }
  std::array<bool, Rays::kMost> meets;
  std::array<std::int32_t, Rays::kMost> at;
  std::array<float, Rays::kMost> fx;
  std::array<float, Rays::kMost> fy;
  for (std::size_t i = 0; i < count; ++i) {
    const double scale = way / directions.z[i];
    const double u = (from_mm[0] + scale * directions.x[i]) / kTexel_mm + kSize / 2.0;
    const double v = (from_mm[1] + scale * directions.y[i]) / kTexel_mm + kSize / 2.0;
    meets[i] = directions.z[i] > 1e-6 && std::abs(u) <= 1e6 && std::abs(v) <= 1e6;
    const double left = std::floor(meets[i] ? u : 0);
    const double top = std::floor(meets[i] ? v : 0);
    at[i] = (static_cast<std::int32_t>(top) & (kSize - 1)) * static_cast<std::int32_t>(kRow) +
            (static_cast<std::int32_t>(left) & (kSize - 1));
    fx[i] = static_cast<float>(u - left);
    fy[i] = static_cast<float>(v - top);
  }
  std::array<Texel, Rays::kMost> colours;
  for (std::size_t i = 0; i < count; ++i) {
    const Texel* upper = &texture_[static_cast<std::size_t>(at[i])];
    const Texel* lower = upper + kRow;
    colours[i] = mix(mix(upper[0], upper[1], fx[i]), mix(lower[0], lower[1], fx[i]), fy[i]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = meets[i] ? Rgb{colours[i][0], colours[i][1], colours[i][2]} : plain_;
  }
}

void glint(const Water& water, const Vector3& from_mm, const Rays& directions, double t_s,
           std::span<float> out) {
  const std::size_t count = directions.count;
  const double way = water.surface_mm - from_mm[2];
  if (way <= 0) {
    std::fill_n(out.begin(), count, 0.0F);
    return;
  }
  using Row = std::array<double, Rays::kMost>;
  Row x;
  Row y;
  Row finer_x;
  Row finer_y;
  Row a;
  Row b;
  const double z = water.speed * t_s;
  for (std::size_t i = 0; i < count; ++i) {
    const double scale = directions.z[i] > 1e-6 ? way / directions.z[i] / water.wavelength_mm : 0;
    x[i] = from_mm[0] / water.wavelength_mm + scale * directions.x[i];
    y[i] = from_mm[1] / water.wavelength_mm + scale * directions.y[i];
    finer_x[i] = 1.7 * x[i] + 5;
    finer_y[i] = 1.7 * y[i] + 3;
  }
  // Crests, bright where two wave trains meet: ridges of smooth noise.
  value_noise(x, y, z, 77, 0, std::span(a).first(count));
  value_noise(finer_x, finer_y, 1.7 * z + 1, 78, 0, std::span(b).first(count));
  for (std::size_t i = 0; i < count; ++i) {
    const double crests = (1 - std::abs(a[i])) * (1 - std::abs(b[i]));
    const auto light = static_cast<float>(water.strength * smooth_step(1 - 0.6 * water.coverage, 1, crests));
    out[i] = directions.z[i] > 1e-6 ? light : 0;
  }
}

}  // namespace vergence::render
