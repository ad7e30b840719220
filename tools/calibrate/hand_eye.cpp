#include "tools/calibrate/hand_eye.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "tools/calibrate/least_squares.hpp"
#include "tools/calibrate/opencv_types.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/calibrate/stereo_fit.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// RMS turn between views about the second axis, below which the result would be noise, or poor.
constexpr double kLeastTurn_deg = 4;
constexpr double kGoodTurn_deg = 12;
constexpr std::size_t kEnoughHandPoses = 12;

struct View {
  int number = 0;
  Transform T_W_H;
  CornerPair corners;
};

// What is fitted. With a kept pose between the cameras the right one follows the left.
struct State {
  std::array<Transform, 2> T_H_C;
  Transform T_W_B;
  std::vector<Vector6>
      hand_errors;  // one a view: increments from the T_W_H that was measured to the true one
};

// Products of a view's slopes: J by the parameters, H by the view's hand pose.
struct ViewBlocks {
  explicit ViewBlocks(Eigen::Index parameters)
      : JtJ(Eigen::MatrixXd::Zero(parameters, parameters)),
        JtH(Eigen::MatrixXd::Zero(parameters, 6)),
        Jtr(Eigen::VectorXd::Zero(parameters)) {}

  Eigen::MatrixXd JtJ;
  Eigen::Matrix<double, Eigen::Dynamic, 6> JtH;
  Matrix6 HtH = Matrix6::Zero();
  Eigen::VectorXd Jtr;
  Vector6 Htr = Vector6::Zero();
  double squares = 0;
};

class Fit {
 public:
  using Slopes = Eigen::Matrix<double, 2, Eigen::Dynamic>;  // by the parameters
  using HandSlopes = Eigen::Matrix<double, 2, 6>;           // by an increment of the view's T_W_H

  Fit(std::vector<View> views, const Board& board, const StereoRig& rig, bool keep_stereo)
      : views_(std::move(views)),
        board_(board),
        cameras_{rig.left, rig.right},
        T_CL_CR_(rig.left.T_H_C.inverse() * rig.right.T_H_C),
        keep_stereo_(keep_stereo) {}

  // Increments: of T_H_CL, of T_W_B, and of T_H_CR where it is free.
  [[nodiscard]] Eigen::Index parameters() const { return keep_stereo_ ? 12 : 18; }

  [[nodiscard]] State plus(State state, const Eigen::VectorXd& increments) const {
    state.T_H_C[0] = moved(state.T_H_C[0], increments.head<6>());
    state.T_W_B = moved(state.T_W_B, increments.segment<6>(6));
    state.T_H_C[1] =
        keep_stereo_ ? state.T_H_C[0] * T_CL_CR_ : moved(state.T_H_C[1], increments.segment<6>(12));
    return state;
  }

