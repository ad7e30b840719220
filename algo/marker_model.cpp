// The marker's sample patterns.
#include <cmath>

#include "algo/target_model.hpp"
#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kGoldenAngle_rad = 2.399963229728653;  // pi (3 - sqrt 5)

}  // namespace

Status build_marker_model(const Ball* balls, int count, const MarkerOptions& options, MarkerModel& model) {
  if (count < 1 || count > kMaxBalls) return Status::kBadModel;
  if (options.inner_samples < 1 || options.inner_samples > kMaxInnerSamples) return Status::kBadModel;
  if (options.outer_samples < 1 || options.outer_samples > kMaxOuterSamples) return Status::kBadModel;
  if (!(options.outer_ratio > 1) || !std::isfinite(options.outer_ratio)) return Status::kBadModel;

  model = MarkerModel{};
  for (int i = 0; i < count; ++i) {
    const auto b = static_cast<unsigned>(i);
    const Ball& ball = balls[i];
    const bool finite = std::isfinite(ball.centre_mm.sum()) && std::isfinite(ball.hue_deg);
    if (!finite || !(ball.radius_mm > 0) || !std::isfinite(ball.radius_mm)) return Status::kBadModel;
    if (!(ball.tolerance_deg > 0 && ball.tolerance_deg < 180)) return Status::kBadModel;
    model.ball[b] = ball;
    model.hue[b] = hue_code_from_degrees(ball.hue_deg);
    model.tolerance[b] = static_cast<std::uint8_t>(hue_tolerance_steps(ball.tolerance_deg));
  }
  model.balls = count;
  model.inner_samples = options.inner_samples;
  model.outer_samples = options.outer_samples;

  // S_in: a sunflower, equal area a sample. S_out: evenly on one circle.
  unsigned k = 0;
  for (int i = 0; i < options.inner_samples; ++i, ++k) {
    const double radius = std::sqrt((i + 0.5) / options.inner_samples);
    const auto [sine, cosine] = sin_cos(i * kGoldenAngle_rad);
    model.pattern_x[k] = static_cast<float>(radius * cosine);
    model.pattern_y[k] = static_cast<float>(radius * sine);
  }
  for (int i = 0; i < options.outer_samples; ++i, ++k) {
    const auto [sine, cosine] = sin_cos(kTwoPi * i / options.outer_samples);
    model.pattern_x[k] = static_cast<float>(options.outer_ratio * cosine);
    model.pattern_y[k] = static_cast<float>(options.outer_ratio * sine);
  }
  return Status::kOk;
}

}  // namespace vergence
