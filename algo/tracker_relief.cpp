// The relief within the tracker: the shape while nothing is known of it, learning, laying aside, giving back.
#include "algo/tracker_parts.hpp"

namespace vergence {
namespace {

// The same place, found in two frames.
bool alike(const Transform& a, const Transform& b) {
  constexpr double kAlike_mm = 10;
  constexpr double kAlike_e = 0.06;
  return (a.t_mm - b.t_mm).squaredNorm() < kAlike_mm * kAlike_mm &&
         quaternion_vector_from_rotation(a.R.transpose() * b.R).squaredNorm() < kAlike_e * kAlike_e;
}

}  // namespace

// A photo-model of which the silhouette is known, but no relief in use, may be a solid's: inflated it is
// nearer to that than flat.
bool Tracker::may_be_solid() const {
  return kind_ == TargetKind::kPhoto && !is_thesis() && settings_.last_stage == Stage::kRelief &&
         photo_.masked && (relief_aside_ || relief_.state() != ReliefState::kAdopted);
}

void Tracker::inflate(double share) {
  inflation_ = share;
  if (may_be_solid()) relief_.inflate_model(share, photo_);
}

// What was learned may be wrong, or may not be what is seen from here: every second frame of a search does
// without.
void Tracker::lay_relief_aside() {
  if (kind_ != TargetKind::kPhoto || relief_.state() != ReliefState::kAdopted) return;
  relief_aside_ = true;
  with_relief_ = photo_;
  relief_.lay_aside(photo_);
}

void Tracker::take_relief_up() {
  if (!relief_aside_) return;
  relief_aside_ = false;
  photo_ = with_relief_;
}

// What was found without the relief, refined on it, unless it is recognized without it only: then the relief
// is of something else.
Transform Tracker::with_or_without_relief(const Transform& T_H_M) {
  assess_photo(T_H_M);
  const bool found_without = confidence_of(T_H_M) >= kFound;
  take_relief_up();
  Transform T_on_relief = T_H_M;
  refine_photo_pose(photo_, rig_, colour_left_, colour_right_, kCoarsePass, workspace_, T_on_relief);
  T_on_relief = finely_refined(T_on_relief);
  assess_photo(T_on_relief);
  const bool found_with = confidence_of(T_on_relief) >= kFound;
  if (found_with || !found_without) return T_on_relief;
  relief_.give_back(photo_);
  inflate(inflation_);
  return T_H_M;
}

// Where a relief is adopted, the pose moves to where the target is on it: what was flat was biased. A solid
// too thick to be recognized by the flat model is learned all the same, from where it is found again and
// again; its relief then has to make it recognized.
void Tracker::learn_relief(Transform& T_H_M) {
  if (kind_ != TargetKind::kPhoto || is_thesis() || settings_.last_stage != Stage::kRelief) return;
  const bool tracked = confidence_of(T_H_M) >= kFound;
  const bool followed = following_ || is_confirmed(T_H_M);
  const bool adopted = relief_.state() == ReliefState::kAdopted;
  if (!tracked && adopted) {
    if (relief_.is_young()) relief_.give_back(photo_);  // perhaps of something else
    return;
  }
  if (!tracked && !alike(T_H_M, T_H_M_last_)) {
    // Nothing to learn; the same work all the same.
    (void)relief_.observe(rig_, colour_left_, colour_right_, photo_, T_H_M, followed);
    relief_.drop();
    return;
  }
  const Transform T_H_M_before = T_H_M;
  switch (relief_.observe(rig_, colour_left_, colour_right_, photo_, T_H_M, followed)) {
    case ReliefAdvice::kKeep: return;
    case ReliefAdvice::kAdopt:
      relief_.adopt(photo_, T_H_M);
      assess_photo(T_H_M);
      if (!tracked || confidence_of(T_H_M) >= kFound) return;
      // What the target is not recognized by any more is not its relief.
      relief_.give_back(photo_);
      inflate(inflation_);
      T_H_M = T_H_M_before;
      break;
    case ReliefAdvice::kGiveBack:
      relief_.give_back(photo_);
      T_H_M = finely_refined(best_inflation(relief_.flat_pose()));
      break;
  }
  assess_photo(T_H_M);
}

}  // namespace vergence