  // Sum of squares, infinite where a corner is not in front of a camera.
  [[nodiscard]] double evaluate(const State& state, NormalEquations* equations) const {
    double squares = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      squares +=
          visit(state, v, equations != nullptr, [&](const Vector2& r, const Slopes& J, const HandSlopes&) {
            equations->JtJ.noalias() += J.transpose() * J;
            equations->Jtr.noalias() += J.transpose() * r;
          });
    }
    return squares;
  }

  void minimise(State& state) const {
    calibrate::minimise(
        state, parameters(),
        [&](const State& s, NormalEquations* equations) { return evaluate(s, equations); },
        [&](const State& s, const Eigen::VectorXd& increments) { return plus(s, increments); });
  }

  // Every view by itself, at a state.
  [[nodiscard]] std::vector<ViewBlocks> linearise(const State& state) const {
    std::vector<ViewBlocks> blocks;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      ViewBlocks& b = blocks.emplace_back(parameters());
      b.squares = visit(state, v, true, [&](const Vector2& r, const Slopes& J, const HandSlopes& H) {
        b.JtJ.noalias() += J.transpose() * J;
        b.JtH.noalias() += J.transpose() * H;
        b.HtH.noalias() += H.transpose() * H;
        b.Jtr.noalias() += J.transpose() * r;
        b.Htr.noalias() += H.transpose() * r;
      });
    }
    return blocks;
  }

  [[nodiscard]] double rms_px(const State& state) const {
    const double count = 2.0 * static_cast<double>(views_.size() * board_.corners());
    return std::sqrt(evaluate(state, nullptr) / count);
  }

  [[nodiscard]] const std::vector<View>& views() const { return views_; }
  [[nodiscard]] const std::array<CameraModel, 2>& cameras() const { return cameras_; }
  [[nodiscard]] const Transform& T_CL_CR() const { return T_CL_CR_; }
  [[nodiscard]] const Board& board() const { return board_; }

 private:
  // Calls `each` with every corner's residual and slopes, where they are wanted. Returns the sum of squares.
  template <class Each>
  double visit(const State& state, std::size_t v, bool with_slopes, Each&& each) const {
    double squares = 0;
    const View& view = views_[v];
    const Transform T_H_W = moved(view.T_W_H, state.hand_errors[v]).inverse();
    const Transform T_CR_CL = T_CL_CR_.inverse();
    for (std::size_t side = 0; side < 2; ++side) {
      const Transform T_C_H = state.T_H_C[side].inverse();
      const bool follows = side == 1 && keep_stereo_;
      for (std::size_t i = 0; i < board_.corners(); ++i) {
        const Vector3 p_B = board_.corner_mm(i);
        const Vector3 p_H = T_H_W * (state.T_W_B * p_B);
        const Vector3 p_C = T_C_H * p_H;
        Vector2 uv;
        Eigen::Matrix<double, 2, 3> by_point;
        if (!project(cameras_[side], p_C, uv, by_point)) return kInfinity;
        const Vector2 r = uv - view.corners[side][i];
        squares += r.squaredNorm();
        if (!with_slopes) continue;
        Slopes J = Slopes::Zero(2, parameters());
        if (follows) {
          J.leftCols<6>() = by_point * T_CR_CL.R * inverse_pose_slope(T_CL_CR_ * p_C);
        } else {
          J.middleCols<6>(side == 0 ? 0 : 12) = by_point * inverse_pose_slope(p_C);
        }
        J.middleCols<6>(6) = by_point * T_C_H.R * T_H_W.R * pose_slope(state.T_W_B, p_B);
        each(r, J, by_point * T_C_H.R * inverse_pose_slope(p_H));
      }
    }
    return squares;
  }

  std::vector<View> views_;
  const Board& board_;
  std::array<CameraModel, 2> cameras_;
  Transform T_CL_CR_;
  bool keep_stereo_;
};

// How large the errors are: of the corners, and of the hand poses, variances an axis.
struct Noise {
  double corner_px2 = 0;
  double hand_mm2 = 0;
  double hand_rad2 = 0;
};

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
  Noise noise;  // with the hand's part as these errors have it
};

