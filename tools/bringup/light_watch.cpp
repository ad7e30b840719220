#include "tools/bringup/light_watch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "algo/hue.hpp"
#include "tools/bringup/picture.hpp"

namespace vergence::tools {
namespace {

constexpr int kGrid_px = 8;
// Pixels whose hue is worth comparing: neither dark, nor clipped, nor pale.
constexpr HueLimits kColoured{40, 250, 300};
constexpr double kRadPerStep = 2 * std::numbers::pi / kHueSteps;
constexpr double kDegPerRad = 180 / std::numbers::pi;

double luma_of(const std::array<std::uint8_t, 3>& rgb) {
  return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

double circular_deviation_deg(std::complex<double> sum, std::size_t count) {
  if (count == 0) return 0;
  const double length = std::clamp(std::abs(sum) / static_cast<double>(count), 1e-300, 1.0);
  return std::sqrt(std::max(0.0, -2 * std::log(length))) * kDegPerRad;
}

}  // namespace

void LightWatch::look(const ImageView& image) {
  const bool is_first = frames_.empty();
  Frame frame;
  std::size_t i = 0;
  for (int y = kGrid_px / 2; y < image.height_px; y += kGrid_px) {
    for (int x = kGrid_px / 2; x < image.width_px; x += kGrid_px, ++i) {
      const auto rgb = rgb_at(image, x, y);
      frame.luma += luma_of(rgb);
      const std::uint8_t hue = hue_code_rgb(rgb[0], rgb[1], rgb[2], kColoured);
      if (hue == kHueBright) ++clipped_;
      if (is_first) first_.push_back(hue);
      if (is_first && is_hue(hue)) ++coloured_at_first_;
      if (i >= first_.size() || !is_hue(hue) || !is_hue(first_[i])) continue;
      frame.turned += std::polar(1.0, kRadPerStep * (hue - first_[i]));
      ++frame.coloured;
    }
  }
  looked_ += i;
  if (i > 0) frame.luma /= static_cast<double>(i);
  frames_.push_back(frame);
}

LightSummary LightWatch::summary() const {
  LightSummary summary;
  summary.frames = frames_.size();
  if (frames_.empty() || looked_ == 0) return summary;
  const auto count = static_cast<double>(frames_.size());
  const std::size_t tenth = std::max<std::size_t>(frames_.size() / 10, 1);
  const auto mean_luma = [](std::span<const Frame> frames) {
    double sum = 0;
    for (const Frame& frame : frames) sum += frame.luma;
    return sum / static_cast<double>(frames.size());
  };
  const std::span<const Frame> all = frames_;
  summary.mean_luma = mean_luma(all);
  const double scale = std::max(summary.mean_luma, 1.0);
  summary.luma_drift = (mean_luma(all.last(tenth)) - mean_luma(all.first(tenth))) / scale;
  double squares = 0;
  for (std::size_t k = 1; k < frames_.size(); ++k)
    squares += std::pow(frames_[k].luma - frames_[k - 1].luma, 2);
  // Differences of neighbours, so that a drift does not count as flicker.
  if (frames_.size() > 1) summary.luma_flicker = std::sqrt(squares / (2 * (count - 1))) / scale;
  summary.clipped_share = static_cast<double>(clipped_) / static_cast<double>(looked_);
  summary.coloured_share = static_cast<double>(coloured_at_first_) * count / static_cast<double>(looked_);

  std::complex<double> turned;
  std::complex<double> turned_at_last;
  std::size_t coloured = 0;
  for (std::size_t k = 1; k < frames_.size(); ++k) {
    turned += frames_[k].turned;
    coloured += frames_[k].coloured;
    if (k + tenth >= frames_.size()) turned_at_last += frames_[k].turned;
  }
  summary.hue_noise_deg = circular_deviation_deg(turned, coloured);
  summary.hue_drift_deg = std::arg(turned_at_last) * kDegPerRad;
  return summary;
}

}  // namespace vergence::tools
