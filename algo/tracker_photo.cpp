// The photo-model within the tracker: its measures, refinement and how sure it is.
#include <limits>

#include "algo/backdrop.hpp"
#include "algo/pose_covariance.hpp"
#include "algo/shape_uncertainty.hpp"
#include "algo/tracker_parts.hpp"

namespace vergence {
namespace {

constexpr int kSearchPoints = 64;  // points of each measure
constexpr int kSettlePoints = 400;
constexpr int kJudgePoints = 640;

// What is searched for is to be some pixels large, and no more: the coarser, the wider the way up to the
// truth.
constexpr double kSearchSize_px = 12;
constexpr int kCoarsestLevel = 3;
constexpr RefinePass kArchivePass{3, 100, 6};
constexpr RefinePass kMiddlePass{1, 400, 6};
constexpr RefinePass kFinePass{0, 1000, 6};
constexpr RefinePass kBesidePass{2, 64, 5};

// Tilts and depths beside what was found that are tried as well: alignment may have settled at a wrong one.
constexpr double kTilt_e = 0.15;
constexpr std::array<std::array<double, 2>, 5> kTilts{
    {{0, 0}, {kTilt_e, 0}, {-kTilt_e, 0}, {0, kTilt_e}, {0, -kTilt_e}}};
constexpr std::array<double, 3> kDepths_mm{0, -14, 14};
// How much a solid's silhouette may be inflated.
constexpr std::array<double, 4> kInflations{0, 0.5, 1, 1.5};

constexpr Certainty kThesisPhotoFitness{0.5, 1.3};  // of about 1.6

Vector3 line_of_sight(const Transform& T_H_M) {
  return T_H_M.t_mm / std::sqrt(T_H_M.t_mm.squaredNorm() + 1e-12);
}

// A flat target looks nearly the same when its tilt is mirrored on the line of sight (Necker's reversal):
// each of its points keeps its place across the line of sight and swaps depth. Which of the two it is,
// refinement tells.
Transform mirrored_tilt(const Transform& T_H_M) {
  const Vector3 sight = line_of_sight(T_H_M);
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

}  // namespace

// A few steps of alignment bring those that got near the truth nearer than evolution at that resolution can.
// Of the archives of two shapes, the better half of each.
void Tracker::polish_archive() {
  RefinePass pass = kArchivePass;
  pass.level = search_model_.level;
  const bool all = !may_be_solid();
  if (!all) {
    evaluate_population(population_, [this](const Chromosome& c) { return score(c, Measure::kSettle); });
  }
  for (unsigned i = 0; i < (all ? kPopulation : kPopulation / kShapes); ++i) {
    Individual& individual = population_.individual[i];
    const Transform T = to_transform(decode(individual.chromosome, box_, settings_.ga.coding));
    Transform polished = T;
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, polished);
    if (score(polished, Measure::kSettle) > score(T, Measure::kSettle)) {
      individual.chromosome = encode(to_pose(polished), box_, settings_.ga.coding);
    }
  }
}

void Tracker::build_measures() {
  build_correlation_model(photo_, level_for(photo_, rig_.left, settings_.box.centre[2]), kSearchPoints,
                          photo_.masked ? HiddenPoints::kLeftOut : HiddenPoints::kTakenAlong, search_model_);
  build_correlation_model(photo_, 2, kSettlePoints, HiddenPoints::kLeftOut, settle_model_);
  build_correlation_model(photo_, 1, kJudgePoints, HiddenPoints::kLeftOut, judge_model_);
}

// Whatever it is photographed before, the target is before something else now.
void Tracker::put_before_backdrop(bool limited_range) {
  const Backdrop backdrop = find_backdrop(colour_left_, colour_right_, limited_range);
  put_before(backdrop, backdrop_change(photo_.backdrop, backdrop), as_photographed_, photo_);
  leave_rim_out(photo_.masked && !backdrop.plain, photo_);
  build_measures();
}

// From a pose, tilted, nearer and farther, aligned: the one that correlation likes best.
Transform Tracker::best_beside(const Transform& T_H_M) {
  Transform best = T_H_M;
  std::int64_t best_score = score(T_H_M, Measure::kJudge);
  for (const double depth_mm : kDepths_mm) {
    for (const auto& [e1, e2] : kTilts) {
      Transform T = T_H_M * Transform{rotation_from_quaternion_vector({e1, e2, 0}), Vector3::Zero()};
      T.t_mm += depth_mm * line_of_sight(T);
      refine_photo_pose(photo_, rig_, colour_left_, colour_right_, kBesidePass, workspace_, T);
      const std::int64_t beside = score(T, Measure::kJudge);
      if (beside > best_score) {
        best_score = beside;
        best = T;
      }
    }
  }
  return best;
}

// Leaves the model inflated as costs least, and returns where it lies then.
Transform Tracker::best_inflation(const Transform& T_H_M) {
  Transform best = T_H_M;
  double least = std::numeric_limits<double>::max();
  double best_share = 0;
  for (const double share : kInflations) {
    inflate(share);
    Transform T = T_H_M;
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, kCoarsePass, workspace_, T);
    const double cost = alignment_cost(photo_, rig_, colour_left_, colour_right_, kCoarsePass, workspace_, T);
    if (cost < least) {
      least = cost;
      best_share = share;
      best = T;
    }
    if (!may_be_solid()) break;  // one shape only
  }
  inflate(best_share);
  return best;
}

