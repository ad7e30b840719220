// From sightings of a board to a calibrated stereo rig, with what is known of its quality.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "algo/camera_model.hpp"
#include "tools/calibrate/sightings.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/calibrate/stereo_fit.hpp"

namespace vergence::calibrate {

struct StereoOptions {
  // Views with a larger RMS error are left out; nothing: those that stand out from the others.
  std::optional<double> max_reprojection_px;
};

struct StereoView {
  int number = 0;
  bool used = true;
  std::array<double, 2> rms_px{};  // of a view left out: by its best pose under the final cameras
  double epipolar_rms_px = 0;
  double tilt_deg = 0;     // of the board against the left image plane
  double distance_mm = 0;  // of the board's centre from the left camera
  Transform T_CL_B;
};

struct StereoCalibration {
  StereoRig rig;  // T_H_C: the hand frame midway between the cameras, x from left to right
  Transform T_CR_CL;
  std::array<Eigen::Matrix<double, kIntrinsics, 1>, 2> sigma;  // standard deviations of the intrinsics
  double baseline_mm = 0;
  double baseline_sigma_mm = 0;
  double turn_deg = 0;               // angle between the cameras' orientations
  std::array<double, 2> rms_px{};    // of the used views
  EpipolarError epipolar;            // the same
  std::array<double, 2> coverage{};  // share of the image's cells that held a corner
  std::vector<StereoView> views;     // all that were seen, by number
  std::vector<std::string> warnings;
};

inline constexpr std::size_t kFewestViews = 5;

// Throws InputError naming `directory` where there are too few good views, where they do not determine the
// cameras, and where left and right are swapped.
[[nodiscard]] StereoCalibration calibrate_stereo(const std::filesystem::path& directory,
                                                 const Sightings& sightings, const Board& board,
                                                 const StereoOptions& options);

// Both cameras in a hand frame midway between them: x from the left to the right one, z the mean of where
// they look, square to x.
void put_hand_midway(const Transform& T_CR_CL, StereoRig& rig);

}  // namespace vergence::calibrate
