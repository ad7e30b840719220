// Sine, cosine and arc tangent with + - * only: libm's differ in the last bit between machines, and results
// must not.
#pragma once

namespace vergence {

struct SinCos {
  double sine;
  double cosine;
};

// Of an angle in radians, |angle| <= 100; absolute error below 1e-14.
[[nodiscard]] SinCos sin_cos(double angle_rad);

// Angle of the point (x, y) from the x axis, in (-pi, pi]; 0 for the origin. Absolute error
// below 1e-14. x and y finite.
[[nodiscard]] double arc_tangent2(double y, double x);

}  // namespace vergence
