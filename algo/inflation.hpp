// What a solid is like, going by its silhouette alone: inflated, deepest in the middle and round at its edge,
// as most animals and fruits are. The flat model of a thick solid fits best at wrong tilts and depths; its
// inflated silhouette fits best near the true pose.
//
// The surface is -sqrt(h), with h = 0 beside the silhouette and Laplace h = -4 within it: a disc becomes a
// hemisphere, a strip a tube (1.4 times as deep as it is half wide).
#pragma once

#include <array>

#include "algo/limits.hpp"

namespace vergence {

// z of each of the first `points` points at x, y; `is_target` is 1 within the silhouette and 0 beside it.
// Towards the camera is negative; the mean over the target is 0. For start-up: takes some ten milliseconds.
void inflate(int points, const std::array<double, kMaxReliefPoints>& x_mm,
             const std::array<double, kMaxReliefPoints>& y_mm,
             const std::array<double, kMaxReliefPoints>& is_target,
             std::array<double, kMaxReliefPoints>& z_mm);

}  // namespace vergence