// Best increments and hand errors under `noise`, and what that says of the noise of the hand. Nothing where
// the views do not determine the parameters.
std::optional<Step> solve(const std::vector<ViewBlocks>& blocks, const std::vector<Vector6>& hand_errors,
                          const Noise& noise) {
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

struct Refined {
  State state;
  Eigen::MatrixXd covariance;
  Noise noise;
};

// From the fit that trusts the hand to the one that gives each view's hand pose an error, of a size that is
// found as well (expectation and maximisation). An arm errs by more pixels than corners do: whoever trusts it
// makes the cameras' orientation pay for its position.
std::optional<Refined> allow_hand_errors(const Fit& fit, const State& start) {
  constexpr int kLinearisations = 5;
  constexpr int kMostRounds = 400;
  constexpr double kSettled = 1e-4;
  constexpr double kLeast_mm2 = 1e-10;
  constexpr double kLeast_rad2 = 1e-16;
  Refined result{start, {}, {0, 1, 1e-4}};  // 1 mm and half a degree, to begin with
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

// The board's pose in one camera, by its own picture alone.
Transform board_in_camera(const CameraModel& camera, const Board& board, const Corners& corners) {
  cv::Mat rotation;
  cv::Mat translation;
  cv::solvePnP(board_points(board), image_points(corners), camera_matrix(camera), distortion_of(camera),
               rotation, translation);
  return transform_of(rotation, translation);
}

// The board's pose in the left camera, by both pictures.
Transform board_in_left(const std::array<CameraModel, 2>& cameras, const Transform& T_CR_CL,
                        const Board& board, const CornerPair& corners) {
  const auto evaluate = [&](const Transform& T_CL_B, NormalEquations* equations) {
    double squares = 0;
    for (std::size_t i = 0; i < board.corners(); ++i) {
      const Vector3 p_B = board.corner_mm(i);
      const Vector3 p_L = T_CL_B * p_B;
      for (std::size_t side = 0; side < 2; ++side) {
        Vector2 uv;
        Eigen::Matrix<double, 2, 3> by_point;
        if (!project(cameras[side], side == 0 ? p_L : T_CR_CL * p_L, uv, by_point)) return kInfinity;
        const Vector2 r = uv - corners[side][i];
        squares += r.squaredNorm();
        if (equations == nullptr) continue;
        if (side == 1) by_point *= T_CR_CL.R;
        const Eigen::Matrix<double, 2, 6> J = by_point * pose_slope(T_CL_B, p_B);
        equations->JtJ += J.transpose() * J;
        equations->Jtr += J.transpose() * r;
      }
    }
    return squares;
  };
  Transform T_CL_B = board_in_camera(cameras[0], board, corners[0]);
  minimise(T_CL_B, 6, evaluate, [](const Transform& T, const Eigen::VectorXd& increment) {
    return moved(T, increment.head<6>());
  });
  return T_CL_B;
}

// The mean of poses that hardly differ.
Transform mean_pose(const std::vector<Transform>& poses) {
  Vector6 mean = Vector6::Zero();
  Transform result = poses.front();
  for (int step = 0; step < 3; ++step) {
    mean.setZero();
    for (const Transform& T : poses) {
      const Transform off = result.inverse() * T;
      mean.head<3>() += off.t_mm / static_cast<double>(poses.size());
      mean.tail<3>() += vector_from_rotation(off.R) / static_cast<double>(poses.size());
    }
    result = moved(result, mean);
  }
  return result;
}

// RMS angles by which the hand turned between any two views, about the axis it turned most about, the next,
// the last.
Vector3 turns_deg(const std::vector<View>& views) {
  Matrix3 scatter = Matrix3::Zero();
  double count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      const Vector3 turn = vector_from_rotation(views[i].T_W_H.R.transpose() * views[j].T_W_H.R);
      scatter += turn * turn.transpose();
      ++count;
    }
  }
  const Vector3 values =
      Eigen::SelfAdjointEigenSolver<Matrix3>(scatter / count).eigenvalues().cwiseMax(0).cwiseSqrt() / kDegree;
  return values.reverse();
}

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

void require_turns(const std::filesystem::path& table, const Vector3& turns) {
  constexpr const char* kRemedy =
      "turn the hand by 20 to 40 degrees about at least two of its axes, in all combinations, with the board "
      "in "
      "view";
  if (turns[0] < kLeastTurn_deg)
    throw InputError(table, "e1, e2, e3", "the hand turned by only " + shown(turns[0]) + " deg RMS", kRemedy);
  if (turns[1] < kLeastTurn_deg) {
    throw InputError(table, "e1, e2, e3",
                     "the hand turned about one axis only (" + shown(turns[0]) + " deg RMS, and " +
                         shown(turns[1]) + " about any other): where the camera sits along it cannot be told",
                     kRemedy);
  }
}

InputError contradiction(const std::filesystem::path& table) {
  return {table, "", "the poses contradict the pictures",
          "are the rows those of the pictures, in mm, poses of the hand in the world, and did the board "
          "stand still?"};
}

std::vector<View> views_of(const std::filesystem::path& table, const std::map<int, Transform>& T_W_H,
                           const Sightings& sightings) {
  std::vector<View> views;
  for (const Sighting& sighting : sightings.seen) {
    const auto pose = T_W_H.find(sighting.pair.number);
    if (pose == T_W_H.end()) {
      throw InputError(table, "frame",
                       "no row for " + sighting.pair.files[0].string() + ", number " +
                           std::to_string(sighting.pair.number),
                       "one row for every pair of pictures");
    }
    views.push_back({sighting.pair.number, pose->second, sighting.corners});
  }
  if (views.size() < kFewestHandPoses) {
    throw InputError(table, "frame",
                     std::to_string(views.size()) + " pairs show the board, at least " +
                         std::to_string(kFewestHandPoses) + " are needed" +
                         (sightings.skipped.empty() ? "" : "; first without: " + sightings.skipped.front()),
                     "take 12 to 30 pairs, each with the hand at another place and turned another way");
  }
  return views;
}

