// Random numbers for tests: small, and the same on every machine, unlike the standard library's
// distributions.
#pragma once

#include <cstdint>

namespace vergence::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  // Over some doublings up and down.
  double about(double middle, int doublings) {
    double x = middle * between(1, 2);
    for (int i = below(doublings + 1); i > 0; --i) x *= 2;
    for (int i = below(2 * doublings + 1); i > 0; --i) x /= 2;
    return x;
  }

 private:
  std::uint64_t state_;
};

}  // namespace vergence::testing
