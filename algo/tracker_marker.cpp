// The marker within the tracker: which guesses are fitted, and how sure it is.
#include "algo/pose_covariance.hpp"
#include "algo/tracker_parts.hpp"
#include "algo/trigonometry.hpp"

namespace vergence {
namespace {

constexpr int kMarkerGuesses = 3;
constexpr double kExpectedShare = 0.3;  // of the contour points

constexpr Certainty kThesisMarkerFitness{0.55, 1.25};  // of 180/108
// Of the share of contour points with an edge where it should be. No clutter reached a third; with one ball
// wrong it is two thirds at most, and so it can be of a marker followed behind a bar.
constexpr Certainty kMarkerFound{0.45, 0.99};
constexpr Certainty kMarkerFollowed{0.25, 0.65};
constexpr Certainty kMarkerLeastBall{0, 0.7};  // to be found; while it is followed, a ball may be hidden

// Of [x y z e1 e2 e3]. What no outline tells is as uncertain as a search box. Noise is half of it: edges are
// shifted by shading as well, alike in every frame.
Matrix6 covariance_of(const MarkerFit& fit) {
  constexpr double kBox_mm = 200;
  constexpr double kBox_rad = 1;
  constexpr double kErrorOverNoise = 2;  // of variances
  Matrix6 information = fit.information / kErrorOverNoise;
  for (int k = 0; k < 6; ++k) information(k, k) += 1 / (k < 3 ? kBox_mm * kBox_mm : kBox_rad * kBox_rad);
  return pose_covariance(information, fit.T_H_M);
}

}  // namespace

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

Matrix6 Tracker::marker_covariance() const {
  return covariance_of(marker_fit_);
}

double Tracker::marker_confidence_of(const Transform& T_H_M) const {
  if (is_thesis() || settings_.last_stage == Stage::kEvolved) {
    return share_of(fitness_at(to_pose(T_H_M)), kThesisMarkerFitness);
  }
  const MarkerEvidence& evidence = marker_fit_.evidence;
  if (following_) return share_of(evidence.share, kMarkerFollowed);
  if (!about_in(settings_.box, to_pose(T_H_M))) return 0;
  const double all = share_of(evidence.share, kMarkerFound);
  const double least = share_of(evidence.least_ball, kMarkerLeastBall);
  return all < least ? all : least;
}

}  // namespace vergence
