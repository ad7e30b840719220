#include "algo/tracker.hpp"

#include <algorithm>
#include <cmath>

#include "algo/pose_covariance.hpp"
#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

// Search: the population is evolved from scratch again and again, an epoch each time; the best of each epoch
// stands in the archive, from which the last part of a frame's budget settles.
struct SearchPlan {
  int epoch_generations;
  int founders;            // drawn for each of the first generation; the fittest of them stays
  int full_search_epochs;  // after so many in vain, the target is not there
  double share;            // of a frame's budget
};
constexpr SearchPlan kMarkerSearch{60, 1, 8, 0.75};
constexpr SearchPlan kPhotoSearch{30, 4, 24, 0.95};

const SearchPlan& plan_for(TargetKind kind) {
  return kind == TargetKind::kMarker ? kMarkerSearch : kPhotoSearch;
}

constexpr int kSearchPoints = 48;  // points of each measure
constexpr int kSettlePoints = 400;
constexpr int kJudgePoints = 640;
constexpr int kSettleMutation_per_1024 = 51;  // half of the searching rate: fewer long jumps

// What is searched for is to be some pixels large, and no more: the coarser, the wider the way up to the
// truth.
constexpr double kSearchSize_px = 12;
constexpr int kCoarsestLevel = 3;
constexpr RefinePass kArchivePass{3, 100, 6};
constexpr RefinePass kCoarsePass{2, 200, 8};
constexpr RefinePass kMiddlePass{1, 400, 6};
constexpr RefinePass kFinePass{0, 1000, 6};

// The thesis: nine generations; ours: what a cold lock, and a frame of tracking, take.
constexpr int kMarkerGuesses = 3;
constexpr double kExpectedShare = 0.3;  // of the contour points

constexpr int kThesisGenerations = 9;
constexpr int kSearchGenerations = 3200;
constexpr int kMarkerSearchGenerations = 1500;
constexpr int kTrackGenerations = 60;

constexpr double kFound = 0.5;  // confidence

// While following: what the frame before reached, times this, is a target that is no longer where it was
// expected.
constexpr double kGone = 0.75;
// A scout population searches the whole box while a target is followed, some generations a frame.
constexpr int kScoutGenerations = 20;
constexpr double kScoutMargin = 0.05;  // of the score, that a scout must be fitter by

// Confidence is the share of the way from what chance reaches to what a sure match reaches.
struct Certainty {
  double chance;
  double sure;
};
constexpr Certainty kThesisMarkerFitness{0.55, 1.25};  // of 180/108
// Of the share of contour points with an edge where it should be. No clutter reached a third; with one ball
// wrong it is two thirds at most, and so it can be of a marker followed behind a bar.
constexpr Certainty kMarkerFound{0.45, 0.99};
constexpr Certainty kMarkerFollowed{0.25, 0.65};
constexpr Certainty kMarkerLeastBall{0, 0.7};       // to be found; while it is followed, a ball may be hidden
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

