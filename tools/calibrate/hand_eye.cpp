#include "tools/calibrate/hand_eye.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "tools/calibrate/board_pose.hpp"
#include "tools/calibrate/hand_errors.hpp"
#include "tools/calibrate/hand_eye_fit.hpp"
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
Vector3 turns_deg(const std::vector<HandView>& views) {
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

std::vector<HandView> views_of(const std::filesystem::path& table, const std::map<int, Transform>& T_W_H,
                               const Sightings& sightings) {
  std::vector<HandView> views;
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
std::optional<Transform> closed_form(cv::HandEyeCalibrationMethod method, const std::vector<HandView>& views,
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
HandEyeState start(const HandEyeFit& fit, std::vector<HandEyeMethod>& methods) {
  std::array<std::vector<Transform>, 2> T_C_B;
  for (const HandView& view : fit.views()) {
    for (std::size_t side = 0; side < 2; ++side)
      T_C_B[side].push_back(board_in_camera(fit.cameras()[side], fit.board(), view.corners[side]));
  }
  const std::vector<Vector6> no_errors(fit.views().size(), Vector6::Zero());
  HandEyeState best{{}, {}, no_errors};
  double least = kInfinity;
  for (const Method& method : kMethods) {
    HandEyeState state{{}, {}, no_errors};
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

void describe_views(const HandEyeFit& fit, const HandEyeState& state, HandEye& result) {
  const Transform T_CR_CL = state.T_H_C[1].inverse() * state.T_H_C[0];
  const Vector3 centre = state.T_W_B * fit.board().centre_mm();
  for (const HandView& view : fit.views()) {
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
  std::vector<HandView> views = views_of(table, T_W_H, sightings);
  const Vector3 turns = turns_deg(views);
  require_turns(table, turns);
  const HandEyeFit fit(std::move(views), board, rig, options.keep_stereo);

  HandEye result;
  result.turn_deg = turns[1];
  HandEyeState state = start(fit, result.methods);
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