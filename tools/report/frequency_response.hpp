// Gain and phase of a loop from what it was told and what it did, at one frequency at a time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace vergence::tools {

struct SineFitOptions {
  double settle_s = 0;  // left out from the first sample on: the transient is no part of the answer
  bool drift = false;   // fit a straight line beside the sine, instead of a constant
};

// y = amplitude * sin(omega t + phase) + offset + drift * (t - middle of the fitted window)
struct SineFit {
  double amplitude = 0;  // in y's unit, as are offset and residual
  double phase_rad = 0;  // (-pi, pi]
  double offset = 0;
  double drift_per_s = 0;
  double residual_rms = 0;
  std::size_t samples = 0;
};

// Least squares over as many whole periods as there are after settling; samples that are not finite are left
// out. Throws std::invalid_argument: lengths differ, time does not increase, omega_rad_s not positive, less
// than a whole period, or samples from which the sine cannot be told.
[[nodiscard]] SineFit fit_sine(std::span<const double> t_s, std::span<const double> y, double omega_rad_s,
                               const SineFitOptions& options = {});

struct FrequencyResponse {
  double omega_rad_s = 0;
  double gain_db = 0;
  // Of the output against the input, in (-330, 30]: what lags is negative, and a small lead, of a lively loop
  // or of noise, is not taken for a lag of nearly a turn.
  double phase_deg = 0;
  SineFit input;
  SineFit output;
};

// Throws what fit_sine throws, and std::invalid_argument where the input does not move.
[[nodiscard]] FrequencyResponse frequency_response(std::span<const double> t_s, std::span<const double> input,
                                                   std::span<const double> output, double omega_rad_s,
                                                   const SineFitOptions& options = {});

// Adds whole turns so that no phase is more than half a turn from the one before, in the order given.
void unwrap_phases(std::span<FrequencyResponse> responses);

struct GainPoint {
  double omega_rad_s = 0;
  double gain_db = 0;
};

// Where gain first falls through the level with rising frequency: linear in dB over the logarithm of
// frequency between two points, in rad/s. Points in any order. None where it does not, be it that it starts
// below.
[[nodiscard]] std::optional<double> break_frequency(std::span<const GainPoint> points, double level_db = -3);
[[nodiscard]] std::optional<double> break_frequency(std::span<const FrequencyResponse> responses,
                                                    double level_db = -3);

}  // namespace vergence::tools
