#include "tools/render/colour_math.hpp"

#include <algorithm>

namespace vergence::render {

Rgb from_hsv(double hue_deg, double saturation, double value) {
  const double turns = hue_deg / 360;
  const auto channel = [&](double offset) {
    const double k = 6 * (turns + offset - std::floor(turns + offset));
    const double ramp = std::clamp(std::abs(k - 3) - 1, 0.0, 1.0);
    return decode_srgb(static_cast<float>(value * (1 - saturation * (1 - ramp))));
  };
  return {channel(0), channel(2.0 / 3), channel(1.0 / 3)};
}

double root_power(double base, double exponent) {
  double result = 1;
  double root = base;
  double rest = exponent;
  if (rest >= 1) return base;
  for (int bit = 0; bit < 24; ++bit) {
    root = std::sqrt(root);
    rest *= 2;
    if (rest >= 1) {
      result *= root;
      rest -= 1;
    }
  }
  return result;
}

}  // namespace vergence::render
