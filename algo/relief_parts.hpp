// What the files of relief share among themselves, and nobody else.
#pragma once

#include <array>

#include "algo/relief.hpp"

namespace vergence {

inline constexpr int kReliefFirstLevel = 2;  // the first frame is learned from at quarter resolution

inline unsigned at(int i) {
  return static_cast<unsigned>(i);
}

inline double clamped(double value, double low, double high) {
  const double at_least = value > low ? value : low;  // NaN becomes low
  return at_least < high ? at_least : high;
}

// Colour of the photo at a point: luma, 2 cb, 2 cr, centred, and a zero.
[[nodiscard]] std::array<float, 4> photo_colour(const PhotoModel& model, int level, int i);

}  // namespace vergence
