#include "tools/render/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tools/render/random.hpp"
#include "tools/render/wide.hpp"

namespace vergence::render {
namespace {

constexpr double kReferenceLux = 500;
constexpr int kCurveSteps = 4096;
constexpr std::size_t kChannels = 3;

struct Step {
  float from;
  float rise;
};

// Grey levels of linear light in [0, 1].
const std::array<Step, kCurveSteps + 1>& tone_curve() {
  static const auto curve = [] {
    const auto level = [](std::size_t i) {
      return 255 * encode_srgb(std::min(1.0F, static_cast<float>(i) / kCurveSteps));
    };
    std::array<Step, kCurveSteps + 1> table{};
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = {level(i), level(i + 1) - level(i)};
    return table;
  }();
  return curve;
}

// Room for a row of pixels on its way to bytes.
struct Row {
  explicit Row(std::size_t size)
      : linear(size), noise(size), whole(size), part(size), from(size), rise(size) {}
  std::vector<float> linear;
  std::vector<std::int32_t> noise;
  // On the tone curve: the step, how far through it, where it starts and how much it rises.
  std::vector<std::int32_t> whole;
  std::vector<float> part;
  std::vector<float> from;
  std::vector<float> rise;
};

VERGENCE_WIDE void to_bytes(Row& row, std::uint8_t* out) {
  const auto& curve = tone_curve();
  const std::size_t size = row.linear.size();
  for (std::size_t k = 0; k < size; ++k) {
    const float x = std::clamp(row.linear[k], 0.0F, 1.0F) * kCurveSteps;
    row.whole[k] = static_cast<std::int32_t>(x);
    row.part[k] = x - static_cast<float>(row.whole[k]);
  }
  for (std::size_t k = 0; k < size; ++k) {
    const Step& step = curve[static_cast<std::size_t>(row.whole[k])];
    row.from[k] = step.from;
    row.rise[k] = step.rise;
  }
  for (std::size_t k = 0; k < size; ++k) {
    const float level = row.from[k] + row.part[k] * row.rise[k];
    out[k] = static_cast<std::uint8_t>(static_cast<std::int32_t>(std::clamp(level + 0.5F, 0.0F, 255.0F)));
  }
}

float* numbers(LinearImage& image, int y) {
  static_assert(sizeof(Rgb) == kChannels * sizeof(float));
  return &image.at(0, y).r;
}

// One pass of [a, 1-2a, a] both ways has variance 2a; passes add up.
VERGENCE_WIDE void blur_once(LinearImage& image, float a) {
  const float b = 1 - 2 * a;
  // Rows as plain numbers, kChannels a pixel.
  const std::size_t width = kChannels * static_cast<std::size_t>(image.width_px);
  std::vector<float> before(width + 2 * kChannels);  // of a row, its outermost pixels twice
  for (int y = 0; y < image.height_px; ++y) {
    float* row = numbers(image, y);
    std::copy(row, row + width, before.begin() + kChannels);
    std::copy(row, row + kChannels, before.begin());
    std::copy(row + width - kChannels, row + width, before.end() - kChannels);
    for (std::size_t i = 0; i < width; ++i) {
      row[i] = before[i + kChannels] * b + (before[i] + before[i + 2 * kChannels]) * a;
    }
  }
  // Columns by rows: the row above as it was is kept aside.
  std::vector<float> above(numbers(image, 0), numbers(image, 0) + width);
  std::vector<float> here(above);
  for (int y = 0; y < image.height_px; ++y) {
    float* row = numbers(image, y);
    std::copy(row, row + width, here.begin());
    const float* below = y + 1 < image.height_px ? row + width : here.data();
    for (std::size_t i = 0; i < width; ++i) row[i] = here[i] * b + (above[i] + below[i]) * a;
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

VERGENCE_WIDE void develop(LinearImage& image, const SensorOptions& options, const Light& light,
                           std::uint64_t seed, tools::RgbImage& out) {
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

  const auto width = static_cast<std::size_t>(image.width_px);
  Row work(kChannels * width);
  std::vector<float>& channels = work.linear;
  for (int y = 0; y < image.height_px; ++y) {
    const Rgb* row = &image.at(0, y);
    for (std::size_t i = 0; i < width; ++i) {
      const double x = static_cast<int>(i);
      const auto dim = static_cast<float>(1 - loss * ((x - cx) * (x - cx) + (y - cy) * (y - cy)));
      Rgb c = row[i] * (dim * signal);
      const float grey = luminance(c);
      c = mix({grey, grey, grey}, c, saturation) + light.cast * (veil * signal);
      channels[kChannels * i] = c.r;
      channels[kChannels * i + 1] = c.g;
      channels[kChannels * i + 2] = c.b;
    }
    if (options.noise) {
      const std::uint64_t first = key + kChannels * image.index(0, y);
      std::vector<std::int32_t>& noise = work.noise;
      for (std::size_t k = 0; k < noise.size(); ++k) noise[k] = sum_of_four(hash(first + k));
      for (std::size_t k = 0; k < noise.size(); ++k) {
        const float e = std::max(0.0F, channels[k]) * electrons;
        channels[k] += std::sqrt(e + read) / electrons * normal_of(noise[k]);
      }
    }
    to_bytes(work, out.at(0, y));
  }
}

}  // namespace vergence::render
