// Gain, phase and break frequency of loops whose answers are known.
#include "tools/report/frequency_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tools/render/random.hpp"

namespace vergence::tools {
namespace {

constexpr double kPi = std::numbers::pi;

template <class Function>
std::vector<double> sampled(const std::vector<double>& t_s, Function f) {
  std::vector<double> y;
  for (const double t : t_s) y.push_back(f(t));
  return y;
}

std::vector<double> times(double duration_s, double step_s) {
  std::vector<double> t_s;
  for (int i = 0; i * step_s < duration_s; ++i) t_s.push_back(i * step_s);
  return t_s;
}

TEST(FitSine, FindsWhatItWasMadeFrom) {
  const auto t_s = times(31, 0.01);
  const double omega = 1.3;
  const auto y = sampled(t_s, [&](double t) { return 150 * std::sin(omega * t - 2.5) + 40; });
  const SineFit fit = fit_sine(t_s, y, omega, {.settle_s = 2});
  EXPECT_NEAR(fit.amplitude, 150, 1e-9);
  EXPECT_NEAR(fit.phase_rad, -2.5, 1e-9);
  EXPECT_NEAR(fit.offset, 40, 1e-9);
  EXPECT_EQ(fit.drift_per_s, 0);
  EXPECT_LT(fit.residual_rms, 1e-9);
}

TEST(FitSine, UsesWholePeriodsAfterSettling) {
  // 10 s of steps of 0.01 s after 1 s of settling: four periods of 2.5 s, of 250 samples each.
  const auto t_s = times(11.0 - 0.001, 0.01);
  ASSERT_EQ(t_s.size(), 1100U);
  // The transient is wild, and must not count.
  const auto y = sampled(t_s, [](double t) { return t < 0.995 ? 1e6 : std::sin(2 * kPi / 2.5 * t); });
  const SineFit fit = fit_sine(t_s, y, 2 * kPi / 2.5, {.settle_s = 1});
  EXPECT_EQ(fit.samples, 1000U);
  EXPECT_NEAR(fit.amplitude, 1, 1e-9);
  EXPECT_EQ(fit_sine(t_s, y, 2 * kPi / 4, {.settle_s = 1}).samples, 800U);
}

TEST(FitSine, LeavesNoiseInTheResidual) {
  const auto t_s = times(60, 0.005);
  std::uint64_t drawn = 0;
  const auto y = sampled(t_s, [&](double t) {
    const double noise = render::normal(render::hash(3, drawn++));
    return 10 * std::sin(t + 0.4) + 2 * noise;
  });
  const SineFit fit = fit_sine(t_s, y, 1);
  // Standard error of the amplitude: 2 sqrt(2 / 11300) = 0.027.
  EXPECT_NEAR(fit.amplitude, 10, 0.11);
  EXPECT_NEAR(fit.phase_rad, 0.4, 0.011);
  EXPECT_NEAR(fit.residual_rms, 2, 0.08);
}

TEST(FitSine, TellsDriftFromTheSineOnlyWhereAsked) {
  const auto t_s = times(20, 0.01);
  const auto y = sampled(t_s, [](double t) { return 5 * std::sin(2 * t) + 3 * t; });
  const SineFit fit = fit_sine(t_s, y, 2, {.drift = true});
  EXPECT_NEAR(fit.amplitude, 5, 1e-9);
  EXPECT_NEAR(fit.drift_per_s, 3, 1e-9);
  EXPECT_GT(std::abs(fit_sine(t_s, y, 2).amplitude - 5), 0.5);
}

TEST(FitSine, LeavesOutWhatIsNotThere) {
  const auto t_s = times(20, 0.01);
  auto y = sampled(t_s, [](double t) { return 5 * std::sin(2 * t + 1); });
  for (std::size_t i = 300; i < 500; ++i) y[i] = std::numeric_limits<double>::quiet_NaN();
  y[700] = std::numeric_limits<double>::infinity();
  const SineFit fit = fit_sine(t_s, y, 2);
  EXPECT_NEAR(fit.amplitude, 5, 1e-9);
  EXPECT_NEAR(fit.phase_rad, 1, 1e-9);
}

TEST(FitSine, RefusesWhatCannotBeAnswered) {
  const auto t_s = times(10, 0.01);
  const auto y = sampled(t_s, [](double t) { return std::sin(t); });
  EXPECT_THROW((void)fit_sine(t_s, std::vector<double>(3), 1), std::invalid_argument);
  EXPECT_THROW((void)fit_sine(t_s, y, 0), std::invalid_argument);
  EXPECT_THROW((void)fit_sine(t_s, y, 0.5), std::invalid_argument) << "less than a period";
  EXPECT_THROW((void)fit_sine(t_s, y, 1, {.settle_s = 5}), std::invalid_argument);
  EXPECT_THROW((void)fit_sine(t_s, y, 1, {.settle_s = 50}), std::invalid_argument);
  EXPECT_THROW((void)fit_sine(t_s, y, kPi / 0.01), std::invalid_argument) << "two samples a period";
  const std::vector<double> backwards{0, 1, 2, 1.5, 3, 4, 5, 6, 7};
  EXPECT_THROW((void)fit_sine(backwards, backwards, 1), std::invalid_argument);
  const std::vector<double> gone(t_s.size(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW((void)fit_sine(t_s, gone, 1), std::invalid_argument);
}

double lag_of(double lag_deg) {
  const auto t_s = times(20, 0.01);
  const auto in = sampled(t_s, [](double t) { return std::sin(2 * t + 3); });
  const auto out = sampled(t_s, [&](double t) { return std::sin(2 * t + 3 - lag_deg * kPi / 180); });
  return frequency_response(t_s, in, out, 2).phase_deg;
}

TEST(FrequencyResponse, TakesPhaseForALagButKeepsASmallLead) {
  for (const double lag_deg : {0.0, 5.0, 90.0, 179.0, 181.0, 270.0, 329.0, -1.0, -29.0}) {
    EXPECT_NEAR(lag_of(lag_deg), -lag_deg, 1e-9);
  }
  EXPECT_NEAR(lag_of(-31), -329, 1e-9);
}

TEST(FrequencyResponse, RefusesAnInputThatStandsStill) {
  const auto t_s = times(20, 0.01);
  const std::vector<double> still(t_s.size(), 500);
  EXPECT_THROW((void)frequency_response(t_s, still, sampled(t_s, [](double t) { return std::sin(t); }), 1),
               std::invalid_argument);
}

// T y' = u - y, solved exactly for an input held between samples so fine that holding does not matter.
TEST(FrequencyResponse, OfAFirstOrderSystem) {
  const double time_constant_s = 0.8;
  const double step_s = 0.0005;
  std::vector<FrequencyResponse> responses;
  for (const double omega : {0.2, 0.5, 1.2, 1.3, 3.0}) {
    const auto t_s = times(6 + 2.05 * 2 * kPi / omega, step_s);
    const auto u = sampled(t_s, [&](double t) { return 100 * std::sin(omega * t); });
    std::vector<double> y{0};
    const double kept = std::exp(-step_s / time_constant_s);
    for (std::size_t i = 1; i < u.size(); ++i) {
      y.push_back(kept * y.back() + (1 - kept) * 0.5 * (u[i] + u[i - 1]));
    }
    responses.push_back(frequency_response(t_s, u, y, omega, {.settle_s = 6}));
    const double x = omega * time_constant_s;
    EXPECT_NEAR(responses.back().gain_db, -10 * std::log10(1 + x * x), 0.005) << omega;
    EXPECT_NEAR(responses.back().phase_deg, -std::atan(x) * 180 / kPi, 0.05) << omega;
  }
  const auto found = break_frequency(responses);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, std::sqrt(std::pow(10, 0.3) - 1) / time_constant_s, 0.002);
}

TEST(FrequencyResponse, UnwrapsAlongFrequency) {
  std::vector<FrequencyResponse> responses(5);
  const double wanted[] = {-10, -150, -300, -390, -520};
  for (std::size_t i = 0; i < 5; ++i) responses[i].phase_deg = wanted[i] < -330 ? wanted[i] + 360 : wanted[i];
  unwrap_phases(responses);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_DOUBLE_EQ(responses[i].phase_deg, wanted[i]);
}

TEST(BreakFrequency, InterpolatesOverTheLogarithm) {
  const std::vector<GainPoint> points{{10, -5}, {0.1, 0}, {1, -1}};  // in any order
  ASSERT_TRUE(break_frequency(points));
  EXPECT_NEAR(*break_frequency(points), std::sqrt(10), 1e-12);
  EXPECT_NEAR(*break_frequency(points, -1.0), 1, 1e-12);
}

TEST(BreakFrequency, IsNoneWhereGainDoesNotFallThroughTheLevel) {
  EXPECT_FALSE(break_frequency(std::vector<GainPoint>{{0.1, 0}, {1, -1}, {10, -2.9}}));
  EXPECT_FALSE(break_frequency(std::vector<GainPoint>{{0.1, -4}, {1, -6}}));
  EXPECT_FALSE(break_frequency(std::vector<GainPoint>{}));
}

TEST(BreakFrequency, TakesTheFirstFall) {
  const std::vector<GainPoint> points{{1, 0}, {2, -6}, {4, 0}, {8, -6}};
  EXPECT_NEAR(*break_frequency(points), std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace vergence::tools
