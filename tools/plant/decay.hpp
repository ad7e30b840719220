// Exponential decay with + - * / only, so that simulated worlds are the same bits on every machine.
#pragma once

namespace vergence::plant {

// exp(-x) for x >= 0, to 1e-12 of it; exactly 1 at zero.
[[nodiscard]] constexpr double decay(double x) {
  if (x > 700) return 0;
  int halvings = 0;
  while (x > 0.25) {
    x /= 2;
    ++halvings;
  }
  // The first term left out is 0.25^12 / 12!, 1e-16.
  double e = 1;
  for (int k = 11; k >= 1; --k) e = 1 - x / k * e;
  for (; halvings > 0; --halvings) e *= e;
  return e;
}

}  // namespace vergence::plant
