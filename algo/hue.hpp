// Hue as one byte a pixel: the only thing the method compares [Eqs. 3.1-3.4].
//
// The circle of 360 degrees has 252 steps, so that the tolerances of the method are whole steps (20 deg = 14,
// 30 deg = 21) and red, green, blue lie at 0, 84, 168. The four codes left over say why a pixel has no hue.
#pragma once

#include <array>
#include <cstdint>

#include "algo/image.hpp"
#include "algo/limits.hpp"

namespace vergence {

inline constexpr int kHueSteps = 252;
inline constexpr std::uint8_t kHueUndefined = 252;  // saturation zero, or below the gate
inline constexpr std::uint8_t kHueDark = 253;
inline constexpr std::uint8_t kHueBright = 254;
inline constexpr std::uint8_t kHueOutside = 255;  // not a pixel of the image

// Which pixels have a hue. V = max(r,g,b), v = min(r,g,b), S = (V - v) / V. A pixel beyond several limits is
// dark before it is bright, and bright before it is undefined.
struct HueLimits {
  int dark_below = 10;              // V < dark_below: too dark
  int bright_from = 250;            // v >= bright_from: too bright (256: never)
  int min_saturation_permille = 0;  // 0..1000; 1000 S < this: undefined (S = 0 always is)
};

// Settings of the thesis: only S = 0 is undefined.
inline constexpr HueLimits kThesisHueLimits{0, 256, 0};

[[nodiscard]] constexpr bool is_hue(std::uint8_t code) {
  return code < kHueSteps;
}

// Degrees [0, 360) of a hue code < kHueSteps, and the nearest code of any angle in degrees.
[[nodiscard]] double hue_degrees(std::uint8_t code);
[[nodiscard]] std::uint8_t hue_code_from_degrees(double degrees);

// Steps, floored, that a tolerance in degrees covers (at least 0, at most half the circle).
[[nodiscard]] int hue_tolerance_steps(double degrees);

// Circular distance of two hue codes in steps, 0..126. Codes without hue are farther than any tolerance
// (255).
[[nodiscard]] constexpr int hue_distance(std::uint8_t a, std::uint8_t b) {
  if (!is_hue(a) || !is_hue(b)) return 255;
  const int d = a > b ? a - b : b - a;
  return d < kHueSteps - d ? d : kHueSteps - d;
}

// Hue code of an 8-bit RGB pixel: the exact hue rounded to the nearest step (error <= 180/252 deg), and
// halfway between two steps to the one after it on the circle. At V = r = g the sector is red's.
[[nodiscard]] std::uint8_t hue_code_rgb(int r, int g, int b, const HueLimits& limits);

// One byte a pixel, rows packed (stride = width). The bytes after the last pixel are kHueOutside: samples
// that fall beside the image are pointed there, so that no sample needs a branch.
inline constexpr int kHuePadding = 64;
struct HuePlane {
  int width_px = 0;
  int height_px = 0;
  alignas(64) std::array<std::uint8_t, kMaxImagePixels + kHuePadding> code{};

  [[nodiscard]] int outside_index() const { return width_px * height_px; }
};

}  // namespace vergence
