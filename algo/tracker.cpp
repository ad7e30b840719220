#include "algo/tracker.hpp"

#include <cmath>

namespace vergence {
namespace {

// Search: the population is evolved from scratch again and again, an epoch each time; the best of each epoch
// stands in the archive, from which the last part of a frame's budget settles.
constexpr int kEpochGenerations = 60;
constexpr int kFullSearchEpochs = 8;   // after so many in vain, the target is not there
constexpr double kSearchShare = 0.75;  // of a frame's budget
constexpr int kSearchPoints = 160;     // points of each measure
constexpr int kSettlePoints = 400;
constexpr int kJudgePoints = 640;
constexpr int kSettleMutation_per_1024 = 51;  // half of the searching rate: fewer long jumps

constexpr RefinePass kCoarsePass{2, 200, 8};
constexpr RefinePass kMiddlePass{1, 400, 6};
constexpr RefinePass kFinePass{0, 1000, 6};

// The thesis: nine generations; ours: what a cold lock, and a frame of tracking, take.
constexpr int kThesisGenerations = 9;
constexpr int kSearchGenerations = 2400;
constexpr int kTrackGenerations = 60;

constexpr double kFound = 0.5;  // confidence

// Confidence is the share of the way from what chance reaches to what a sure match reaches.
struct Certainty {
  double chance;
  double sure;
};
constexpr Certainty kMarkerFitness{0.55, 1.25};     // of 180/108
constexpr Certainty kPhotoCorrelation{0.55, 0.85};  // of 1
constexpr Certainty kThesisPhotoFitness{0.5, 1.3};  // of about 1.6

double share_of(double value, const Certainty& certainty) {
  const double share = (value - certainty.chance) / (certainty.sure - certainty.chance);
  return share > 0 ? (share < 1 ? share : 1) : 0;
}

bool usable(const CameraModel& camera) {
  return camera.width_px >= 16 && camera.height_px >= 16 && camera.width_px <= kMaxImageWidth &&
         camera.height_px <= kMaxImageHeight && camera.fx_px > 0 && camera.fy_px > 0 &&
         std::isfinite(camera.fx_px * camera.fy_px * camera.cx_px * camera.cy_px);
}

// A flat target looks nearly the same when its tilt is mirrored on the line of sight (Necker's reversal):
// each of its points keeps its place across the line of sight and swaps depth. Which of the two it is,
// refinement tells.
Transform mirrored_tilt(const Transform& T_H_M) {
  const Vector3 sight = T_H_M.t_mm / std::sqrt(T_H_M.t_mm.squaredNorm() + 1e-12);
  const Matrix3 half_turn = 2 * sight * sight.transpose() - Matrix3::Identity();
  const Matrix3 R = half_turn * T_H_M.R * Vector3{-1, -1, 1}.asDiagonal();
  return {R, T_H_M.t_mm};
}

// Far enough apart to be two different guesses rather than one.
bool distinct(const Pose& a, const Pose& b) {
  return (a.position_mm - b.position_mm).squaredNorm() > 15.0 * 15.0 ||
         (a.e - b.e).squaredNorm() > 0.15 * 0.15;
}

// The same place, found in two frames.
bool alike(const Transform& a, const Transform& b) {
  constexpr double kAlike_mm = 10;
  constexpr double kAlike_e = 0.06;
  return (a.t_mm - b.t_mm).squaredNorm() < kAlike_mm * kAlike_mm &&
         quaternion_vector_from_rotation(a.R.transpose() * b.R).squaredNorm() < kAlike_e * kAlike_e;
}

unsigned at(int i) {
  return static_cast<unsigned>(i);
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
  return configure_common(rig, settings);
}

Status Tracker::configure(const StereoRig& rig, const PhotoModel& model, const TrackerSettings& settings) {
  if (model.inner < 16) return Status::kBadModel;
  kind_ = TargetKind::kPhoto;
  photo_ = model;
  build_correlation_model(photo_, 2, kSearchPoints, search_model_);
  build_correlation_model(photo_, 2, kSettlePoints, settle_model_);
  build_correlation_model(photo_, 1, kJudgePoints, judge_model_);
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
  predictor_.forget();
  population_ready_ = false;
  box_ = settings_.box;
  archive_ = Population{};
  for (Individual& individual : archive_.individual) individual.score = INT64_MIN;
  epoch_generation_ = 0;
  epochs_ = 0;
  state_ = TrackState::kSearching;
}

int Tracker::usual_generations() const {
  if (is_thesis()) return kThesisGenerations;
  return state_ == TrackState::kTracking ? kTrackGenerations : kSearchGenerations;
}

Tracker::Measure Tracker::search_measure() const {
  return kind_ == TargetKind::kMarker || is_thesis() ? Measure::kVotes : Measure::kSearch;
}

Tracker::Measure Tracker::settle_measure() const {
  if (kind_ == TargetKind::kMarker || is_thesis()) return Measure::kVotes;
  return state_ == TrackState::kTracking ? Measure::kJudge : Measure::kSettle;
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
  random_ = CounterRandom(settings_.seed, frame);
  motion_ = motion;
  rig_.left.T_H_C = motion.T_H_CL;
  rig_.right.T_H_C = motion.T_H_CR;
  T_CL_H_ = motion.T_H_CL.inverse();
  T_CR_H_ = motion.T_H_CR.inverse();
  generations_ = 0;
  evaluations_ = 0;
  settling_ = false;

  const GeneCoding coding = settings_.ga.coding;
  const auto score_settle = [this](const Chromosome& c) { return score(c, settle_measure()); };
  if (state_ == TrackState::kTracking || (is_thesis() && predictor_.known())) {
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
  } else {
    const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
    if (!population_ready_) {
      start_population(population_, random_, score_search);
    } else {
      evaluate_population(population_, score_search);
    }
  }
  population_ready_ = true;
  return Status::kOk;
}

void Tracker::evolve(double progress) {
  ++generations_;
  if (!is_thesis() && state_ != TrackState::kTracking && progress < kSearchShare) {
    evolve_search();
    return;
  }
  settle();
  GaSettings ga = settings_.ga;
  if (!is_thesis()) ga.mutation_per_1024 = kSettleMutation_per_1024;
  evolve_generation(population_, ga, random_,
                    [this](const Chromosome& c) { return score(c, settle_measure()); });
}

void Tracker::evolve_search() {
  const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
  if (epoch_generation_ == kEpochGenerations) {
    keep_in_archive(population_.individual[0]);
    ++epochs_;
    epoch_generation_ = 0;
    start_population(population_, random_, score_search);
  }
  ++epoch_generation_;
  evolve_generation(population_, settings_.ga, random_, score_search);
}

void Tracker::keep_in_archive(const Individual& individual) {
  unsigned worst = 0;
  for (unsigned i = 1; i < kPopulation; ++i) {
    if (archive_.individual[i].score < archive_.individual[worst].score) worst = i;
  }
  if (individual.score > archive_.individual[worst].score) archive_.individual[worst] = individual;
}

void Tracker::settle() {
  if (!is_thesis() && state_ != TrackState::kTracking && !settling_) merge_archive();
  settling_ = true;
}

void Tracker::merge_archive() {
  // The running epoch's best stand in for the epochs that have not ended yet.
  Population merged = archive_;
  int next = 0;
  for (Individual& individual : merged.individual) {
    if (individual.score == INT64_MIN) individual = population_.individual[at(next++)];
  }
  merged.individual[kPopulation - 1] = population_.individual[0];
  population_ = merged;
  evaluate_population(population_, [this](const Chromosome& c) { return score(c, settle_measure()); });
}

Transform Tracker::refine_best() {
  const GeneCoding coding = settings_.ga.coding;
  const Pose best = decode(population_.individual[0].chromosome, box_, coding);
  Transform T_H_M = to_transform(best);
  if (kind_ == TargetKind::kMarker || is_thesis()) return T_H_M;

  const auto refine = [this](const RefinePass& pass, Transform& T) {
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
  };
  const auto cost = [this](const RefinePass& pass, const Transform& T) {
    return alignment_cost(photo_, rig_, colour_left_, colour_right_, pass.level, pass.points, workspace_, T);
  };
  if (state_ != TrackState::kTracking) {
    // Three guesses: the fittest, its mirror image, and the fittest of those elsewhere.
    Pose other = best;
    for (int i = kPopulation - 1; i > 0; --i) {
      const Pose pose = decode(population_.individual[at(i)].chromosome, box_, coding);
      if (distinct(pose, best)) other = pose;
    }
    std::array<Transform, 3> guesses{T_H_M, mirrored_tilt(T_H_M), to_transform(other)};
    double least_cost = 1e9;
    for (Transform& guess : guesses) {
      refine(kCoarsePass, guess);
      const double guess_cost = cost(kMiddlePass, guess);
      if (guess_cost < least_cost) {
        least_cost = guess_cost;
        T_H_M = guess;
      }
    }
  }
  // No pass may make it worse by its own measure.
  for (const RefinePass& pass : {kMiddlePass, kFinePass}) {
    const double before = cost(pass, T_H_M);
    Transform refined = T_H_M;
    refine(pass, refined);
    if (cost(pass, refined) <= before) T_H_M = refined;
  }
  return T_H_M;
}

// Where a relief is adopted, the pose moves to where the target is on it: what was flat was biased. A solid
// too thick to be recognized by the flat model is learned all the same, from where it is found again and
// again; its relief then has to make it recognized.
void Tracker::learn_relief(Transform& T_H_M) {
  if (kind_ != TargetKind::kPhoto || is_thesis() || settings_.last_stage != Stage::kRelief) return;
  const bool tracked = confidence_of(T_H_M) >= kFound;
  if (tracked ? state_ != TrackState::kTracking : !alike(T_H_M, T_H_M_last_)) {
    if (!tracked) relief_.drop();
    return;
  }
  if (!tracked && relief_.state() == ReliefState::kAdopted) return;
  if (!relief_.observe(rig_, colour_left_, colour_right_, photo_, T_H_M)) return;
  Transform T_on_relief = T_H_M;
  relief_.adopt(photo_, T_on_relief);
  T_H_M = T_on_relief;
}

double Tracker::confidence_of(const Transform& T_H_M) const {
  if (kind_ == TargetKind::kMarker) return share_of(fitness_at(to_pose(T_H_M)), kMarkerFitness);
  if (is_thesis()) return share_of(fitness_at(to_pose(T_H_M)), kThesisPhotoFitness);
  const double both =
      static_cast<double>(score(T_H_M, Measure::kJudge)) / static_cast<double>(kCorrelationOne);
  return share_of(both / 2, kPhotoCorrelation);
}

void Tracker::update_state(double confidence) {
  if (confidence >= kFound) {
    state_ = TrackState::kTracking;
    return;
  }
  if (state_ == TrackState::kTracking) {
    // Search anew, in the whole box. The thesis just goes on.
    if (!is_thesis()) forget();
    state_ = TrackState::kLost;
  } else if (epochs_ >= kFullSearchEpochs) {
    state_ = TrackState::kLost;
  }
}

Estimate Tracker::end_frame() {
  settle();  // where the budget ended before it came to that
  const TrackState before = state_;
  Transform T_H_M = refine_best();
  learn_relief(T_H_M);
  Estimate estimate;
  estimate.pose = to_pose(T_H_M);
  estimate.fitness = fitness_at(estimate.pose);
  estimate.confidence = confidence_of(T_H_M);
  estimate.generations = generations_;
  estimate.evaluations = evaluations_;
  T_H_M_last_ = T_H_M;
  update_state(estimate.confidence);
  if (state_ == TrackState::kTracking || is_thesis()) {
    if (before != TrackState::kTracking && !is_thesis()) predictor_.forget();
    predictor_.observe(motion_.t_s, motion_.T_W_H, T_H_M);
  }
  estimate.state = state_;
  return estimate;
}

}  // namespace vergence
