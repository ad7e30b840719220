// What a relief makes of a photo-model: where its points lie, and which way its surface faces there.
#include <Eigen/LU>
#include <cmath>

#include "algo/relief_parts.hpp"

namespace vergence {

// The slopes of the plane through a point that fits its neighbours best, least squares.
void Relief::start_slopes() {
  for (int i = 0; i < points_; ++i) {
    Eigen::Matrix2d N = 1e-6 * Eigen::Matrix2d::Identity();
    auto& slope_of = slope_of_[at(i)];
    for (unsigned k = 0; k < kReliefNeighbours; ++k) {
      const auto j = static_cast<unsigned>(neighbour_[at(i)][k]);
      slope_of[k] = {x_mm_[j] - x_mm_[at(i)], y_mm_[j] - y_mm_[at(i)]};
      N += slope_of[k] * slope_of[k].transpose();
    }
    const Eigen::Matrix2d to_slope = N.inverse();
    for (Vector2& slope : slope_of) slope = to_slope * slope;
  }
}

Vector2 Relief::slope(const Points& z_mm, int i) const {
  Vector2 slope = Vector2::Zero();
  for (unsigned k = 0; k < kReliefNeighbours; ++k) {
    const auto j = static_cast<unsigned>(neighbour_[at(i)][k]);
    slope += (z_mm[j] - z_mm[at(i)]) * slope_of_[at(i)][k];
  }
  return slope;
}

// A learned surface is rough: it faces where its neighbourhood does.
void Relief::find_slopes(const Points& z_mm, Slopes& slopes) const {
  Slopes rough;
  for (int i = 0; i < points_; ++i) rough[at(i)] = slope(z_mm, i);
  for (int i = 0; i < points_; ++i) {
    slopes[at(i)] = rough[at(i)];
    for (const std::int16_t j : neighbour_[at(i)]) slopes[at(i)] += rough[at(j)];
    slopes[at(i)] /= 1 + kReliefNeighbours;
  }
}

void Relief::set_depths(const Points& z_mm, const Slopes& slopes, double share, PhotoModel& model) const {
  for (int i = 0; i < points_; ++i) {
    const Vector3 p = point(i, share * z_mm[at(i)]);
    model.x_mm[at(i)] = static_cast<float>(p[0]);
    model.y_mm[at(i)] = static_cast<float>(p[1]);
    model.z_mm[at(i)] = static_cast<float>(p[2]);
    const Vector2 slope = share * slopes[at(i)];
    // Towards the camera that took the photo, thus of negative z.
    const Vector3 n = Vector3(slope[0], slope[1], -1) / std::sqrt(1 + slope.squaredNorm());
    model.normals.x[at(i)] = static_cast<float>(n[0]);
    model.normals.y[at(i)] = static_cast<float>(n[1]);
    model.normals.z[at(i)] = static_cast<float>(n[2]);
    model.normals.reach_mm[at(i)] = static_cast<float>(n.dot(p));
  }
}

void Relief::inflate_model(double share, PhotoModel& model) const {
  set_depths(inflated_mm_, inflated_slopes_, share, model);
}

}  // namespace vergence
