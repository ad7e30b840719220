// Sine, cosine and their inverses with + - * / and sqrt only: libm's differ in the last bit between machines,
// and results must not.
#pragma once

namespace vergence {

struct SinCos {
  double sine;
  double cosine;
};

// Of an angle in radians, |angle| <= 100; absolute error below 1e-14. NaN for any other angle.
[[nodiscard]] SinCos sin_cos(double angle_rad);

// Angle of the point (x, y) from the x axis, in [-pi, pi]; absolute error below 1e-14, and small angles keep
// their relative precision. Zeros and infinities as in IEEE 754: arc_tangent2(+-0, +0) = +-0, (+-0, -0) =
// +-pi,
// (+-inf, +inf) = +-pi/4. NaN where either is.
[[nodiscard]] double arc_tangent2(double y, double x);

// In [-pi/2, pi/2] and [0, pi]; beyond -1 and 1 that of the nearer end, so that a cosine which rounding has
// pushed past 1 has an angle. NaN for NaN.
[[nodiscard]] double arc_sine(double x);
[[nodiscard]] double arc_cosine(double x);

}  // namespace vergence
