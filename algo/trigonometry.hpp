// Sine and cosine with + - * only: libm's differ in the last bit between machines, and results must not.
#pragma once

namespace vergence {

struct SinCos {
  double sine;
  double cosine;
};

// Of an angle in radians, |angle| <= 100; absolute error below 1e-14.
[[nodiscard]] SinCos sin_cos(double angle_rad);

}  // namespace vergence
