#include "algo/tracker.hpp"

#include <algorithm>
#include <cmath>

#include "algo/tracker_parts.hpp"

namespace vergence {
namespace {

bool usable(const CameraModel& camera) {
  return camera.width_px >= 16 && camera.height_px >= 16 && camera.width_px <= kMaxImageWidth &&
         camera.height_px <= kMaxImageHeight && camera.fx_px > 0 && camera.fy_px > 0 &&
         std::isfinite(camera.fx_px * camera.fy_px * camera.cx_px * camera.cy_px);
}

}  // namespace

const char* to_string(TrackState state) {
  switch (state) {
    case TrackState::kSearching: return "searching";
    case TrackState::kTracking: return "tracking";
    case TrackState::kLost: return "lost";
  }
  return "unknown";
}

TrackerSettings default_settings(Method method, TargetKind kind) {
  TrackerSettings settings;
  settings.method = method;
  if (method == Method::kThesis) {
    settings.ga.coding = GeneCoding::kBinary;
    settings.ga.mutation_per_1024 = 20;
    settings.hue_limits = kThesisHueLimits;
  } else if (kind == TargetKind::kMarker) {
    settings.hue_limits.min_saturation_permille = 400;  // faintly tinted walls are no balls
  }
  return settings;
}

Status Tracker::configure(const StereoRig& rig, const MarkerModel& model, const TrackerSettings& settings) {
  if (model.balls < 1) return Status::kBadModel;
  kind_ = TargetKind::kMarker;
  marker_ = model;
  marker_hue_ = model.hue;
  return configure_common(rig, settings);
}

Status Tracker::configure(const StereoRig& rig, const PhotoModel& model, const TrackerSettings& settings) {
  if (model.inner < 16) return Status::kBadModel;
  kind_ = TargetKind::kPhoto;
  relief_aside_ = false;
  photo_ = model;
  as_photographed_ = model.colour;
  std::copy_n(model.hue.begin(), kMaxPhotoPoints, photo_hue_.begin());
  photo_background_hue_ = model.background_hue;
  rig_ = rig;
  settings_ = settings;
  build_measures();
  relief_.start(photo_);
  return configure_common(rig, settings);
}

Status Tracker::configure_common(const StereoRig& rig, const TrackerSettings& settings) {
  if (!usable(rig.left) || !usable(rig.right)) return Status::kBadCamera;
  if (settings.ga.survivors < 2 || settings.ga.survivors >= kPopulation) return Status::kBadModel;
  if (const Status status = check(settings.box); status != Status::kOk) return status;
  rig_ = rig;
  settings_ = settings;
  hue_table_.build(settings.hue_limits);
  for (int level = 0; level < kColourLevels; ++level) {
    camera_left_[at(level)] = camera_at_level(rig.left, level);
    camera_right_[at(level)] = camera_at_level(rig.right, level);
  }
  forget();
  return Status::kOk;
}

void Tracker::forget() {
  take_relief_up();
  light_.forget();
  expect_light();
  predictor_.forget();
  searches_ = 0;
  start_search();
  scout_generation_ = 0;
  following_ = false;
  rescuing_ = false;
  doubting_ = false;
  state_ = TrackState::kSearching;
}

void Tracker::unlearn() {
  take_relief_up();
  if (kind_ == TargetKind::kPhoto) relief_.give_back(photo_);
  forget();
}

std::int64_t Tracker::score(const Transform& T_H_M, Measure measure) const {
  const Transform T_CL_M = T_CL_H_ * T_H_M;
  const Transform T_CR_M = T_CR_H_ * T_H_M;
  if (measure == Measure::kVotes) {
    return kind_ == TargetKind::kMarker ? std::int64_t{marker_votes(marker_, rig_.left, hue_left_, T_CL_M)} +
                                              marker_votes(marker_, rig_.right, hue_right_, T_CR_M)
                                        : std::int64_t{photo_votes(photo_, rig_.left, hue_left_, T_CL_M)} +
                                              photo_votes(photo_, rig_.right, hue_right_, T_CR_M);
  }
  const CorrelationModel& model = measure == Measure::kSearch   ? search_model_
                                  : measure == Measure::kSettle ? settle_model_
                                                                : judge_model_;
  const unsigned level = at(model.level);
  return correlation(model, photo_, camera_left_[level], level_of(colour_left_, model.level), T_CL_M) +
         correlation(model, photo_, camera_right_[level], level_of(colour_right_, model.level), T_CR_M);
}

std::int64_t Tracker::score(const Chromosome& chromosome, Measure measure) {
  ++evaluations_;
  return score(to_transform(decode(chromosome, box_, settings_.ga.coding)), measure);
}

double Tracker::fitness_at(const Pose& pose) const {
  const std::int64_t votes = score(to_transform(pose), Measure::kVotes);
  return kind_ == TargetKind::kMarker ? marker_fitness(marker_, votes) : photo_fitness(photo_, votes);
}

Status Tracker::begin_frame(std::uint64_t frame, const ImageView& left, const ImageView& right,
                            const FrameMotion& motion) {
  const auto fits = [](const ImageView& image, const CameraModel& camera) {
    return image.width_px == camera.width_px && image.height_px == camera.height_px;
  };
  if (!fits(left, rig_.left) || !fits(right, rig_.right)) return Status::kBadImage;
  for (const Status status : {make_hue_plane(left, settings_.hue_limits, hue_table_, hue_left_),
                              make_hue_plane(right, settings_.hue_limits, hue_table_, hue_right_)}) {
    if (status != Status::kOk) return status;
  }
  if (kind_ == TargetKind::kPhoto && !is_thesis()) {
    if (const Status status = make_colour_pyramid(left, colour_left_); status != Status::kOk) return status;
    if (const Status status = make_colour_pyramid(right, colour_right_); status != Status::kOk) return status;
  }
  if (kind_ == TargetKind::kMarker && !is_thesis()) {
    if (const Status status = make_raw_colour(left, colour_left_); status != Status::kOk) return status;
    if (const Status status = make_raw_colour(right, colour_right_); status != Status::kOk) return status;
    yuv_ = left.format != PixelFormat::kRgb24;
  }
  take_relief_up();  // where the frame before was not ended
  if (kind_ == TargetKind::kPhoto && !is_thesis()) put_before_backdrop(left.format != PixelFormat::kRgb24);
  random_ = CounterRandom(settings_.seed, frame);
  motion_ = motion;
  rig_.left.T_H_C = motion.T_H_CL;
  rig_.right.T_H_C = motion.T_H_CR;
  T_CL_H_ = motion.T_H_CL.inverse();
  T_CR_H_ = motion.T_H_CR.inverse();
  generations_ = 0;
  evaluations_ = 0;
  settling_ = false;
  rescuing_ = false;
  doubting_ = false;
  following_ = state_ == TrackState::kTracking && !is_thesis();

  const GeneCoding coding = settings_.ga.coding;
  const auto score_settle = [this](const Chromosome& c) { return score(c, settle_measure()); };
  if (following_ || (is_thesis() && predictor_.known())) {
    // Motion feed-forward: the motion that takes the last estimate to the predicted one takes everybody
    // along.
    const Transform T_H_M = predictor_.predict(motion.t_s, motion.T_W_H);
    const Transform D = T_H_M * T_H_M_last_.inverse();
    const SearchBox old_box = box_;
    if (!is_thesis()) {
      const Pose centre = to_pose(T_H_M);
      for (unsigned i = 0; i < kGenes; ++i) {
        box_.centre[i] = i < 3 ? centre.position_mm[i] : centre.e[i - 3];
        box_.half_range[i] = i < 3 ? settings_.follow_mm : settings_.follow_e;
      }
    }
    for (Individual& individual : population_.individual) {
      const Transform T = D * to_transform(decode(individual.chromosome, old_box, coding));
      individual.chromosome = encode(to_pose(T), box_, coding);
    }
    if (!is_thesis()) population_.individual[0].chromosome = encode(to_pose(T_H_M), box_, coding);
    evaluate_population(population_, score_settle);
    if (following_) {
      doubting_ = is_doubtful();
      if (doubting_) {
        start_rescue();
      } else {
        scout();
      }
    }
  } else {
    if (searches_ % 2 == 1) lay_relief_aside();
    start_first_generation();
  }
  population_ready_ = true;
  return Status::kOk;
}

// The best of evolution, refined as far as the settings have it.
Transform Tracker::refine_best() {
  if (is_thesis() || settings_.last_stage == Stage::kEvolved) {
    return to_transform(decode(population_.individual[0].chromosome, box_, settings_.ga.coding));
  }
  return kind_ == TargetKind::kMarker ? refine_best_marker() : refine_best_photo();
}

double Tracker::confidence_of(const Transform& T_H_M) const {
  return kind_ == TargetKind::kMarker ? marker_confidence_of(T_H_M) : photo_confidence_of(T_H_M);
}

// Whether a second search ends where the first one did.
bool Tracker::is_confirmed(const Transform& T_H_M) const {
  return doubting_ && !distinct(to_pose(T_H_M), to_pose(rescue_pose_));
}

void Tracker::update_state(double confidence) {
  if (confidence >= kFound) {
    state_ = TrackState::kTracking;
    return;
  }
  if (state_ == TrackState::kTracking) {
    // Search anew, in the whole box. The thesis just goes on.
    const LightFollower light = light_;  // fades of itself
    if (!is_thesis()) forget();
    light_ = light;
    state_ = TrackState::kLost;
  } else if (has_looked_everywhere()) {
    state_ = TrackState::kLost;
  }
}

Estimate Tracker::end_frame() {
  settle();  // where the budget ended before it came to that
  const bool found_anew = !following_;
  Transform T_H_M = refine_best();
  if (relief_aside_) T_H_M = with_or_without_relief(T_H_M);
  if (kind_ == TargetKind::kPhoto && !is_thesis()) assess_photo(T_H_M);
  learn_relief(T_H_M);
  Estimate estimate;
  estimate.pose = to_pose(T_H_M);
  estimate.fitness = fitness_at(estimate.pose);
  estimate.confidence = confidence_of(T_H_M);
  estimate.generations = generations_;
  estimate.evaluations = evaluations_;
  if (!is_thesis() && settings_.last_stage != Stage::kEvolved) {
    estimate.covariance = kind_ == TargetKind::kMarker ? marker_covariance() : photo_covariance(T_H_M);
  }
  T_H_M_last_ = T_H_M;
  searches_ = following_ ? 0 : searches_ + 1;
  update_state(estimate.confidence);
  if (!is_thesis()) follow_light(T_H_M);
  if (state_ == TrackState::kTracking || is_thesis()) {
    const bool elsewhere = found_anew && !is_confirmed(T_H_M);
    if (elsewhere && !is_thesis()) predictor_.forget();
    frames_tracked_ = elsewhere ? 1 : frames_tracked_ + 1;
    predictor_.observe(motion_.t_s, motion_.T_W_H, T_H_M);
    if (!is_thesis()) followed_score_ = score(T_H_M, followed_measure());
  }
  estimate.state = state_;
  return estimate;
}

}  // namespace vergence
