#include "tools/calibrate/hand_errors.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/calibrate/least_squares.hpp"

namespace vergence::calibrate {
namespace {

// Corner errors scatter within a view; what a view's corners share belongs to its hand pose.
double corner_variance_px2(const std::vector<ViewBlocks>& blocks, const Board& board) {
  constexpr double kLeast_px2 = 1e-6;  // exact corners too must leave the equations solvable
  double squares = 0;
  for (const ViewBlocks& b : blocks) squares += b.squares - b.Htr.dot(b.HtH.ldlt().solve(b.Htr));
  const double left_over = static_cast<double>(blocks.size()) *
                           (4.0 * static_cast<double>(board.corners()) - 6);  // u and v in two cameras
  return std::max(kLeast_px2, squares / left_over);
}

struct Step {
  Eigen::VectorXd increments;
  Eigen::MatrixXd covariance;
  std::vector<Vector6> hand_errors;
  HandEyeNoise noise;  // with the hand's part as these errors have it
};

// Best increments and hand errors under `noise`, and what that says of the noise of the hand. Nothing where
// the views do not determine the parameters.
std::optional<Step> solve(const std::vector<ViewBlocks>& blocks, const std::vector<Vector6>& hand_errors,
                          const HandEyeNoise& noise) {
  Vector6 weight;
  weight << Vector3::Constant(1 / noise.hand_mm2), Vector3::Constant(1 / noise.hand_rad2);
  const double corner = 1 / noise.corner_px2;
  // The hand errors are eliminated view by view.
  std::vector<Matrix6> of_hand;
  const Eigen::Index parameters = blocks.front().Jtr.size();
  Eigen::MatrixXd JtJ = Eigen::MatrixXd::Zero(parameters, parameters);
  Eigen::VectorXd Jtr = Eigen::VectorXd::Zero(parameters);
  for (std::size_t v = 0; v < blocks.size(); ++v) {
    const ViewBlocks& b = blocks[v];
    const Matrix6 information = corner * b.HtH + Matrix6(weight.asDiagonal());
    const auto inverted = inverse(information);
    if (!inverted) return {};
    of_hand.emplace_back(*inverted);
    const Vector6 gradient = corner * b.Htr + weight.cwiseProduct(hand_errors[v]);
    JtJ += corner * b.JtJ - corner * corner * b.JtH * of_hand.back() * b.JtH.transpose();
    Jtr += corner * b.Jtr - corner * b.JtH * of_hand.back() * gradient;
  }
  const auto inverted = inverse(JtJ);
  if (!inverted) return {};
  Step step{-(*inverted * Jtr), *inverted, {}, {noise.corner_px2, 0, 0}};
  for (std::size_t v = 0; v < blocks.size(); ++v) {
    const ViewBlocks& b = blocks[v];
    const Vector6 gradient = corner * b.Htr + weight.cwiseProduct(hand_errors[v]);
    const Vector6 error =
        hand_errors[v] - of_hand[v] * (gradient + corner * b.JtH.transpose() * step.increments);
    step.hand_errors.push_back(error);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> by_parameters = corner * of_hand[v] * b.JtH.transpose();
    const Matrix6 scatter =
        error * error.transpose() + of_hand[v] + by_parameters * step.covariance * by_parameters.transpose();
    const double share = 1 / (3 * static_cast<double>(blocks.size()));
    step.noise.hand_mm2 += share * scatter.diagonal().head<3>().sum();
    step.noise.hand_rad2 += share * scatter.diagonal().tail<3>().sum();
  }
  return step;
}

}  // namespace

std::optional<HandEyeSolution> allow_hand_errors(const HandEyeFit& fit, const HandEyeState& start) {
  constexpr int kLinearisations = 5;
  constexpr int kMostRounds = 400;
  constexpr double kSettled = 1e-4;
  constexpr double kLeast_mm2 = 1e-10;
  constexpr double kLeast_rad2 = 1e-16;
  HandEyeSolution result{start, {}, {0, 1, 1e-4}};  // 1 mm and half a degree, to begin with
  for (int i = 0; i < kLinearisations; ++i) {
    const std::vector<ViewBlocks> blocks = fit.linearise(result.state);
    result.noise.corner_px2 = corner_variance_px2(blocks, fit.board());
    std::optional<Step> step;
    for (int round = 0; round < kMostRounds; ++round) {
      step = solve(blocks, result.state.hand_errors, result.noise);
      if (!step) return {};
      const double change = std::max(std::abs(step->noise.hand_mm2 / result.noise.hand_mm2 - 1),
                                     std::abs(step->noise.hand_rad2 / result.noise.hand_rad2 - 1));
      result.noise.hand_mm2 = std::max(kLeast_mm2, step->noise.hand_mm2);
      result.noise.hand_rad2 = std::max(kLeast_rad2, step->noise.hand_rad2);
      if (change < kSettled) break;
    }
    result.state = fit.plus(result.state, step->increments);
    result.state.hand_errors = step->hand_errors;
    result.covariance = step->covariance;
  }
  return result;
}

}  // namespace vergence::calibrate
