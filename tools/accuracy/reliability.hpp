// Is stated confidence what it says? Of the frames with a confidence around p, a share p should be right.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "tools/accuracy/observation.hpp"

namespace vergence::accuracy {

inline constexpr std::size_t kReliabilityBins = 10;  // of [0, 1], even; 1 falls into the last

struct ReliabilityBin {
  std::size_t frames = 0;
  double mean_confidence = 0;
  double right = 0;  // share of them
};

struct Reliability {
  std::array<ReliabilityBin, kReliabilityBins> bin;
  std::size_t frames = 0;
  // Expected calibration error: mean over frames of |share right - mean confidence| of their bin.
  double expected_error = 0;
  // Mean of (confidence - right)^2 (Brier).
  double squared_error = 0;
};

[[nodiscard]] Reliability reliability(const std::vector<Observation>& seen,
                                      const std::function<bool(const Observation&)>& is_right);

}  // namespace vergence::accuracy
