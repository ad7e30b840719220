#include "algo/hue.hpp"

namespace vergence {
namespace {

// Largest integer <= value, without libm.
double floor_of(double value) {
  const auto truncated = static_cast<double>(static_cast<long long>(value));
  return truncated > value ? truncated - 1 : truncated;
}

}  // namespace

double hue_degrees(std::uint8_t code) {
  return code * 360.0 / kHueSteps;
}

std::uint8_t hue_code_from_degrees(double degrees) {
  const double turns = degrees / 360.0;
  if (!(turns > -1e15 && turns < 1e15)) return kHueUndefined;  // NaN, infinite or absurd
  const double share = turns - floor_of(turns);                // [0, 1]
  const int step = static_cast<int>(share * kHueSteps + 0.5);
  return static_cast<std::uint8_t>(step >= kHueSteps ? step - kHueSteps : step);
}

int hue_tolerance_steps(double degrees) {
  // A tolerance that is a whole number of steps must not lose one to rounding.
  const double steps = degrees * kHueSteps / 360.0 + 1e-9;
  constexpr int kHalfCircle = kHueSteps / 2;
  if (!(steps > 0)) return 0;
  return steps < kHalfCircle ? static_cast<int>(steps) : kHalfCircle;
}

std::uint8_t hue_code_rgb(int r, int g, int b, const HueLimits& limits) {
  const int larger = r > g ? r : g;
  const int smaller = r < g ? r : g;
  const int V = larger > b ? larger : b;
  const int v = smaller < b ? smaller : b;
  const int C = V - v;
  if (V < limits.dark_below) return kHueDark;
  if (v >= limits.bright_from) return kHueBright;
  if (C == 0 || 1000 * C < limits.min_saturation_permille * V) return kHueUndefined;
  // Sixths of the circle have 42 steps: 60 deg (x - y) / C is 42 (x - y) / C steps, rounded half up. The
  // whole circle is added before dividing, so that integer division rounds down.
  const int sector = V == r ? 0 : (V == g ? 84 : 168);
  const int difference = V == r ? g - b : (V == g ? b - r : r - g);
  const int step = (84 * difference + C + 2 * C * kHueSteps) / (2 * C) + sector;
  return static_cast<std::uint8_t>(step % kHueSteps);
}

}  // namespace vergence
