// A data set directory in memory: geometry, target, search box, and what is known of motion and truth. The
// format is described in docs/formats.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "algo/camera_model.hpp"
#include "algo/eye_mount.hpp"
#include "algo/rm_ga.hpp"
#include "algo/target_model.hpp"
#include "algo/tracker.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/silhouette.hpp"

namespace vergence::tools {

// Which pixels of the photo are S_in.
enum class TargetArea : std::uint8_t {
  kSilhouette,  // those of the target, as far as they are known, and a rim around them
  kRectangle,   // all of the rectangle, or what a given mask marks in it: the thesis
};

struct Target {
  TargetKind kind = TargetKind::kMarker;
  std::vector<Ball> balls;        // marker
  RgbImage photo;                 // photo-model
  std::optional<GreyImage> mask;  // that the data set gives
  std::optional<Silhouette> silhouette;
  Rectangle roi;
  double distance_mm = 0;
  CameraModel camera;
  double background_hue_deg = 0;

  // View of the photo-model's source; valid as long as this lives.
  [[nodiscard]] PhotoSource source(TargetArea area = TargetArea::kSilhouette) const;
};

struct Frame {
  int number = 0;
  std::filesystem::path left;
  std::filesystem::path right;
};

struct HandMotion {
  Pose T_W_H;
  EyeAngles eyes;
};

struct Truth {
  double t_s = 0;
  Pose T_H_M;
};

struct Dataset {
  std::filesystem::path directory;
  StereoRig rig;
  Target target;
  SearchBox box;
  std::vector<Frame> frames;         // by rising number
  std::map<int, HandMotion> motion;  // empty, or one for each frame
  std::map<int, Truth> truth;        // of some frames, or none

  [[nodiscard]] double time_of(int frame) const;
  [[nodiscard]] FrameMotion motion_of(int frame) const;
};

// Everything but the images of the frames is read and checked. Throws InputError.
[[nodiscard]] Dataset read_dataset(const std::filesystem::path& directory);

[[nodiscard]] StereoRig read_rig(const std::filesystem::path& file);
[[nodiscard]] Target read_target(const std::filesystem::path& model_directory);
[[nodiscard]] SearchBox read_search_box(const std::filesystem::path& file);

// Both images of a frame; their size is that of the rig. Throws InputError.
[[nodiscard]] std::pair<RgbImage, RgbImage> read_frame(const Dataset& dataset, const Frame& frame);

// Circular mean of the hues of an image's pixels, in degrees; nothing where fewer than one in a hundred has a
// hue under `limits` or where they cancel out.
[[nodiscard]] std::optional<double> mean_hue_deg(const RgbImage& image, const HueLimits& limits = {});

// The models, or InputError naming the model file.
void build_model(const Dataset& dataset, const MarkerOptions& options, MarkerModel& model);
void build_model(const Dataset& dataset, const PhotoOptions& options, const HueLimits& limits,
                 PhotoModel& model, TargetArea area = TargetArea::kSilhouette);

}  // namespace vergence::tools
