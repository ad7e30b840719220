#include "tools/calibrate/hand_eye_fit.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "tools/calibrate/slopes.hpp"

namespace vergence::calibrate {

ViewBlocks::ViewBlocks(Eigen::Index parameters)
    : JtJ(Eigen::MatrixXd::Zero(parameters, parameters)),
      JtH(Eigen::MatrixXd::Zero(parameters, 6)),
      Jtr(Eigen::VectorXd::Zero(parameters)) {}

HandEyeFit::HandEyeFit(std::vector<HandView> views, const Board& board, const StereoRig& rig,
                       bool keep_stereo)
    : views_(std::move(views)),
      board_(board),
      cameras_{rig.left, rig.right},
      T_CL_CR_(rig.left.T_H_C.inverse() * rig.right.T_H_C),
      keep_stereo_(keep_stereo) {}

HandEyeState HandEyeFit::plus(HandEyeState state, const Eigen::VectorXd& increments) const {
  state.T_H_C[0] = moved(state.T_H_C[0], increments.head<6>());
  state.T_W_B = moved(state.T_W_B, increments.segment<6>(6));
  state.T_H_C[1] =
      keep_stereo_ ? state.T_H_C[0] * T_CL_CR_ : moved(state.T_H_C[1], increments.segment<6>(12));
  return state;
}

void HandEyeFit::minimise(HandEyeState& state) const {
  calibrate::minimise(
      state, parameters(),
      [&](const HandEyeState& s, NormalEquations* equations) { return evaluate(s, equations); },
      [&](const HandEyeState& s, const Eigen::VectorXd& increments) { return plus(s, increments); });
}

std::vector<ViewBlocks> HandEyeFit::linearise(const HandEyeState& state) const {
  std::vector<ViewBlocks> blocks;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    ViewBlocks& of_view = blocks.emplace_back(parameters());
    of_view.squares = add_view(state, v, &of_view);
  }
  return blocks;
}

double HandEyeFit::rms_px(const HandEyeState& state) const {
  const double count = 2.0 * static_cast<double>(views_.size() * board_.corners());
  return std::sqrt(evaluate(state, nullptr) / count);
}

double HandEyeFit::evaluate(const HandEyeState& state, NormalEquations* equations) const {
  double squares = 0;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (equations == nullptr) {
      squares += add_view(state, v, nullptr);
      continue;
    }
    ViewBlocks blocks(parameters());
    squares += add_view(state, v, &blocks);
    equations->JtJ += blocks.JtJ;
    equations->Jtr += blocks.Jtr;
  }
  return squares;
}

double HandEyeFit::add_view(const HandEyeState& state, std::size_t v, ViewBlocks* blocks) const {
  double squares = 0;
  const HandView& view = views_[v];
  const Transform T_H_W = moved(view.T_W_H, state.hand_errors[v]).inverse();
  const Matrix3 left_to_right = T_CL_CR_.R.transpose();
  for (std::size_t side = 0; side < 2; ++side) {
    const Transform T_C_H = state.T_H_C[side].inverse();
    const bool follows = side == 1 && keep_stereo_;
    for (std::size_t i = 0; i < board_.corners(); ++i) {
      const Vector3 p_B = board_.corner_mm(i);
      const Vector3 p_H = T_H_W * (state.T_W_B * p_B);
      const Vector3 p_C = T_C_H * p_H;
      Vector2 uv;
      Eigen::Matrix<double, 2, 3> by_point;
      if (!project(cameras_[side], p_C, uv, by_point)) return std::numeric_limits<double>::infinity();
      const Vector2 r = uv - view.corners[side][i];
      squares += r.squaredNorm();
      if (blocks == nullptr) continue;
      Eigen::Matrix<double, 2, Eigen::Dynamic> J = Eigen::MatrixXd::Zero(2, parameters());
      if (follows) {
        J.leftCols<6>() = by_point * left_to_right * inverse_pose_slope(T_CL_CR_ * p_C);
      } else {
        J.middleCols<6>(side == 0 ? 0 : 12) = by_point * inverse_pose_slope(p_C);
      }
      J.middleCols<6>(6) = by_point * T_C_H.R * T_H_W.R * pose_slope(state.T_W_B, p_B);
      const Eigen::Matrix<double, 2, 6> H = by_point * T_C_H.R * inverse_pose_slope(p_H);
      blocks->JtJ.noalias() += J.transpose() * J;
      blocks->JtH.noalias() += J.transpose() * H;
      blocks->HtH.noalias() += H.transpose() * H;
      blocks->Jtr.noalias() += J.transpose() * r;
      blocks->Htr.noalias() += H.transpose() * r;
    }
  }
  return squares;
}

}  // namespace vergence::calibrate
