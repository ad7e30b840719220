// Directions of some rays, coordinate by coordinate: work on them goes side by side.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "algo/pose.hpp"

namespace vergence::render {

struct Rays {
  static constexpr std::size_t kMost = 64;  // what is made of them stays in the nearest cache

  std::size_t count = 0;
  // NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): up to `count` only
  std::array<double, kMost> x;
  std::array<double, kMost> y;
  std::array<double, kMost> z;
  // NOLINTEND(cppcoreguidelines-pro-type-member-init)

  void add(const Vector3& direction) {
    x[count] = direction[0];
    y[count] = direction[1];
    z[count] = direction[2];
    ++count;
  }
};

// R times (x, y, 1) of each; at most Rays::kMost.
[[nodiscard]] inline Rays turned(const Matrix3& R, std::span<const Vector2> pixels) {
  Rays rays;
  rays.count = pixels.size();
  for (std::size_t i = 0; i < rays.count; ++i) {
    const double x = pixels[i][0];
    const double y = pixels[i][1];
    // Added up as Eigen does it: every bit of a picture depends on it.
    rays.x[i] = R(0, 0) * x + (R(0, 1) * y + R(0, 2));
    rays.y[i] = R(1, 0) * x + (R(1, 1) * y + R(1, 2));
    rays.z[i] = R(2, 0) * x + (R(2, 1) * y + R(2, 2));
  }
  return rays;
}

}  // namespace vergence::render
