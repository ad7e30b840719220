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

double arc_tangent2(double y, double x) {
  constexpr double kPi = 3.141592653589793;
  constexpr double kArcTangentOfEighths[] = {0.0,
                                             0.12435499454676144,
                                             0.24497866312686414,
                                             0.35877067027057225,
                                             0.4636476090008061,
                                             0.5585993153435624,
                                             0.6435011087932844,
                                             0.7188299996216245,
                                             0.7853981633974483};
  const double across = y < 0 ? -y : y;
  const double along = x < 0 ? -x : x;
  const bool steep = across > along;
  const double large = steep ? across : along;
  if (!(large > 0)) return 0;
  const double t = (steep ? along : across) / large;

  // From the nearest eighth, atan(t) = atan(c) + atan((t - c) / (1 + t c)): at most 1/16 is left, and the
  // first term of the series left out is below 1e-18.
  const int eighth = static_cast<int>(t * 8 + 0.5);
  const double c = eighth / 8.0;
  const double r = (t - c) / (1 + t * c);
  const double q = r * r;
  double s = 1.0 / 13;
  for (int k = 11; k > 0; k -= 2) s = 1.0 / k - q * s;
  double angle = kArcTangentOfEighths[eighth] + r * s;

  if (steep) angle = kPi / 2 - angle;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace vergence
