#include "tools/accuracy/confidence_fit.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace vergence::accuracy {
namespace {

constexpr int kSize = static_cast<int>(kPhotoFeatures);
using Vector = Eigen::Matrix<double, kSize, 1>;
using Matrix = Eigen::Matrix<double, kSize, kSize>;

constexpr int kMostSteps = 50;
constexpr double kSmallestStep = 1e-9;
constexpr double kLeastVariance = 1e-9;  // of an outcome, lest the equations become singular

}  // namespace

PhotoFeatures fit_confidence(const std::vector<JudgedPose>& poses, double ridge) {
  Vector weight = Vector::Zero();
  Vector penalty = Vector::Constant(ridge);
  penalty[0] = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix H = Matrix(penalty.asDiagonal()) + kLeastVariance * Matrix::Identity();
    Vector g = -penalty.cwiseProduct(weight);
    for (const JudgedPose& pose : poses) {
      const Eigen::Map<const Vector> x(pose.feature.data());
      const double p = 1 / (1 + std::exp(-weight.dot(x)));
      g += pose.counts * ((pose.right ? 1 : 0) - p) * x;
      H += pose.counts * (p * (1 - p) + kLeastVariance) * x * x.transpose();
    }
    const Vector change = H.ldlt().solve(g);
    weight += change;
    if (change.norm() < kSmallestStep) break;
  }
  PhotoFeatures result{};
  Eigen::Map<Vector>(result.data()) = weight;
  return result;
}

}  // namespace vergence::accuracy
