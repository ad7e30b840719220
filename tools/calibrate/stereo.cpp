#include "tools/calibrate/stereo.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tools/calibrate/board_pose.hpp"
#include "tools/calibrate/view_quality.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;

constexpr double kDegree = std::numbers::pi / 180;
// A view is left out where its error is so many times that of the middle one.
constexpr double kStandsOut = 2.5;
// k3 is kept where it is so many standard deviations from zero; else it only bends the corners of the image.
constexpr double kSureOfK3 = 3;
constexpr double kEnoughCoverage = 0.7;
constexpr double kWeakFocalLength = 0.005;  // standard deviation over length
constexpr double kNoFocalLength = 0.05;

double view_rms_px(const StereoFit& fit, std::size_t view, const Board& board, const CornerPair& corners) {
  const double left = reprojection_rms_px(fit.cameras[0], fit.T_CL_B[view], board, corners[0]);
  const double right = reprojection_rms_px(fit.cameras[1], fit.T_CR_CL * fit.T_CL_B[view], board, corners[1]);
  return std::sqrt(0.5 * (left * left + right * right));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Indices of the views that are used, and their fit.
struct Selection {
  std::vector<std::size_t> used;
  StereoFit fit;
};

class Calibrator {
 public:
  Calibrator(const std::filesystem::path& directory, const Sightings& sightings, const Board& board,
             const StereoOptions& options)
      : directory_(directory), sightings_(sightings), board_(board), options_(options) {}

  // Fits, leaves out the worst view while it stands out, and fits again.
  [[nodiscard]] Selection select() const {
    Selection selection;
    for (std::size_t i = 0; i < sightings_.seen.size(); ++i) selection.used.push_back(i);
    require_enough(selection);
    try {
      selection.fit = start_stereo(corners_of(selection), board_, sightings_.width_px, sightings_.height_px);
      while (true) {
        fit_stereo(corners_of(selection), board_, selection.fit);
        if (!leave_out_worst(selection)) break;
        require_enough(selection);
      }
      drop_unsure_k3(selection);
    } catch (const std::runtime_error& error) {
      if (dynamic_cast<const InputError*>(&error) != nullptr) throw;
      throw undetermined(error.what());
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const double fx = selection.fit.cameras[side].fx_px;
      const double sigma = std::sqrt(selection.fit.covariance(static_cast<Eigen::Index>(side) * kIntrinsics,
                                                              static_cast<Eigen::Index>(side) * kIntrinsics));
      if (!(fx > 0) || !(sigma < kNoFocalLength * fx))
        throw undetermined("the views do not tell the focal length");
    }
    return selection;
  }

  [[nodiscard]] std::vector<CornerPair> corners_of(const Selection& selection) const {
    std::vector<CornerPair> views;
    for (const std::size_t i : selection.used) views.push_back(sightings_.seen[i].corners);
    return views;
  }

 private:
  [[nodiscard]] InputError undetermined(const std::string& problem) const {
    return {directory_, "views", problem,
            "tilt the board by 20 to 40 degrees about both axes, in all parts of the image"};
  }

  void require_enough(const Selection& selection) const {
    if (selection.used.size() >= kFewestViews) return;
    const std::size_t seen = sightings_.seen.size();
    std::string problem = std::to_string(selection.used.size()) + " good views, at least " +
                          std::to_string(kFewestViews) + " are needed";
    if (seen > selection.used.size()) {
      problem += "; " + std::to_string(seen - selection.used.size()) + " were left out for their error";
    }
    if (!sightings_.skipped.empty()) {
      problem += "; the board is not found in " + std::to_string(sightings_.skipped.size()) +
                 " pictures, first " + sightings_.skipped.front();
    }
    throw InputError(directory_, "views", problem,
                     "take 12 to 30 sharp pairs that show the whole board in both");
  }

  bool leave_out_worst(Selection& selection) const {
    std::vector<double> rms;
    for (std::size_t v = 0; v < selection.used.size(); ++v)
      rms.push_back(view_rms_px(selection.fit, v, board_, sightings_.seen[selection.used[v]].corners));
    const double limit = options_.max_reprojection_px.value_or(kStandsOut * median(rms));
    const auto worst = std::max_element(rms.begin(), rms.end());
    if (*worst <= limit) return false;
    const auto at = worst - rms.begin();
    selection.used.erase(selection.used.begin() + at);
    selection.fit.T_CL_B.erase(selection.fit.T_CL_B.begin() + at);
    return true;
  }

  void drop_unsure_k3(Selection& selection) const {
    bool dropped = false;
    for (std::size_t side = 0; side < 2; ++side) {
      const auto i = static_cast<Eigen::Index>(side) * kIntrinsics + kIntrinsics - 1;
      const double k3 = selection.fit.cameras[side].distortion[4];
      if (std::abs(k3) >= kSureOfK3 * std::sqrt(selection.fit.covariance(i, i))) continue;
      selection.fit.with_k3[side] = false;
      dropped = true;
    }
    if (dropped) fit_stereo(corners_of(selection), board_, selection.fit);
  }

  const std::filesystem::path& directory_;
  const Sightings& sightings_;
  const Board& board_;
  const StereoOptions& options_;
};

StereoView describe_view(const StereoFit& fit, const Transform& T_CL_B, bool used, const Board& board,
                         const Sighting& sighting) {
  StereoView view;
  view.number = sighting.pair.number;
  view.used = used;
  view.T_CL_B = T_CL_B;
  view.rms_px = {reprojection_rms_px(fit.cameras[0], T_CL_B, board, sighting.corners[0]),
                 reprojection_rms_px(fit.cameras[1], fit.T_CR_CL * T_CL_B, board, sighting.corners[1])};
  view.epipolar_rms_px = epipolar_error(fit.cameras, fit.T_CR_CL, {sighting.corners}).rms_px;
  view.tilt_deg = tilt_deg(T_CL_B);
  view.distance_mm = (T_CL_B * board.centre_mm()).norm();
  return view;
}

std::string format_percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100 * share))) + " %";
}

