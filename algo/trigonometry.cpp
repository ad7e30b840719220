#include "algo/trigonometry.hpp"

namespace vergence {

SinCos sin_cos(double angle_rad) {
  // To [-pi/4, pi/4] by quarter turns, pi/2 taken in two parts so that little is lost [Cody and Waite].
  constexpr double kHalfPiHigh = 1.5707963267341256;  // 33 bits of pi / 2
  constexpr double kHalfPiLow = 6.077100506506192e-11;
  constexpr double kTwoOverPi = 0.6366197723675814;
  const double quarters = angle_rad * kTwoOverPi;
  const int n = static_cast<int>(quarters + (quarters < 0 ? -0.5 : 0.5));
  const double x = (angle_rad - n * kHalfPiHigh) - n * kHalfPiLow;

  // Taylor: the first terms left out are x^19 / 19! and x^18 / 18!, below 1e-17.
  const double q = x * x;
  double s = 1;
  for (int k = 17; k > 1; k -= 2) s = 1 - q / (k * (k - 1)) * s;
  s *= x;
  double c = 1;
  for (int k = 16; k > 0; k -= 2) c = 1 - q / (k * (k - 1)) * c;

  switch (n & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

}  // namespace vergence
