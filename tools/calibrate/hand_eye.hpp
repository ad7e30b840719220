// Where the cameras sit in the hand, from pictures of a board that stands still while the hand moves: A X = X
// B.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "algo/camera_model.hpp"
#include "tools/calibrate/sightings.hpp"

namespace vergence::calibrate {

struct HandEyeOptions {
  // The pose between the cameras stays that of the rig; only their common place in the hand is found.
  bool keep_stereo = false;
};

struct HandEyeView {
  int number = 0;
  std::array<double, 2> rms_px{};
  double off_mm = 0;   // where this view has the board's centre, minus where all together have it
  double off_deg = 0;  // the same of its orientation
};

struct HandEyeMethod {
  std::string name;
  double rms_px = 0;  // infinite where it has no solution
};

struct HandEye {
  StereoRig rig;
  Transform T_W_B;
  // Of T_H_C and its increments [mm; rad] in the camera's frame. They allow for errors that all corners of a
  // view share, as those of the arm are.
  std::array<Matrix6, 2> covariance;
  std::array<double, 2> rms_px{};
  double rms_mm = 0;  // of the views' off_mm
  double rms_deg = 0;
  double hand_mm = 0;  // errors of the hand poses themselves, a standard deviation an axis
  double hand_deg = 0;
  std::vector<HandEyeView> views;
  std::vector<HandEyeMethod> methods;  // the closed forms that were compared; the best one was refined
  double turn_deg = 0;  // RMS turn of the hand between views about the axis it turned least about, but one
  double moved_mm = 0;  // how far the pose between the cameras is from that of the rig before
  double moved_deg = 0;
  std::vector<std::string> warnings;
};

inline constexpr std::size_t kFewestHandPoses = 5;

// `T_W_H` by the pictures' numbers; `table` is the file it came from. Throws InputError where a picture has
// no pose, where there are too few, and where the hand did not turn about two axes.
[[nodiscard]] HandEye calibrate_hand_eye(const std::filesystem::path& table,
                                         const std::map<int, Transform>& T_W_H, const Sightings& sightings,
                                         const Board& board, const StereoRig& rig,
                                         const HandEyeOptions& options);

}  // namespace vergence::calibrate