// A closed form for the place of a camera. Nothing where it fails.
std::optional<Transform> closed_form(cv::HandEyeCalibrationMethod method, const std::vector<View>& views,
                                     const std::vector<Transform>& T_C_B) {
  std::array<std::vector<cv::Mat>, 4> lists;
  for (std::size_t v = 0; v < views.size(); ++v) {
    lists[0].push_back(rotation_of(views[v].T_W_H));
    lists[1].push_back(translation_of(views[v].T_W_H));
    lists[2].push_back(rotation_of(T_C_B[v]));
    lists[3].push_back(translation_of(T_C_B[v]));
  }
  try {
    cv::Mat R;
    cv::Mat t;
    cv::calibrateHandEye(lists[0], lists[1], lists[2], lists[3], R, t, method);
    Transform T = transform_of(R, t);
    if (!T.R.allFinite() || !T.t_mm.allFinite()) return {};
    T.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T.R));
    return T;
  } catch (const cv::Exception&) {
    return {};
  }
}

struct Method {
  const char* name;
  cv::HandEyeCalibrationMethod method;
};
constexpr std::array kMethods{
    Method{"Tsai", cv::CALIB_HAND_EYE_TSAI}, Method{"Park", cv::CALIB_HAND_EYE_PARK},
    Method{"Horaud", cv::CALIB_HAND_EYE_HORAUD}, Method{"Andreff", cv::CALIB_HAND_EYE_ANDREFF},
    Method{"Daniilidis", cv::CALIB_HAND_EYE_DANIILIDIS}};

// The best of the closed forms, by the error of all corners.
State start(const Fit& fit, std::vector<HandEyeMethod>& methods) {
  std::array<std::vector<Transform>, 2> T_C_B;
  for (const View& view : fit.views()) {
    for (std::size_t side = 0; side < 2; ++side)
      T_C_B[side].push_back(board_in_camera(fit.cameras()[side], fit.board(), view.corners[side]));
  }
  const std::vector<Vector6> no_errors(fit.views().size(), Vector6::Zero());
  State best{{}, {}, no_errors};
  double least = kInfinity;
  for (const Method& method : kMethods) {
    State state{{}, {}, no_errors};
    bool good = true;
    for (std::size_t side = 0; side < 2; ++side) {
      const auto T_H_C = closed_form(method.method, fit.views(), T_C_B[side]);
      good = good && T_H_C;
      if (T_H_C) state.T_H_C[side] = *T_H_C;
    }
    double rms = kInfinity;
    if (good) {
      std::vector<Transform> T_W_B;
      for (std::size_t v = 0; v < fit.views().size(); ++v)
        T_W_B.push_back(fit.views()[v].T_W_H * state.T_H_C[0] * T_C_B[0][v]);
      state.T_W_B = mean_pose(T_W_B);
      state =
          fit.plus(state, Eigen::VectorXd::Zero(fit.parameters()));  // the right camera follows, if it must
      rms = fit.rms_px(state);
    }
    methods.push_back({method.name, rms});
    if (rms < least) {
      least = rms;
      best = state;
    }
  }
  return best;
}

void describe_views(const Fit& fit, const State& state, HandEye& result) {
  const Transform T_CR_CL = state.T_H_C[1].inverse() * state.T_H_C[0];
  const Vector3 centre = state.T_W_B * fit.board().centre_mm();
  for (const View& view : fit.views()) {
    HandEyeView described;
    described.number = view.number;
    for (std::size_t side = 0; side < 2; ++side) {
      const Transform T_C_B = state.T_H_C[side].inverse() * view.T_W_H.inverse() * state.T_W_B;
      described.rms_px[side] =
          reprojection_rms_px(fit.cameras()[side], T_C_B, fit.board(), view.corners[side]);
      result.rms_px[side] += described.rms_px[side] * described.rms_px[side];
    }
    const Transform T_W_B =
        view.T_W_H * state.T_H_C[0] * board_in_left(fit.cameras(), T_CR_CL, fit.board(), view.corners);
    described.off_mm = (T_W_B * fit.board().centre_mm() - centre).norm();
    described.off_deg = vector_from_rotation(T_W_B.R.transpose() * state.T_W_B.R).norm() / kDegree;
    result.rms_mm += described.off_mm * described.off_mm;
    result.rms_deg += described.off_deg * described.off_deg;
    result.views.push_back(described);
  }
  const auto count = static_cast<double>(fit.views().size());
  for (double& rms : result.rms_px) rms = std::sqrt(rms / count);
  result.rms_mm = std::sqrt(result.rms_mm / count);
  result.rms_deg = std::sqrt(result.rms_deg / count);
}

