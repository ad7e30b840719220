#include "algo/shape_uncertainty.hpp"

#include <cmath>

namespace vergence {
namespace {

// Deviations across the model's axis, along it, of tilt and of turn about it.
struct Deviation {
  double across_mm;
  double along_mm;
  double tilt_rad;
  double turn_rad;
};

Vector6 increment(const Deviation& d) {
  Vector6 deviation;
  deviation << d.across_mm, d.across_mm, d.along_mm, d.tilt_rad, d.tilt_rad, d.turn_rad;
  return deviation;
}

}  // namespace

Vector6 shape_deviation(ShapeKnowledge knowledge, double misfit) {
  if (knowledge == ShapeKnowledge::kNone) return misfit * std::sqrt(misfit) * increment({2.5, 9, 0.2, 0.03});
  Vector6 deviation = increment({0.02, 0.3, 0.005, 0}) + misfit * misfit * increment({1.4, 5, 0.12, 0.02});
  if (knowledge == ShapeKnowledge::kYoungRelief) {
    const Vector6 young = increment({0.2, 1.1, 0.03, 0.004});
    deviation = (deviation.array().square() + young.array().square()).sqrt();
  }
  return deviation;
}

}  // namespace vergence
