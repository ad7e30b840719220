#include "tools/render/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

constexpr double kReferenceLux = 500;
constexpr int kCurveSteps = 4096;

// Grey levels of linear light in [0, 1].
const std::array<float, kCurveSteps + 2>& tone_curve() {
  static const auto curve = [] {
    std::array<float, kCurveSteps + 2> table{};
    for (int i = 0; i < kCurveSteps + 2; ++i) {
      table[static_cast<std::size_t>(i)] =
          255 * encode_srgb(std::min(1.0F, static_cast<float>(i) / kCurveSteps));
    }
    return table;
  }();
  return curve;
}

std::uint8_t to_byte(float linear) {
  const float x = std::clamp(linear, 0.0F, 1.0F) * kCurveSteps;
  const auto i = static_cast<std::size_t>(x);
  const auto& curve = tone_curve();
  const float level = curve[i] + (x - static_cast<float>(i)) * (curve[i + 1] - curve[i]);
  return static_cast<std::uint8_t>(std::clamp(level + 0.5F, 0.0F, 255.0F));
}

// One pass of [a, 1-2a, a] both ways has variance 2a; passes add up.
void blur_once(LinearImage& image, float a) {
  const float b = 1 - 2 * a;
  std::vector<Rgb> line(static_cast<std::size_t>(std::max(image.width_px, image.height_px)));
  const auto along = [&](int count, auto at) {
    for (int i = 0; i < count; ++i) {
      line[static_cast<std::size_t>(i)] =
          at(i) * b + (at(std::max(i - 1, 0)) + at(std::min(i + 1, count - 1))) * a;
    }
    for (int i = 0; i < count; ++i) at(i) = line[static_cast<std::size_t>(i)];
  };
  for (int y = 0; y < image.height_px; ++y)
    along(image.width_px, [&](int i) -> Rgb& { return image.at(i, y); });
  // Columns by rows: the row above as it was is kept aside.
  std::vector<Rgb> above(image.data.begin(), image.data.begin() + image.width_px);
  std::vector<Rgb> here(above);
  for (int y = 0; y < image.height_px; ++y) {
    Rgb* row = &image.at(0, y);
    const Rgb* below = &image.at(0, std::min(y + 1, image.height_px - 1));
    std::copy(row, row + image.width_px, here.begin());
    for (int x = 0; x < image.width_px; ++x) {
      const auto i = static_cast<std::size_t>(x);
      row[x] = here[i] * b + (above[i] + (y + 1 < image.height_px ? below[x] : here[i])) * a;
    }
    std::swap(above, here);
  }
}

void blur(LinearImage& image, double sigma_px) {
  double variance = sigma_px * sigma_px;
  while (variance > 1e-6) {
    const double step = std::min(variance, 0.5);
    blur_once(image, static_cast<float>(step / 2));
    variance -= step;
  }
}

}  // namespace

void develop(LinearImage& image, const SensorOptions& options, const Light& light, std::uint64_t seed,
             tools::RgbImage& out) {
  blur(image, options.blur_px);
  if (out.width_px != image.width_px || out.height_px != image.height_px) {
    out = tools::RgbImage(image.width_px, image.height_px);
  }
  const double ratio = light.lux / kReferenceLux;
  const double gain = ratio >= 1 ? 1 / root_power(ratio, options.auto_exposure)
                                 : root_power(1 / ratio, options.auto_exposure);
  const auto signal = static_cast<float>(ratio * gain);
  // Electrons of the signal 1 in the picture, before the gain.
  const auto electrons = static_cast<float>(options.full_well_e / gain);
  const auto read = static_cast<float>(options.read_noise_e * options.read_noise_e);
  const auto saturation = static_cast<float>(light.saturation);
  const auto veil = static_cast<float>(0.18 * light.veil);
  const double cx = (image.width_px - 1) / 2.0;
  const double cy = (image.height_px - 1) / 2.0;
  const double loss = options.vignetting / (cx * cx + cy * cy);
  const std::uint64_t key = hash(seed);

  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const auto dim = static_cast<float>(1 - loss * ((x - cx) * (x - cx) + (y - cy) * (y - cy)));
      Rgb c = image.at(x, y) * (dim * signal);
      const float grey = luminance(c);
      c = mix({grey, grey, grey}, c, saturation) + light.cast * (veil * signal);
      std::array<float, 3> channel{c.r, c.g, c.b};
      if (options.noise) {
        const std::uint64_t pixel = key + 3 * image.index(x, y);
        for (std::size_t k = 0; k < 3; ++k) {
          const float e = std::max(0.0F, channel[k]) * electrons;
          channel[k] += std::sqrt(e + read) / electrons * normal(hash(pixel + k));
        }
      }
      std::uint8_t* p = out.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) p[k] = to_byte(channel[k]);
    }
  }
}

}  // namespace vergence::render