void warn_of_weak_cameras(StereoCalibration& result) {
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string name = kSides[side];
    if (result.coverage[side] < kEnoughCoverage) {
      result.warnings.push_back(name + ": corners in only " + format_percent(result.coverage[side]) +
                                " of the image's cells; hold the board into its corners and along its edges");
    }
    const CameraModel& camera = side == 0 ? result.rig.left : result.rig.right;
    if (result.sigma[side][0] > kWeakFocalLength * camera.fx_px) {
      result.warnings.push_back(name + ": the focal length is uncertain by " +
                                std::to_string(result.sigma[side][0]) +
                                " px; tilt the board more, and nearer to the camera");
    }
  }
}

}  // namespace

void put_hand_midway(const Transform& T_CR_CL, StereoRig& rig) {
  const Transform T_CL_CR = T_CR_CL.inverse();
  const Vector3 x = T_CL_CR.t_mm.normalized();
  const Vector3 forward = Vector3::UnitZ() + T_CL_CR.R.col(2);
  const Vector3 z = (forward - forward.dot(x) * x).normalized();
  Transform T_CL_H;
  T_CL_H.R << x, z.cross(x), z;
  T_CL_H.t_mm = 0.5 * T_CL_CR.t_mm;
  rig.left.T_H_C = T_CL_H.inverse();
  rig.right.T_H_C = rig.left.T_H_C * T_CL_CR;
}

StereoCalibration calibrate_stereo(const std::filesystem::path& directory, const Sightings& sightings,
                                   const Board& board, const StereoOptions& options) {
  const Calibrator calibrator(directory, sightings, board, options);
  const Selection selection = calibrator.select();
  const StereoFit& fit = selection.fit;

  StereoCalibration result;
  result.T_CR_CL = fit.T_CR_CL;
  result.rig = {fit.cameras[0], fit.cameras[1]};
  if (fit.T_CR_CL.inverse().t_mm.x() <= 0) {
    throw InputError(directory, "left", "the right camera stands to the left of the left one",
                     "swap the folders left and right, or mount the cameras upright");
  }
  put_hand_midway(fit.T_CR_CL, result.rig);
  result.baseline_mm = fit.T_CR_CL.t_mm.norm();
  const Vector3 along = fit.T_CR_CL.R.transpose() * fit.T_CR_CL.t_mm.normalized();
  const Matrix3 of_translation = fit.covariance.block<3, 3>(2 * kIntrinsics, 2 * kIntrinsics);
  result.baseline_sigma_mm = std::sqrt(along.dot(of_translation * along));
  result.turn_deg = vector_from_rotation(fit.T_CR_CL.R).norm() / kDegree;
  for (std::size_t side = 0; side < 2; ++side) {
    result.sigma[side] = fit.covariance.diagonal()
                             .segment<kIntrinsics>(static_cast<Eigen::Index>(side) * kIntrinsics)
                             .cwiseMax(0)
                             .cwiseSqrt();
  }

  const std::vector<CornerPair> used_corners = calibrator.corners_of(selection);
  result.epipolar = epipolar_error(fit.cameras, fit.T_CR_CL, used_corners);
  for (std::size_t i = 0, v = 0; i < sightings.seen.size(); ++i) {
    const Sighting& sighting = sightings.seen[i];
    const bool used = v < selection.used.size() && selection.used[v] == i;
    const Transform T_CL_B =
        used ? fit.T_CL_B[v++] : board_in_camera(fit.cameras[0], board, sighting.corners[0]);
    result.views.push_back(describe_view(fit, T_CL_B, used, board, sighting));
  }
  std::vector<ViewOfBoard> used_views;
  for (std::size_t side = 0; side < 2; ++side) {
    std::vector<const Corners*> corners;
    double squares = 0;
    for (std::size_t v = 0; v < selection.used.size(); ++v) {
      const Sighting& sighting = sightings.seen[selection.used[v]];
      const StereoView& view = result.views[selection.used[v]];
      corners.push_back(&sighting.corners[side]);
      squares += view.rms_px[side] * view.rms_px[side];
      if (side == 0) used_views.push_back({view.number, view.T_CL_B, &sighting.corners[0]});
    }
    result.rms_px[side] = std::sqrt(squares / static_cast<double>(selection.used.size()));
    result.coverage[side] = image_coverage(corners, sightings.width_px, sightings.height_px);
  }
  result.warnings = judge_views(used_views, sightings.width_px);
  warn_of_weak_cameras(result);
  return result;
}

}  // namespace vergence::calibrate