// The coarsest level at which a photo-model is still large enough to be told, seen at the middle of the box.
int level_for(const PhotoModel& model, const CameraModel& camera, double distance_mm) {
  double squares = 0;  // of the points' distance from the origin; a square of side a has a^2 / 6 of it
  for (unsigned i = 0; i < static_cast<unsigned>(model.inner); ++i) {
    squares += model.x_mm[i] * model.x_mm[i] + model.y_mm[i] * model.y_mm[i];
  }
  const double side_mm = std::sqrt(6 * squares / model.inner);
  const double side_px = side_mm * camera.fx_px / (distance_mm > 1 ? distance_mm : 1);
  int level = 0;
  while (level < kCoarsestLevel && side_px / (2 << level) >= kSearchSize_px) ++level;
  return level;
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

// Whether a pose lies in a box or not far beside it: fitting may have carried it anywhere.
bool about_in(const SearchBox& box, const Pose& pose) {
  constexpr double kMargin = 1.25;  // of the half range
  bool inside = true;
  for (int i = 0; i < kGenes; ++i) {
    const double off = (i < 3 ? pose.position_mm[i] : pose.e[i - 3]) - box.centre[at(i)];
    inside &= std::abs(off) <= kMargin * box.half_range[at(i)];
  }
  return inside;
}

// Of [x y z e1 e2 e3]. What no outline tells is as uncertain as a search box.
Matrix6 marker_covariance(const MarkerFit& fit) {
  constexpr double kBox_mm = 200;
  constexpr double kBox_rad = 1;
  Matrix6 information = fit.information;
  for (int k = 0; k < 6; ++k) information(k, k) += 1 / (k < 3 ? kBox_mm * kBox_mm : kBox_rad * kBox_rad);
  return pose_covariance(information, fit.T_H_M);
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
  photo_ = model;
  std::copy_n(model.hue.begin(), kMaxPhotoPoints, photo_hue_.begin());
  photo_background_hue_ = model.background_hue;
  build_correlation_model(photo_, level_for(photo_, rig.left, settings.box.centre[2]), kSearchPoints,
                          search_model_);
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
  light_.forget();
  expect_light();
  predictor_.forget();
  start_search();
  scout_generation_ = 0;
  following_ = false;
  rescuing_ = false;
  state_ = TrackState::kSearching;
}

void Tracker::clear_archive() {
  archive_ = Population{};
  for (Individual& individual : archive_.individual) individual.score = INT64_MIN;
  epoch_generation_ = 0;
  epochs_ = 0;
}

int Tracker::usual_generations() const {
  if (is_thesis()) return kThesisGenerations;
  if (following_) return kTrackGenerations;
  const int search = kind_ == TargetKind::kMarker ? kMarkerSearchGenerations : kSearchGenerations;
  return rescuing_ ? kTrackGenerations + search : search;
}

Tracker::Measure Tracker::search_measure() const {
  return kind_ == TargetKind::kMarker || is_thesis() ? Measure::kVotes : Measure::kSearch;
}

// Of the pose that is followed: the measure of settling while it is.
Tracker::Measure Tracker::followed_measure() const {
  return kind_ == TargetKind::kMarker ? Measure::kVotes : Measure::kJudge;
}

Tracker::Measure Tracker::settle_measure() const {
  if (kind_ == TargetKind::kMarker || is_thesis()) return Measure::kVotes;
  return following_ ? followed_measure() : Measure::kSettle;
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
    if (following_) scout();
  } else {
    const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
    if (!population_ready_) {
      found_population(population_, is_thesis() ? 1 : plan_for(kind_).founders, random_, score_search);
    } else {
      evaluate_population(population_, score_search);
    }
  }
  population_ready_ = true;
  return Status::kOk;
}

void Tracker::evolve(double progress) {
  // Once the usual generations have followed it in vain, the rest of the frame's budget looks everywhere.
  if (following_ && generations_ == kTrackGenerations && is_gone()) start_rescue();
  ++generations_;
  if (!is_thesis() && !following_ && progress < plan_for(kind_).share) {
    evolve_search();
    return;
  }
  settle();
  GaSettings ga = settings_.ga;
  if (!is_thesis()) ga.mutation_per_1024 = kSettleMutation_per_1024;
  evolve_generation(population_, ga, random_,
                    [this](const Chromosome& c) { return score(c, settle_measure()); });
}

// Whether what is followed is seen far less well than in the frame before.
bool Tracker::is_gone() const {
  return static_cast<double>(population_.individual[0].score) < kGone * static_cast<double>(followed_score_);
}

void Tracker::start_search() {
  box_ = settings_.box;
  clear_archive();
  population_ready_ = false;
}

void Tracker::start_rescue() {
  rescue_pose_ = to_transform(decode(population_.individual[0].chromosome, box_, settings_.ga.coding));
  following_ = false;
  rescuing_ = true;
  start_search();
  found_population(population_, plan_for(kind_).founders, random_,
                   [this](const Chromosome& c) { return score(c, search_measure()); });
  population_ready_ = true;
}