// The last passes, of which none may make it worse by its own measure.
Transform Tracker::finely_refined(Transform T_H_M) {
  for (const RefinePass& pass : {kMiddlePass, kFinePass}) {
    const auto cost = [&](const Transform& T) {
      return alignment_cost(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
    };
    const double before = cost(T_H_M);
    Transform refined = T_H_M;
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, refined);
    if (cost(refined) <= before) T_H_M = refined;
  }
  return T_H_M;
}

bool Tracker::will_be_believed(const Transform& T_H_M) {
  const Transform refined = finely_refined(T_H_M);
  assess_photo(refined);
  return confidence_of(refined) >= kFound;
}

// Of what a search found, and what was followed until then, the one that correlation likes better, each with
// the model as it fits best there. Where the followed one was only doubted, not gone, what is found elsewhere
// has to be clearly better, and what is believed is not given up for what is not.
Transform Tracker::found_or_followed(const Transform& found_T_H_M) {
  const double found_inflation = inflation_;
  const std::int64_t found_score = score(found_T_H_M, Measure::kJudge);
  const bool found_believed = doubting_ && will_be_believed(found_T_H_M);
  Transform T_H_M = best_inflation(rescue_pose_);
  std::int64_t followed_score = score(T_H_M, Measure::kJudge);
  for (Transform guess : {T_H_M, T_H_M_last_}) {
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, kCoarsePass, workspace_, guess);
    const std::int64_t guess_score = score(guess, Measure::kJudge);
    if (guess_score > followed_score) {
      followed_score = guess_score;
      T_H_M = guess;
    }
  }
  const bool elsewhere = distinct(to_pose(found_T_H_M), to_pose(T_H_M));
  const bool better = doubting_ && elsewhere ? clearly_fitter(static_cast<double>(found_score),
                                                              static_cast<double>(followed_score))
                                             : found_score > followed_score;
  const bool followed_believed = doubting_ && will_be_believed(T_H_M);
  if (found_believed == followed_believed ? !better : followed_believed) return T_H_M;
  inflate(found_inflation);
  return found_T_H_M;
}

