// The zero set of a field as triangles.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "algo/pose.hpp"

namespace vergence::render {

struct Surface {
  std::vector<Vector3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Negative inside.
struct Field {
  std::function<double(const Vector3&)> at;
  // Until it is said again, points are asked for within so far of this one.
  std::function<void(const Vector3&, double)> come_near;
};

// Naive surface nets over a grid of `cell_mm` in the box [low, high]: one vertex in each cell whose corners
// differ in sign (Gibson 1998). Cells far from the surface are skipped by blocks, trusting that |field| is at
// least `trust` times the distance.
[[nodiscard]] Surface surface_nets(const Field& field, const Vector3& low_mm, const Vector3& high_mm,
                                   double cell_mm, double trust = 0.35);

}  // namespace vergence::render