void add_warnings(const Transform& T_CL_CR_before, HandEye& result) {
  if (result.views.size() < kEnoughHandPoses) {
    result.warnings.push_back("only " + std::to_string(result.views.size()) + " views; take " +
                              std::to_string(kEnoughHandPoses) + " to 30");
  }
  if (result.turn_deg < kGoodTurn_deg) {
    result.warnings.push_back("about its second axis the hand turned by only " + shown(result.turn_deg) +
                              " deg RMS; 20 and more are better");
  }
  const auto middle = [&](double HandEyeView::*value) {
    std::vector<double> values;
    for (const HandEyeView& view : result.views) values.push_back(view.*value);
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  const double middle_mm = middle(&HandEyeView::off_mm);
  const double middle_deg = middle(&HandEyeView::off_deg);
  for (const HandEyeView& view : result.views) {
    // A view that stands out by so much was taken before the hand stood still, or has another picture's row.
    constexpr double kStandsOut = 3;
    if (view.off_mm > kStandsOut * middle_mm || view.off_deg > kStandsOut * middle_deg) {
      result.warnings.push_back("view " + std::to_string(view.number) +
                                " stands out: did the hand stand still, is it the right row of hand.csv?");
    }
  }
  const Transform moved =
      T_CL_CR_before.inverse() * (result.rig.left.T_H_C.inverse() * result.rig.right.T_H_C);
  result.moved_mm = moved.t_mm.norm();
  result.moved_deg = vector_from_rotation(moved.R).norm() / kDegree;
  constexpr double kSame_mm = 1;
  constexpr double kSame_deg = 0.2;
  if (result.moved_mm > kSame_mm || result.moved_deg > kSame_deg) {
    result.warnings.emplace_back(
        "the pose between the cameras is not that of the rig any more; calibrate stereo again, with the eyes "
        "at zero");
  }
}

}  // namespace

HandEye calibrate_hand_eye(const std::filesystem::path& table, const std::map<int, Transform>& T_W_H,
                           const Sightings& sightings, const Board& board, const StereoRig& rig,
                           const HandEyeOptions& options) {
  std::vector<View> views = views_of(table, T_W_H, sightings);
  const Vector3 turns = turns_deg(views);
  require_turns(table, turns);
  const Fit fit(std::move(views), board, rig, options.keep_stereo);

  HandEye result;
  result.turn_deg = turns[1];
  State state = start(fit, result.methods);
  fit.minimise(state);
  const auto refined = allow_hand_errors(fit, state);
  if (!refined) throw contradiction(table);
  state = refined->state;
  result.rig = rig;
  result.rig.left.T_H_C = state.T_H_C[0];
  result.rig.right.T_H_C = state.T_H_C[1];
  result.T_W_B = state.T_W_B;
  result.hand_mm = std::sqrt(refined->noise.hand_mm2);
  result.hand_deg = std::sqrt(refined->noise.hand_rad2) / kDegree;
  result.covariance[0] = refined->covariance.topLeftCorner<6, 6>();
  if (options.keep_stereo) {
    // An increment of the left camera, seen in the right one's frame.
    const Transform T_CR_CL = fit.T_CL_CR().inverse();
    Matrix6 carried = Matrix6::Zero();
    carried.topLeftCorner<3, 3>() = T_CR_CL.R;
    carried.bottomRightCorner<3, 3>() = T_CR_CL.R;
    carried.topRightCorner<3, 3>() = -T_CR_CL.R * cross_matrix(fit.T_CL_CR().t_mm);
    result.covariance[1] = carried * result.covariance[0] * carried.transpose();
  } else {
    result.covariance[1] = refined->covariance.bottomRightCorner<6, 6>();
  }
  describe_views(fit, state, result);
  constexpr double kNonsense_mm = 20;
  constexpr double kNonsense_deg = 3;
  if (!(result.rms_mm < kNonsense_mm) || !(result.rms_deg < kNonsense_deg)) throw contradiction(table);
  add_warnings(fit.T_CL_CR(), result);
  return result;
}

}  // namespace vergence::calibrate
