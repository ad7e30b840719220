#include "tools/run/estimator.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

// Set aside for refinement: what it takes and a little more, but never so much that no search is left.
constexpr double kFinishReserve = 1.15;
constexpr double kLargestReserve = 0.5;  // of the budget
constexpr int kRehearsals = 3;

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

}  // namespace

const char* to_string(Stage stage) {
  switch (stage) {
    case Stage::kEvolved: return "evolved";
    case Stage::kRefined: return "refined";
    case Stage::kRelief: return "relief";
  }
  return "unknown";
}

std::optional<Stage> parse_stage(std::string_view name) {
  for (const Stage stage : {Stage::kEvolved, Stage::kRefined, Stage::kRelief}) {
    if (name == to_string(stage)) return stage;
  }
  return {};
}

PoseError pose_error(const Pose& estimate, const Pose& truth) {
  return {estimate.position_mm - truth.position_mm, multiply_quaternion_vectors(-truth.e, estimate.e).norm(),
          estimate.e - truth.e};
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
  settings.last_stage = options.last_stage;
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
    const TargetArea area =
        options.method == Method::kThesis ? TargetArea::kRectangle : TargetArea::kSilhouette;
    build_model(dataset, photo, settings.hue_limits, *photo_, area);
    status = tracker_->configure(dataset.rig, *photo_, settings);
  }
  if (status != Status::kOk) throw InputError(dataset.directory, "", describe(status));
  if (options.budget_ms) rehearse();
}

// The work of a frame does not depend on its images, so black ones tell how long refinement takes.
void Estimator::rehearse() {
  const EstimateOptions wanted = options_;
  options_.budget_ms.reset();
  options_.generations = 0;
  const RgbImage left(dataset_.rig.left.width_px, dataset_.rig.left.height_px);
  const RgbImage right(dataset_.rig.right.width_px, dataset_.rig.right.height_px);
  double quickest_ms = std::numeric_limits<double>::max();
  for (int i = 0; i < kRehearsals; ++i) {
    tracker_->forget();
    finish_ms_.fill(0);
    (void)run({}, left, right);
    quickest_ms = std::min(quickest_ms, finish_ms_[0]);
  }
  finish_ms_.fill(quickest_ms);
  options_ = wanted;
  tracker_->forget();
}

// Refinement leaves a covariance.
Stage Estimator::stage_of(const Estimate& estimate) const {
  if (estimate.covariance.isZero(0)) return Stage::kEvolved;
  return tracker_->relief_state() == ReliefState::kAdopted ? Stage::kRelief : Stage::kRefined;
}

FrameResult Estimator::run(const Frame& frame, const RgbImage& left, const RgbImage& right) {
  return run(frame, left, right, static_cast<std::uint64_t>(frame.number), 0);
}

FrameResult Estimator::run(const Frame& frame, const RgbImage& left, const RgbImage& right,
                           std::uint64_t draw, double later_s) {
  using Clock = std::chrono::steady_clock;
  if (options_.cold) tracker_->forget();
  FrameResult result;
  result.frame = frame.number;
  FrameMotion motion = dataset_.motion_of(frame.number);
  motion.t_s += later_s;
  result.t_s = motion.t_s;

  const double start_cpu_ms = thread_cpu_ms();
  const auto start = Clock::now();
  const auto elapsed_ms = [start] {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  const Status status = tracker_->begin_frame(draw, left.view(), right.view(), motion);
  if (status != Status::kOk) throw InputError(frame.left, "", describe(status));
  const double budget_ms = options_.budget_ms.value_or(0);
  // Whether a frame follows or searches may change while it evolves, and with it what is left to do at its
  // end.
  const auto evolve_until_ms = [&] {
    const double finish_ms = finish_ms_[tracker_->is_following() ? 1 : 0];
    return budget_ms - std::min(kFinishReserve * finish_ms, kLargestReserve * budget_ms);
  };
  if (options_.budget_ms && !options_.generations) {
    const double begun_ms = elapsed_ms();
    for (double now_ms = begun_ms; now_ms < evolve_until_ms(); now_ms = elapsed_ms()) {
      tracker_->evolve((now_ms - begun_ms) / (evolve_until_ms() - begun_ms));
    }
  } else {
    const auto wanted = [&] { return options_.generations.value_or(tracker_->usual_generations()); };
    for (int g = 0; g < wanted(); ++g) {
      // Where both are given, the clock is a guard only.
      if (options_.budget_ms && elapsed_ms() >= evolve_until_ms()) break;
      tracker_->evolve(static_cast<double>(g) / wanted());
    }
  }
  double& finish_ms = finish_ms_[tracker_->is_following() ? 1 : 0];
  const double evolved_ms = elapsed_ms();
  result.estimate = tracker_->end_frame();
  result.compute_ms = elapsed_ms();
  result.cpu_ms = thread_cpu_ms() - start_cpu_ms;
  result.stage = stage_of(result.estimate);
  if (dataset_.target.kind == TargetKind::kPhoto && options_.method == Method::kVergence) {
    result.evidence = tracker_->photo_evidence();
  }
  const double took_ms = result.compute_ms - evolved_ms;
  finish_ms = finish_ms > 0 ? 0.5 * (finish_ms + took_ms) : took_ms;
  if (const auto truth = dataset_.truth.find(frame.number); truth != dataset_.truth.end()) {
    result.error = pose_error(result.estimate.pose, truth->second.T_H_M);
  }
  return result;
}

}  // namespace vergence::tools
