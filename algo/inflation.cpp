#include "algo/inflation.hpp"

#include <cmath>
#include <cstddef>

namespace vergence {

void inflate(int points, const std::array<double, kMaxReliefPoints>& x_mm,
             const std::array<double, kMaxReliefPoints>& y_mm,
             const std::array<std::array<std::int16_t, kReliefNeighbours>, kMaxReliefPoints>& neighbour,
             const std::array<double, kMaxReliefPoints>& is_target,
             std::array<double, kMaxReliefPoints>& z_mm) {
  constexpr int kRounds = 1500;  // of Gauss-Seidel: some squares of how many points lie across a target
  const auto count = static_cast<std::size_t>(points);
  auto& h = z_mm;
  h.fill(0);
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < count; ++i) {
      // The mean of h over neighbours is h + Laplace h / 4 times their mean squared distance.
      double sum = 0;
      double squared_distances = 0;
      for (const std::int16_t j : neighbour[i]) {
        const auto k = static_cast<std::size_t>(j);
        const double dx = x_mm[k] - x_mm[i];
        const double dy = y_mm[k] - y_mm[i];
        sum += h[k];
        squared_distances += dx * dx + dy * dy;
      }
      h[i] = is_target[i] * (sum + squared_distances) / kReliefNeighbours;
    }
  }
  double sum = 0;
  double weight = 1e-9;
  for (std::size_t i = 0; i < count; ++i) {
    z_mm[i] = -std::sqrt(h[i]);
    sum += is_target[i] * z_mm[i];
    weight += is_target[i];
  }
  for (std::size_t i = 0; i < count; ++i) z_mm[i] -= sum / weight;
}

}  // namespace vergence
