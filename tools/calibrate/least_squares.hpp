// Nonlinear least squares by Levenberg and Marquardt, over states that are more than a vector (rotations).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>

namespace vergence::calibrate {

// Of residuals r and their Jacobian J by the increments of the parameters.
struct NormalEquations {
  Eigen::MatrixXd JtJ;
  Eigen::VectorXd Jtr;

  explicit NormalEquations(Eigen::Index parameters)
      : JtJ(Eigen::MatrixXd::Zero(parameters, parameters)), Jtr(Eigen::VectorXd::Zero(parameters)) {}
};

// Scales that make the diagonal one. Parameters differ by twelve orders of magnitude (px, mm, distortion). A
// parameter that nothing depends on has zeros, and stays where it is.
[[nodiscard]] inline Eigen::VectorXd diagonal_scale(const Eigen::MatrixXd& JtJ) {
  return JtJ.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 0.0; });
}

// (J^T J)^-1, with zeros for parameters nothing depends on. Nothing where the residuals do not determine the
// others.
[[nodiscard]] inline std::optional<Eigen::MatrixXd> inverse(const Eigen::MatrixXd& JtJ) {
  constexpr double kLeastPivot = 1e-13;
  const Eigen::VectorXd scale = diagonal_scale(JtJ);
  Eigen::MatrixXd scaled = scale.asDiagonal() * JtJ * scale.asDiagonal();
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    if (scale[i] == 0) scaled(i, i) = 1;
  }
  const Eigen::LDLT<Eigen::MatrixXd> factors(scaled);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > kLeastPivot)) return {};
  const Eigen::MatrixXd inverted = factors.solve(Eigen::MatrixXd::Identity(JtJ.rows(), JtJ.cols()));
  return Eigen::MatrixXd(scale.asDiagonal() * inverted * scale.asDiagonal());
}

// Improves `state` to a minimum of the sum of squares and returns that.
// evaluate(state, NormalEquations*) -> sum of squares; infinite where there is none; fills the equations
// unless null. plus(state, increments) -> state.
template <class State, class Evaluate, class Plus>
double minimise(State& state, Eigen::Index parameters, Evaluate&& evaluate, Plus&& plus) {
  constexpr int kMostSteps = 200;
  constexpr double kLargestDamping = 1e12;
  constexpr double kLeastGain = 1e-14;  // of the sum of squares
  double damping = 1e-4;
  for (int step = 0; step < kMostSteps; ++step) {
    NormalEquations equations(parameters);
    const double squares = evaluate(state, &equations);
    if (!std::isfinite(squares)) return std::numeric_limits<double>::infinity();
    const Eigen::VectorXd scale = diagonal_scale(equations.JtJ);
    const Eigen::MatrixXd scaled = scale.asDiagonal() * equations.JtJ * scale.asDiagonal();
    const Eigen::VectorXd gradient = scale.asDiagonal() * equations.Jtr;
    double gain = 0;
    for (; damping < kLargestDamping; damping *= 10) {
      Eigen::MatrixXd damped = scaled;
      damped.diagonal().array() += damping;
      const Eigen::VectorXd increments = -(scale.asDiagonal() * damped.ldlt().solve(gradient));
      State next = plus(state, increments);
      const double next_squares = evaluate(next, nullptr);
      if (!(next_squares < squares)) continue;
      gain = squares - next_squares;
      state = std::move(next);
      damping = std::max(damping * 0.1, 1e-12);
      break;
    }
    if (!(gain > kLeastGain * squares)) return squares - gain;
  }
  return evaluate(state, nullptr);
}

}  // namespace vergence::calibrate
