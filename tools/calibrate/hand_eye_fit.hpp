// Where the cameras sit in the hand, as a function to be minimised: the errors of all corners, by T_H_C of
// both cameras, T_W_B of the board, and an error of each hand pose.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "algo/camera_model.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/least_squares.hpp"
#include "tools/calibrate/stereo_fit.hpp"

namespace vergence::calibrate {

struct HandView {
  int number = 0;
  Transform T_W_H;  // as measured
  CornerPair corners;
};

struct HandEyeState {
  std::array<Transform, 2> T_H_C;
  Transform T_W_B;
  std::vector<Vector6>
      hand_errors;  // one a view: increments from the T_W_H that was measured to the true one
};

// Products of a view's slopes and residuals: J by the parameters, H by the view's hand pose.
struct ViewBlocks {
  explicit ViewBlocks(Eigen::Index parameters);

  Eigen::MatrixXd JtJ;
  Eigen::Matrix<double, Eigen::Dynamic, 6> JtH;
  Matrix6 HtH = Matrix6::Zero();
  Eigen::VectorXd Jtr;
  Vector6 Htr = Vector6::Zero();
  double squares = 0;
};

class HandEyeFit {
 public:
  // `keep_stereo`: the right camera follows the left, at the pose between them that the rig has.
  HandEyeFit(std::vector<HandView> views, const Board& board, const StereoRig& rig, bool keep_stereo);

  // Increments: of T_H_CL, of T_W_B, and of T_H_CR where it is free.
  [[nodiscard]] Eigen::Index parameters() const { return keep_stereo_ ? 12 : 18; }
  [[nodiscard]] HandEyeState plus(HandEyeState state, const Eigen::VectorXd& increments) const;

  // Least squares with the hand errors as they are.
  void minimise(HandEyeState& state) const;
  // Every view by itself, at a state.
  [[nodiscard]] std::vector<ViewBlocks> linearise(const HandEyeState& state) const;
  [[nodiscard]] double rms_px(const HandEyeState& state) const;

  [[nodiscard]] const std::vector<HandView>& views() const { return views_; }
  [[nodiscard]] const std::array<CameraModel, 2>& cameras() const { return cameras_; }
  [[nodiscard]] const Transform& T_CL_CR() const { return T_CL_CR_; }
  [[nodiscard]] const Board& board() const { return board_; }

 private:
  [[nodiscard]] double evaluate(const HandEyeState& state, NormalEquations* equations) const;
  // Sum of squares, infinite where a corner is not in front of a camera; fills the blocks unless null.
  double add_view(const HandEyeState& state, std::size_t v, ViewBlocks* blocks) const;

  std::vector<HandView> views_;
  Board board_;
  std::array<CameraModel, 2> cameras_;
  Transform T_CL_CR_;
  bool keep_stereo_;
};

}  // namespace vergence::calibrate
