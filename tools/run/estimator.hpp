// Runs the tracker over the frames of a data set, as `vergence estimate` and the accuracy study do.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "algo/tracker.hpp"
#include "tools/io/dataset.hpp"

namespace vergence::tools {

struct EstimateOptions {
  Method method = Method::kVergence;
  std::uint64_t seed = 1;
  std::optional<int> generations;   // of every frame; otherwise what the tracker finds usual
  std::optional<double> budget_ms;  // by the clock instead, refinement included: not repeatable
  bool cold = false;                // forget everything between frames
  std::optional<GeneCoding> coding;
  std::optional<int> mutation_per_1024;
  std::optional<int> min_saturation_permille;
  Stage last_stage = Stage::kRelief;  // later ones are left out, for comparison
  int photo_points = 1000;
};

// "evolved", "refined" or "relief", and back.
[[nodiscard]] const char* to_string(Stage stage);
[[nodiscard]] std::optional<Stage> parse_stage(std::string_view name);

struct PoseError {
  Vector3 position_mm;
  double e = 0;          // length of the vector part of the quaternion between the two
  Vector3 e_difference;  // component by component, as covariance has it
};

[[nodiscard]] PoseError pose_error(const Pose& estimate, const Pose& truth);

struct FrameResult {
  int frame = 0;
  double t_s = 0;
  Estimate estimate;
  Stage stage = Stage::kEvolved;          // that the pose went through last
  std::optional<PhotoEvidence> evidence;  // of a photo-model, Method::kVergence
  std::optional<PoseError> error;         // where there is truth
  double cpu_ms = 0;      // of which the processor worked on it: less, where others want it too
  double compute_ms = 0;  // from the two images in memory to the pose
};

class Estimator {
 public:
  // Throws InputError where the data set's model or geometry cannot be used.
  Estimator(const Dataset& dataset, const EstimateOptions& options);

  [[nodiscard]] FrameResult run(const Frame& frame, const RgbImage& left, const RgbImage& right);
  // As above, with the random numbers of frame `draw` and `later_s` after its time: the same pictures, looked
  // at again.
  [[nodiscard]] FrameResult run(const Frame& frame, const RgbImage& left, const RgbImage& right,
                                std::uint64_t draw, double later_s);
  [[nodiscard]] const Tracker& tracker() const { return *tracker_; }
  // What the tracker looks for: the one place to change where it learns more than was built.
  [[nodiscard]] const PhotoModel& photo_model() const { return tracker_->photo_model(); }
  [[nodiscard]] const MarkerModel& marker_model() const { return *marker_; }
  void forget() { tracker_->forget(); }
  void unlearn() { tracker_->unlearn(); }

 private:
  void rehearse();
  [[nodiscard]] Stage stage_of(const Estimate& estimate) const;

  const Dataset& dataset_;
  EstimateOptions options_;
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<PhotoModel> photo_;
  std::unique_ptr<MarkerModel> marker_;
  std::array<double, 2> finish_ms_{};  // of end_frame(), smoothed: searching, tracking
};

}  // namespace vergence::tools