Transform Tracker::refine_best_photo() {
  const GeneCoding coding = settings_.ga.coding;
  const Pose best = decode(population_.individual[0].chromosome, box_, coding);
  Transform T_H_M = to_transform(best);

  const auto refine = [this](const RefinePass& pass, Transform& T) {
    refine_photo_pose(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
  };
  const auto cost = [this](const RefinePass& pass, const Transform& T) {
    return alignment_cost(photo_, rig_, colour_left_, colour_right_, pass, workspace_, T);
  };
  // Which of a pose and its mirror image it is, alignment tells; at which place, correlation: alignment costs
  // least where there is nothing to be told.
  std::int64_t best_score = INT64_MIN;
  const auto consider = [&](const Transform& guess) {
    const std::int64_t guess_score = score(guess, Measure::kJudge);
    if (guess_score > best_score) {
      best_score = guess_score;
      T_H_M = guess;
    }
  };
  if (following_) {
    // Where it was expected, and where it was: a target that turns off or stops is not where it was expected.
    consider(T_H_M);
    for (Transform guess : {T_H_M, T_H_M_last_}) {
      refine(kCoarsePass, guess);
      consider(guess);
    }
  } else {
    // The fittest and the fittest of those elsewhere, or in the other shape, each with its mirror image; what
    // lies beside the best of these; and where it was followed to.
    Shaped other{best, inflation_};
    for (int i = kPopulation - 1; i > 0; --i) {
      const Pose pose = decode(population_.individual[at(i)].chromosome, box_, coding);
      if (distinct(pose, best)) other.pose = pose;
    }
    if (may_be_solid()) other = lesser_;
    double best_inflation_so_far = inflation_;
    for (const Shaped& start : {Shaped{best, inflation_}, other}) {
      inflate(start.inflation);
      Transform guess = to_transform(start.pose);
      Transform mirrored = mirrored_tilt(guess);
      refine(kCoarsePass, guess);
      refine(kCoarsePass, mirrored);
      const std::int64_t score_before = best_score;
      consider(cost(kMiddlePass, mirrored) < cost(kMiddlePass, guess) ? mirrored : guess);
      if (best_score > score_before) best_inflation_so_far = inflation_;
    }
    inflate(best_inflation_so_far);
    T_H_M = best_inflation(best_beside(T_H_M));
    if (rescuing_) T_H_M = found_or_followed(T_H_M);
  }
  return finely_refined(T_H_M);
}

void Tracker::assess_photo(const Transform& T_H_M) {
  photo_alignment_ =
      assess_alignment(photo_, rig_, colour_left_, colour_right_, kFinePass, workspace_, T_H_M);
  const int points = kFinePass.points < photo_.inner ? kFinePass.points : photo_.inner;
  const int whole = points / 4 * 4;  // as alignment samples them
  likeness_left_ = photo_likeness(photo_, whole, workspace_.left, workspace_.photo.data());
  likeness_right_ = photo_likeness(photo_, whole, workspace_.right, workspace_.photo.data());
}

Matrix6 Tracker::photo_covariance(const Transform& T_H_M) const {
  const ShapeKnowledge knowledge = relief_.state() != ReliefState::kAdopted ? ShapeKnowledge::kNone
                                   : relief_.is_young()                     ? ShapeKnowledge::kYoungRelief
                                                                            : ShapeKnowledge::kRelief;
  return photo_alignment_.covariance +
         pose_covariance(shape_deviation(knowledge, photo_alignment_.pairing_cost[2]), T_H_M);
}

double Tracker::photo_confidence_of(const Transform& T_H_M) const {
  if (is_thesis()) return share_of(fitness_at(to_pose(T_H_M)), kThesisPhotoFitness);
  if (!following_ && !about_in(settings_.box, to_pose(T_H_M))) return 0;
  return photo_confidence(photo_evidence_of(T_H_M), following_);
}

PhotoEvidence Tracker::photo_evidence_of(const Transform& T_H_M) const {
  const unsigned level = at(judge_model_.level);
  const auto likeness = [&](const CameraModel& camera, const ColourPyramid& pyramid, const Transform& T_C_M) {
    return static_cast<double>(
               correlation(judge_model_, photo_, camera, level_of(pyramid, judge_model_.level), T_C_M)) /
           static_cast<double>(kCorrelationOne);
  };
  const auto larger = [](double a, double b) { return a > b ? a : b; };
  PhotoEvidence evidence;
  evidence.left = likeness(camera_left_[level], colour_left_, T_CL_H_ * T_H_M);
  evidence.right = likeness(camera_right_[level], colour_right_, T_CR_H_ * T_H_M);
  evidence.left_right_cost = photo_alignment_.pairing_cost[2];
  evidence.luma = larger(likeness_left_.luma, likeness_right_.luma);
  evidence.worst_quarter = larger(likeness_left_.worst_quarter, likeness_right_.worst_quarter);
  const Matrix6& covariance = photo_alignment_.covariance;
  evidence.depth_mm = std::sqrt(covariance(2, 2));
  evidence.e = std::sqrt(covariance(3, 3) + covariance(4, 4) + covariance(5, 5));
  return evidence;
}

}  // namespace vergence
