#include "algo/logistic.hpp"

namespace vergence {

double logistic(double x) {
  if (!(x > -40)) return 0;
  if (x > 40) return 1;
  // exp(-x) = exp(-x / 256)^256; the first term left out of the series is (40 / 256)^6 / 720, 2e-8 of 1.
  const double y = -x / 256;
  double e = 1 + y * (1 + y / 2 * (1 + y / 3 * (1 + y / 4 * (1 + y / 5))));
  for (int i = 0; i < 8; ++i) e *= e;
  return 1 / (1 + e);
}

}  // namespace vergence
