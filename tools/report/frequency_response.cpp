#include "tools/report/frequency_response.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace vergence::tools {
namespace {

constexpr double kTurn_deg = 360;
constexpr double kMostLead_deg = 30;

// Half-open range of samples.
struct Window {
  std::size_t first = 0;
  std::size_t end = 0;
};

Window whole_periods(std::span<const double> t_s, double period_s, double settle_s) {
  const auto first = std::lower_bound(t_s.begin(), t_s.end(), t_s.front() + settle_s);
  const double step_s = (t_s.back() - t_s.front()) / static_cast<double>(t_s.size() - 1);
  if (first == t_s.end()) throw std::invalid_argument("no samples are left after settling");
  // The last sample stands for one step of time; the margin is for rounding.
  const double periods = std::floor((t_s.back() - *first + step_s) / period_s + 1e-6);
  if (periods < 1) throw std::invalid_argument("less than a whole period of the sine after settling");
  const auto end = std::lower_bound(first, t_s.end(), *first + periods * period_s - 0.5 * step_s);
  return {static_cast<std::size_t>(first - t_s.begin()), static_cast<std::size_t>(end - t_s.begin())};
}

}  // namespace

SineFit fit_sine(std::span<const double> t_s, std::span<const double> y, double omega_rad_s,
                 const SineFitOptions& options) {
  if (t_s.size() != y.size()) throw std::invalid_argument("as many times as values are needed");
  if (t_s.size() < 2 ||
      std::adjacent_find(t_s.begin(), t_s.end(), [](double a, double b) { return !(a < b); }) != t_s.end()) {
    throw std::invalid_argument("two samples or more of increasing time are needed");
  }
  if (!(omega_rad_s > 0)) throw std::invalid_argument("the frequency of the sine must be positive");
  const Window window = whole_periods(t_s, 2 * std::numbers::pi / omega_rad_s, options.settle_s);
  std::vector<std::size_t> used;
  for (std::size_t i = window.first; i < window.end; ++i) {
    if (std::isfinite(y[i])) used.push_back(i);
  }
  const Eigen::Index unknowns = options.drift ? 4 : 3;
  const auto samples = static_cast<Eigen::Index>(used.size());
  if (samples < unknowns) throw std::invalid_argument("too few samples to tell the sine from");
  const double middle_s = 0.5 * (t_s[window.first] + t_s[window.end - 1]);
  Eigen::MatrixXd basis(samples, unknowns);
  Eigen::VectorXd values(samples);
  for (Eigen::Index row = 0; row < samples; ++row) {
    const std::size_t i = used[static_cast<std::size_t>(row)];
    basis(row, 0) = std::sin(omega_rad_s * t_s[i]);
    basis(row, 1) = std::cos(omega_rad_s * t_s[i]);
    basis(row, 2) = 1;
    if (options.drift) basis(row, 3) = t_s[i] - middle_s;
    values[row] = y[i];
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(basis);
  qr.setThreshold(1e-9);
  if (qr.rank() < unknowns) throw std::invalid_argument("sampled too seldom to tell the sine from");
  const Eigen::VectorXd x = qr.solve(values);
  SineFit fit;
  fit.amplitude = std::hypot(x[0], x[1]);
  fit.phase_rad = std::atan2(x[1], x[0]);
  fit.offset = x[2];
  fit.drift_per_s = options.drift ? x[3] : 0;
  fit.residual_rms = std::sqrt((basis * x - values).squaredNorm() / static_cast<double>(samples));
  fit.samples = used.size();
  return fit;
}

FrequencyResponse frequency_response(std::span<const double> t_s, std::span<const double> input,
                                     std::span<const double> output, double omega_rad_s,
                                     const SineFitOptions& options) {
  FrequencyResponse response;
  response.omega_rad_s = omega_rad_s;
  response.input = fit_sine(t_s, input, omega_rad_s, options);
  response.output = fit_sine(t_s, output, omega_rad_s, options);
  // Rounding leaves an amplitude of about 1e-16 to an input that stands still.
  if (!(response.input.amplitude > 1e-12 * std::abs(response.input.offset))) {
    throw std::invalid_argument("the input does not move at this frequency");
  }
  response.gain_db = 20 * std::log10(response.output.amplitude / response.input.amplitude);
  const double lead_deg =
      (response.output.phase_rad - response.input.phase_rad) * 180 / std::numbers::pi - kMostLead_deg;
  response.phase_deg = lead_deg - kTurn_deg * std::ceil(lead_deg / kTurn_deg) + kMostLead_deg;
  return response;
}

void unwrap_phases(std::span<FrequencyResponse> responses) {
  for (std::size_t i = 1; i < responses.size(); ++i) {
    const double step_deg = responses[i].phase_deg - responses[i - 1].phase_deg;
    responses[i].phase_deg -= kTurn_deg * std::round(step_deg / kTurn_deg);
  }
}

std::optional<double> break_frequency(std::span<const GainPoint> points, double level_db) {
  std::vector<GainPoint> sorted;
  for (const GainPoint& point : points) {
    if (!std::isnan(point.gain_db)) sorted.push_back(point);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const GainPoint& a, const GainPoint& b) { return a.omega_rad_s < b.omega_rad_s; });
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const GainPoint& before = sorted[i - 1];
    const GainPoint& after = sorted[i];
    if (before.gain_db < level_db || after.gain_db >= level_db) continue;
    const double share = (before.gain_db - level_db) / (before.gain_db - after.gain_db);
    return before.omega_rad_s * std::pow(after.omega_rad_s / before.omega_rad_s, share);
  }
  return {};
}

std::optional<double> break_frequency(std::span<const FrequencyResponse> responses, double level_db) {
  std::vector<GainPoint> points;
  for (const FrequencyResponse& response : responses) {
    points.push_back({response.omega_rad_s, response.gain_db});
  }
  return break_frequency(points, level_db);
}

}  // namespace vergence::tools
