#include "algo/trigonometry.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace vergence {
namespace {

// Of t in [0, 1]: atan t = atan c + atan((t - c) / (1 + c t)), c the nearest eighth, then Taylor.
double arc_tangent_of_ratio(double t) {
  constexpr double kOfEighths[] = {0.0,
                                   0.12435499454676144,
                                   0.24497866312686414,
                                   0.35877067027057225,
                                   0.4636476090008061,
                                   0.5585993153435624,
                                   0.6435011087932844,
                                   0.7188299996216245,
                                   0.7853981633974483};
  const int k = static_cast<int>(t * 8 + 0.5);
  const double c = k / 8.0;
  const double x = (t - c) / (1 + c * t);  // |x| <= 1/16
  // The first term left out is x^15 / 15, below 1e-19.
  const double q = x * x;
  double series = 1.0 / 13;
  for (int n = 11; n > 0; n -= 2) series = 1.0 / n - q * series;
  return kOfEighths[k] + x * series;
}

// sqrt(1 - x^2) without loss near 1, for |x| <= 1.
double other_side(double x) {
  return std::sqrt((1 - x) * (1 + x));
}

}  // namespace

SinCos sin_cos(double angle_rad) {
  if (!(angle_rad >= -100 && angle_rad <= 100)) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    return {kNaN, kNaN};
  }
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
  if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
  const double ay = std::fabs(y);
  const double ax = std::fabs(x);
  const bool steep = ay > ax;
  const double small = steep ? ax : ay;
  const double large = steep ? ay : ax;
  double ratio = 0;  // where both are zero
  if (std::isinf(small)) {
    ratio = 1;
  } else if (large > 0) {
    ratio = small / large;
  }
  double angle = arc_tangent_of_ratio(ratio);
  if (steep) angle = std::numbers::pi / 2 - angle;
  if (std::signbit(x)) angle = std::numbers::pi - angle;
  return std::copysign(angle, y);
}

double arc_sine(double x) {
  if (x >= 1) return std::numbers::pi / 2;
  if (x <= -1) return -std::numbers::pi / 2;
  return arc_tangent2(x, other_side(x));
}

double arc_cosine(double x) {
  if (x >= 1) return 0;
  if (x <= -1) return std::numbers::pi;
  return arc_tangent2(other_side(x), x);
}

}  // namespace vergence