// Some generations of a population that has nothing to do with the target that is followed. The best of an
// epoch, where it is fitter than what is followed, and elsewhere, makes the frame a search.
void Tracker::scout() {
  const auto score_search = [this](const Chromosome& c) {
    ++evaluations_;
    return score(to_transform(decode(c, settings_.box, settings_.ga.coding)), search_measure());
  };
  if (scout_generation_ == 0) {
    found_population(scouts_, plan_for(kind_).founders, random_, score_search);
  } else {
    evaluate_population(scouts_, score_search);
  }
  for (int g = 0; g < kScoutGenerations; ++g) {
    evolve_generation(scouts_, settings_.ga, random_, score_search);
  }
  scout_generation_ += kScoutGenerations;
  if (scout_generation_ < plan_for(kind_).epoch_generations) return;
  scout_generation_ = 0;
  const Pose found = decode(scouts_.individual[0].chromosome, settings_.box, settings_.ga.coding);
  const Pose followed = decode(population_.individual[0].chromosome, box_, settings_.ga.coding);
  const auto mark = static_cast<double>(score(to_transform(followed), search_measure()));
  const auto scouted = static_cast<double>(scouts_.individual[0].score);
  const double margin = kScoutMargin * (mark > 0 ? mark : -mark);
  if (distinct(found, followed) && scouted > mark + margin) {
    start_rescue();
    archive_.individual[0] = {encode(found, box_, settings_.ga.coding), scouts_.individual[0].score};
  }
}

void Tracker::evolve_search() {
  const auto score_search = [this](const Chromosome& c) { return score(c, search_measure()); };
  if (epoch_generation_ == plan_for(kind_).epoch_generations) {
    keep_in_archive(population_.individual[0]);
    ++epochs_;
    epoch_generation_ = 0;
    found_population(population_, plan_for(kind_).founders, random_, score_search);
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
  if (!is_thesis() && !following_ && !settling_) merge_archive();
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
  if (search_measure() == Measure::kSearch) polish_archive();
  evaluate_population(population_, [this](const Chromosome& c) { return score(c, settle_measure()); });
}

// A few steps of alignment bring those that got near the truth nearer than evolution at that resolution can.
void Tracker::polish_archive() {
  RefinePass pass = kArchivePass;
  pass.level = search_model_.level;
  for (Individual& individual : population_.individual) {
    const Transform T = to_transform(decode(individual.chromosome, box_, settings_.ga.coding));
    Transform polished = T;
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, polished);
    if (score(polished, Measure::kSettle) > score(T, Measure::kSettle)) {
      individual.chromosome = encode(to_pose(polished), box_, settings_.ga.coding);
    }
  }
}

