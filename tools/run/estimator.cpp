#include "tools/run/estimator.hpp"

#include <chrono>

#include "tools/io/input_error.hpp"

namespace vergence::tools {

PoseError pose_error(const Pose& estimate, const Pose& truth) {
  return {estimate.position_mm - truth.position_mm, multiply_quaternion_vectors(-truth.e, estimate.e).norm()};
}

Estimator::Estimator(const Dataset& dataset, const EstimateOptions& options)
    : dataset_(dataset),
      options_(options),
      tracker_(std::make_unique<Tracker>()),
      photo_(std::make_unique<PhotoModel>()),
      marker_(std::make_unique<MarkerModel>()) {
  TrackerSettings settings = default_settings(options.method, dataset.target.kind);
  settings.seed = options.seed;
  settings.box = dataset.box;
  if (options.coding) settings.ga.coding = *options.coding;
  if (options.mutation_per_1024) settings.ga.mutation_per_1024 = *options.mutation_per_1024;
  if (options.min_saturation_permille)
    settings.hue_limits.min_saturation_permille = *options.min_saturation_permille;

  Status status = Status::kOk;
  if (dataset.target.kind == TargetKind::kMarker) {
    build_model(dataset, {}, *marker_);
    status = tracker_->configure(dataset.rig, *marker_, settings);
  } else {
    PhotoOptions photo;
    photo.points = options.photo_points;
    build_model(dataset, photo, settings.hue_limits, *photo_);
    status = tracker_->configure(dataset.rig, *photo_, settings);
  }
  if (status != Status::kOk) throw InputError(dataset.directory, "", describe(status));
}

FrameResult Estimator::run(const Frame& frame, const RgbImage& left, const RgbImage& right) {
  using Clock = std::chrono::steady_clock;
  if (options_.cold) tracker_->forget();
  FrameResult result;
  result.frame = frame.number;
  const FrameMotion motion = dataset_.motion_of(frame.number);
  result.t_s = motion.t_s;

  const auto start = Clock::now();
  const auto elapsed_ms = [start] {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  const Status status =
      tracker_->begin_frame(static_cast<std::uint64_t>(frame.number), left.view(), right.view(), motion);
  if (status != Status::kOk) throw InputError(frame.left, "", describe(status));
  if (options_.budget_ms && !options_.generations) {
    for (double spent = elapsed_ms() / *options_.budget_ms; spent < 1;
         spent = elapsed_ms() / *options_.budget_ms) {
      tracker_->evolve(spent);
    }
  } else {
    const int generations = options_.generations.value_or(tracker_->usual_generations());
    for (int g = 0; g < generations; ++g) {
      // Where both are given, the clock is a guard only.
      if (options_.budget_ms && elapsed_ms() >= *options_.budget_ms) break;
      tracker_->evolve(static_cast<double>(g) / generations);
    }
  }
  result.estimate = tracker_->end_frame();
  result.compute_ms = elapsed_ms();
  if (const auto truth = dataset_.truth.find(frame.number); truth != dataset_.truth.end()) {
    result.error = pose_error(result.estimate.pose, truth->second.T_H_M);
  }
  return result;
}

}  // namespace vergence::tools
