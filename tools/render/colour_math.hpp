// Linear light in three channels, and the way to and from 8-bit colours.
//
// Everything that reaches an image byte uses only + - * / and sqrt, so that a scene renders to the same bytes
// on every machine.
#pragma once

#include <cmath>

namespace vergence::render {

// Linear radiance or reflectance; 1 is white.
struct Rgb {
  float r = 0;
  float g = 0;
  float b = 0;

  Rgb& operator+=(const Rgb& o) {
    r += o.r;
    g += o.g;
    b += o.b;
    return *this;
  }
  friend Rgb operator+(Rgb a, const Rgb& o) { return a += o; }
  friend Rgb operator*(const Rgb& a, float s) { return {a.r * s, a.g * s, a.b * s}; }
  friend Rgb operator*(const Rgb& a, const Rgb& o) { return {a.r * o.r, a.g * o.g, a.b * o.b}; }
};

[[nodiscard]] inline Rgb mix(const Rgb& a, const Rgb& b, float t) {
  return a * (1 - t) + b * t;
}

// Luminance (BT.709).
[[nodiscard]] inline float luminance(const Rgb& c) {
  return 0.2126F * c.r + 0.7152F * c.g + 0.0722F * c.b;
}

// The sRGB curve and its inverse over [0, 1], as sums of roots and a cubic: within 0.4 grey levels of 255.
[[nodiscard]] inline float encode_srgb(float linear) {
  const float s1 = std::sqrt(linear);
  const float s2 = std::sqrt(s1);
  const float s3 = std::sqrt(s2);
  return linear <= 0.0031308F
             ? 12.92F * linear
             : 0.662002687F * s1 + 0.684122060F * s2 - 0.323583601F * s3 - 0.0225411470F * linear;
}
[[nodiscard]] inline float decode_srgb(float coded) {
  return coded <= 0.04045F ? coded / 12.92F
                           : coded * (coded * (coded * 0.305306011F + 0.682171111F) + 0.012522878F);
}

// Linear light of a colour as people name it: hue in degrees, saturation and value in [0, 1], of sRGB.
[[nodiscard]] Rgb from_hsv(double hue_deg, double saturation, double value);

// base^exponent for base > 0, exponent in [0, 1], by repeated square roots (error below 1e-6).
[[nodiscard]] double root_power(double base, double exponent);

// 0 below `low`, 1 above `high`, smooth in between.
[[nodiscard]] inline double smooth_step(double low, double high, double x) {
  const double t = (x - low) / (high - low);
  const double c = t < 0 ? 0 : t > 1 ? 1 : t;
  return c * c * (3 - 2 * c);
}

}  // namespace vergence::render
