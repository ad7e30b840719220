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

void Relief::set_depths(const Points& z_mm, double share, PhotoModel& model) const {
  std::array<Vector2, kMaxReliefPoints> slopes;
  for (int i = 0; i < points_; ++i) slopes[at(i)] = share * slope(z_mm, i);
  for (int i = 0; i < points_; ++i) {
    const Vector3 p = point(i, share * z_mm[at(i)]);
    model.x_mm[at(i)] = static_cast<float>(p[0]);
    model.y_mm[at(i)] = static_cast<float>(p[1]);
    model.z_mm[at(i)] = static_cast<float>(p[2]);
    // A learned surface is rough: it faces where its neighbourhood does.
    Vector2 smooth = slopes[at(i)];
    for (const std::int16_t j : neighbour_[at(i)]) smooth += slopes[at(j)];
    smooth /= 1 + kReliefNeighbours;
    // Towards the camera that took the photo, thus of negative z.
    const Vector3 n = Vector3(smooth[0], smooth[1], -1) / std::sqrt(1 + smooth.squaredNorm());
    model.normals.x[at(i)] = static_cast<float>(n[0]);
    model.normals.y[at(i)] = static_cast<float>(n[1]);
    model.normals.z[at(i)] = static_cast<float>(n[2]);
    model.normals.reach_mm[at(i)] = static_cast<float>(n.dot(p));
  }
}

void Relief::inflate_model(double share, PhotoModel& model) const {
  set_depths(inflated_mm_, share, model);
}

}  // namespace vergence
