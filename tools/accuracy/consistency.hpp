// Is stated covariance what it says? The mean of error^2 / variance should be 1 on every axis.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tools/accuracy/observation.hpp"

namespace vergence::accuracy {

struct Consistency {
  std::size_t frames = 0;              // right, tracked, with a covariance and a truth
  std::array<double, 6> ratio{};       // mean of error^2 / variance: x y z e1 e2 e3
  std::array<double, 6> within_two{};  // share of errors within two standard deviations; 0.954 if normal
  [[nodiscard]] double share_within_two() const;  // of all six together
};

[[nodiscard]] Consistency consistency(const std::vector<const Observation*>& seen);

}  // namespace vergence::accuracy