Transform Tracker::refine_best() {
  const GeneCoding coding = settings_.ga.coding;
  const Pose best = decode(population_.individual[0].chromosome, box_, coding);
  Transform T_H_M = to_transform(best);
  if (is_thesis() || settings_.last_stage == Stage::kEvolved) return T_H_M;
  if (kind_ == TargetKind::kMarker) return refine_best_marker();

  const auto refine = [this](const RefinePass& pass, Transform& T) {
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
  };
  const auto cost = [this](const RefinePass& pass, const Transform& T) {
    return alignment_cost(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
  };
  if (!following_) {
    // The fittest, its mirror image, the fittest of those elsewhere, and where it was followed to.
    Pose other = best;
    for (int i = kPopulation - 1; i > 0; --i) {
      const Pose pose = decode(population_.individual[at(i)].chromosome, box_, coding);
      if (distinct(pose, best)) other = pose;
    }
    std::array<Transform, 4> guesses{T_H_M, mirrored_tilt(T_H_M), to_transform(other),
                                     rescuing_ ? rescue_pose_ : mirrored_tilt(to_transform(other))};
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
  photo_alignment_ =
      assess_alignment(photo_, rig_, colour_left_, colour_right_, kFinePass, workspace_, T_H_M);
  return T_H_M;
}

MarkerSight Tracker::marker_sight(bool of_left) const {
  return {of_left ? &rig_.left : &rig_.right, of_left ? &hue_left_ : &hue_right_,
          level_of(of_left ? colour_left_ : colour_right_, 0), yuv_};
}

Transform Tracker::refine_best_marker() {
  const MarkerSight left = marker_sight(true);
  const MarkerSight right = marker_sight(false);
  const auto individual = [this](int i) {
    return decode(population_.individual[at(i)].chromosome, box_, settings_.ga.coding);
  };
  if (following_) {
    // The fittest, or where it was expected if the outlines are there already.
    const Transform fittest = to_transform(individual(0));
    const Transform expected = predictor_.predict(motion_.t_s, motion_.T_W_H);
    const MarkerEvidence of_expected = marker_evidence(marker_, left, right, expected);
    const bool there = of_expected.share > kExpectedShare &&
                       of_expected.cost < marker_evidence(marker_, left, right, fittest).cost;
    marker_fit_ = fit_marker(marker_, left, right, there ? expected : fittest);
    return marker_fit_.T_H_M;
  }
  // The fittest, and the fittest of those elsewhere; where there are too few of them, others do.
  std::array<Pose, kMarkerGuesses> guess;
  for (int g = 0; g < kMarkerGuesses; ++g) {
    guess[at(g)] = individual(g);
    bool found = g == 0;
    for (int i = 1; i < kPopulation; ++i) {
      const Pose pose = individual(i);
      bool fresh = !found;
      for (int k = 0; k < g; ++k) fresh &= distinct(pose, guess[at(k)]);
      if (fresh) guess[at(g)] = pose;
      found |= fresh;
    }
  }
  double least_cost = 3;
  const auto try_from = [&](const Transform& T) {
    const MarkerFit fit = fit_marker(marker_, left, right, T);
    const double cost = fit.evidence.cost + (about_in(settings_.box, to_pose(fit.T_H_M)) ? 0 : 1);
    if (cost < least_cost) marker_fit_ = fit;
    least_cost = cost < least_cost ? cost : least_cost;
  };
  for (const Pose& pose : guess) try_from(to_transform(pose));
  try_from(rescuing_ ? rescue_pose_ : to_transform(guess[0]));
  try_from(pivoted(marker_fit_));
  return marker_fit_.T_H_M;
}

// Two balls may be right and the others elsewhere: turns the pose about the line through the two that are
// borne out best, to where the votes like it most.
Transform Tracker::pivoted(const MarkerFit& fit) const {
  constexpr int kAngles = 48;
  constexpr int kFirst = 2;  // less than that much of a turn is what fitting itself sees to
  constexpr double kHalfAngle_rad = 3.141592653589793 / kAngles;
  int first = 0;
  int second = marker_.balls > 1 ? 1 : 0;
  for (int ball = 1; ball < marker_.balls; ++ball) {
    const double share = fit.evidence.ball[at(ball)];
    if (share > fit.evidence.ball[at(first)]) {
      second = first;
      first = ball;
    } else if (ball != second && share > fit.evidence.ball[at(second)]) {
      second = ball;
    }
  }
  const Vector3 from = marker_.ball[at(first)].centre_mm;
  const Vector3 way = marker_.ball[at(second)].centre_mm - from;
  const Vector3 axis = way / std::sqrt(way.squaredNorm() + 1e-12);
  Transform best = fit.T_H_M;
  std::int64_t most = INT64_MIN;
  for (int k = kFirst; k <= kAngles - kFirst; ++k) {
    const auto [sine, cosine] = sin_cos(kHalfAngle_rad * k);
    const Matrix3 R =
        rotation_from_quaternion_vector(cosine < 0 ? Vector3(-sine * axis) : Vector3(sine * axis));
    const Transform T = fit.T_H_M * Transform{R, from - R * from};
    const std::int64_t votes = score(T, Measure::kVotes);
    if (votes > most) best = T;
    if (votes > most) most = votes;
  }
  return best;
}

// Learns, from the pixels that show the target, how the light shifts its hues.
void Tracker::follow_light(const Transform& T_H_M) {
  const bool tracked = state_ == TrackState::kTracking;
  if (tracked && kind_ == TargetKind::kMarker) {
    observe_light(marker_, marker_hue_, marker_sight(true), marker_sight(false), marker_fit_, light_);
  }
  if (tracked && kind_ == TargetKind::kPhoto) {
    for (const bool of_left : {true, false}) {
      const CameraModel& camera = of_left ? rig_.left : rig_.right;
      const HuePlane& plane = of_left ? hue_left_ : hue_right_;
      const Transform T_C_M = target_in_camera(camera, T_H_M);
      for (unsigned i = 0; i < at(photo_.inner); ++i) {
        Vector2 uv{-1, -1};
        const Vector3 p = T_C_M * Vector3(photo_.x_mm[i], photo_.y_mm[i], photo_.z_mm[i]);
        const bool inside = project(camera, p, uv) && uv[0] >= 0 && uv[1] >= 0 &&
                            uv[0] <= plane.width_px - 1 && uv[1] <= plane.height_px - 1;
        const int index = inside
                              ? static_cast<int>(uv[1] + 0.5) * plane.width_px + static_cast<int>(uv[0] + 0.5)
                              : plane.outside_index();
        light_.observe(hue_sector(photo_hue_[i]), photo_hue_[i], plane.code[at(index)]);
      }
    }
  }
  light_.end_frame(tracked);
  expect_light();
}

void Tracker::expect_light() {
  for (int ball = 0; ball < marker_.balls; ++ball) {
    marker_.hue[at(ball)] = light_.expected(ball, marker_hue_[at(ball)]);
  }
  for (unsigned i = 0; i < at(photo_.points()); ++i) {
    photo_.hue[i] = light_.expected(hue_sector(photo_hue_[i]), photo_hue_[i]);
  }
  photo_.background_hue = light_.expected(hue_sector(photo_background_hue_), photo_background_hue_);
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
  if (kind_ == TargetKind::kMarker && (is_thesis() || settings_.last_stage == Stage::kEvolved)) {
    return share_of(fitness_at(to_pose(T_H_M)), kThesisMarkerFitness);
  }
  if (kind_ == TargetKind::kMarker) {
    const MarkerEvidence& evidence = marker_fit_.evidence;
    if (following_) return share_of(evidence.share, kMarkerFollowed);
    if (!about_in(settings_.box, to_pose(T_H_M))) return 0;
    const double all = share_of(evidence.share, kMarkerFound);
    const double least = share_of(evidence.least_ball, kMarkerLeastBall);
    return all < least ? all : least;
  }
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
    const LightFollower light = light_;  // fades of itself
    if (!is_thesis()) forget();
    light_ = light;
    state_ = TrackState::kLost;
  } else if (epochs_ >= plan_for(kind_).full_search_epochs) {
    state_ = TrackState::kLost;
  }
}

Estimate Tracker::end_frame() {
  settle();  // where the budget ended before it came to that
  const bool found_anew = !following_;
  Transform T_H_M = refine_best();
  learn_relief(T_H_M);
  Estimate estimate;
  estimate.pose = to_pose(T_H_M);
  estimate.fitness = fitness_at(estimate.pose);
  estimate.confidence = confidence_of(T_H_M);
  estimate.generations = generations_;
  estimate.evaluations = evaluations_;
  if (!is_thesis() && settings_.last_stage != Stage::kEvolved) {
    estimate.covariance =
        kind_ == TargetKind::kMarker ? marker_covariance(marker_fit_) : photo_alignment_.covariance;
  }
  T_H_M_last_ = T_H_M;
  update_state(estimate.confidence);
  if (!is_thesis()) follow_light(T_H_M);
  if (state_ == TrackState::kTracking || is_thesis()) {
    if (found_anew && !is_thesis()) predictor_.forget();
    predictor_.observe(motion_.t_s, motion_.T_W_H, T_H_M);
    if (!is_thesis()) followed_score_ = score(T_H_M, followed_measure());
  }
  estimate.state = state_;
  return estimate;
}

}  // namespace vergence
