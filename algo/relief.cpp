// How a relief is learned, frame by frame, and when it is adopted.
#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "algo/hue.hpp"
#include "algo/inflation.hpp"
#include "algo/relief_parts.hpp"

namespace vergence {
namespace {

// The frames of learning: the first at quarter resolution, so that depths are pulled in from far, some at
// half.
constexpr int kHalfFrames = 3;  // up to here at half resolution
constexpr int kLearningFrames = 50;
constexpr int kFirstTries = 4;  // frames that are learned from as the first
// Where each of them starts beside the flat model's pose, for patterns that repeat; the last is there itself.
constexpr std::array<double, kFirstTries> kAside_mm = {0, -2.5, 2.5, 0};
constexpr int kFirstSteps = 6;  // of Gauss-Newton, in the first frame
constexpr int kHalfSteps = 6;   // at half resolution
// A relief in use is young until here: it takes the place of the one before wherever that explains a frame
// better, and is learned from nothing again at the better pose.
constexpr int kYoungFrames = 6;
constexpr double kAnewBetter = 0.95;  // of the cost: then what was learned anew takes the place
// In one of those frames from other tilts: the flat model may have been found far from the right one.
constexpr int kTiltFrame = 3;
constexpr double kTilt_e = 0.3;
constexpr std::array<std::array<double, 2>, 4> kTilts{
    {{kTilt_e, 0}, {-kTilt_e, 0}, {0, kTilt_e}, {0, -kTilt_e}}};
constexpr int kBetterInARow = 3;
constexpr double kFirstBetter = 0.78;    // of the cost of the flat model, on the frame it was learned from
constexpr double kFirstGain = 0.25;      // of the cost, there
constexpr double kClearlyBetter = 0.85;  // of the cost of the flat model, on frames it was not learned from
constexpr double kLeastGain = 0.2;       // of the cost, where 3 is no likeness at all
constexpr double kNoneWorse = 1.2;       // of the cost of each pairing
constexpr double kAnyBetter = 0.995;     // once there is a relief

constexpr int kLeastPoints = 64;
constexpr double kLeastTarget = 0.3;   // of S_in
constexpr double kLeastSpread_mm = 1;  // a relief less deep is noise

constexpr double kMaxRelief_mm = 80;
constexpr double kMaxStep_mm = 8;
constexpr double kMaxTurn_rad = 0.05;
constexpr int kPoseSteps = 2;
constexpr int kFlatSteps = 6;
constexpr double kShare = 0.6;  // of a step of depth, at full resolution

// Depths tried: all of them each frame at first, then some each frame.
constexpr int kSweepFrames = 5;
constexpr int kMiddleHypothesis = kReliefHypotheses / 2;
constexpr int kSweepPerFrame = kReliefHypotheses / kSweepFrames;
static_assert(kSweepFrames * kSweepPerFrame == kReliefHypotheses);
constexpr int kSweepLevel = 1;
constexpr int kSweepRounds = 3;
constexpr double kSweepStep_mm = 3;
constexpr int kLastSweep = kHalfFrames + 3 * kSweepFrames;  // until then depths are tried again and again
constexpr double kJump = 0.95;  // of the cost of the depth it has: a point goes to another one below that
constexpr double kPlaneOutlier_mm = 8;  // off the plane through all depths

// Seen more from the side than before by so much, a relief in use is left as it is; by so much less, it is
// learned anew. Chords of the unit sphere.
constexpr double kMoreAside = 0.1;
constexpr double kLessAside = 0.15;
constexpr int kSteady = 5;  // frames that show the same view
constexpr int kAgain = 1;   // goes on as after so many frames

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

Vector3 unit(const Vector3& v) {
  return v / std::sqrt(v.squaredNorm() + 1e-12);
}

// As in refinement: the increment is [translation; rotation vector] in the target frame.
void move_by(const Vector6& step, Transform& T) {
  const Vector3 move = limited(step.head<3>(), kMaxStep_mm);
  const Vector3 turn = limited(step.tail<3>(), kMaxTurn_rad);
  T = T * Transform{rotation_from_quaternion_vector(turn * 0.5), move};
  T.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T.R));
}

// What a target is like shows in all pairings. Where a photo is not what its camera is said to have seen
// (cropped, say), a relief that explains two of them better spoils the third.
bool none_worse(const std::array<double, 3>& learned, const std::array<double, 3>& flat) {
  bool none = true;
  for (std::size_t k = 0; k < flat.size(); ++k) none &= learned[k] <= kNoneWorse * flat[k];
  return none;
}

}  // namespace

const char* to_string(ReliefState state) {
  switch (state) {
    case ReliefState::kFlat: return "flat";
    case ReliefState::kLearning: return "learning";
    case ReliefState::kAdopted: return "adopted";
  }
  return "unknown";
}

bool Relief::learning() const {
  return frames_ < kLearningFrames && points_ >= kLeastPoints;
}

bool Relief::is_early() const {
  return frames_ < kYoungFrames;
}

bool Relief::is_young() const {
  return is_early() && !again_;
}

void Relief::drop() {
  about_mm_.fill(0);
  state_ = ReliefState::kFlat;
  frames_ = 0;
  tries_ = 0;
  again_ = false;
  better_ = 0;
  forget_depths();
}

void Relief::forget_depths() {
  T_M_C_ = Transform{};
  for (int i = 0; i < points_; ++i) z_mm_[at(i)] = static_cast<double>(about_mm_[at(i)]);
  known_.fill(0);
}

void Relief::start(const PhotoModel& flat) {
  photo_view_ = unit(flat.optical_centre_mm);
  points_ = flat.inner < kMaxReliefPoints ? flat.inner : kMaxReliefPoints;
  drop();
  target_points_ = 0;
  const int tolerance = hue_tolerance_steps(20);
  for (int i = 0; i < points_; ++i) {
    x_mm_[at(i)] = flat.x_mm[at(i)];
    y_mm_[at(i)] = flat.y_mm[at(i)];
    flat_weight_[at(i)] = flat.weight[at(i)];
    const Vector3 from_centre = Vector3{x_mm_[at(i)], y_mm_[at(i)], 0} - flat.optical_centre_mm;
    ray_x_[at(i)] = from_centre[0] / from_centre[2];
    ray_y_[at(i)] = from_centre[1] / from_centre[2];
    flat_x_mm_[at(i)] = flat.x_mm[at(i)];
    flat_y_mm_[at(i)] = flat.y_mm[at(i)];
    flat_ray_x_[at(i)] = static_cast<float>(ray_x_[at(i)]);
    flat_ray_y_[at(i)] = static_cast<float>(ray_y_[at(i)]);
    const bool like_background = hue_distance(flat.hue[at(i)], flat.background_hue) <= tolerance;
    const bool target = flat.masked ? flat.weight[at(i)] != 0 : !like_background;
    is_target_[at(i)] = target ? 1 : 0;
    target_points_ += is_target_[at(i)];
  }
  // A target of the background's own colour is not told from it by hue.
  if (target_points_ < kLeastTarget * points_) {
    for (int i = 0; i < points_; ++i) is_target_[at(i)] = 1;
    target_points_ = points_;
  }
  shade_.start(flat_x_mm_.data(), flat_y_mm_.data(), points_);
  for (int i = 0; i < points_; ++i) {
    std::array<double, kReliefNeighbours> nearest;
    nearest.fill(1e30);
    auto& mine = neighbour_[at(i)];
    mine.fill(static_cast<std::int16_t>(i));
    for (int j = 0; j < points_; ++j) {
      if (j == i) continue;
      const double dx = x_mm_[at(j)] - x_mm_[at(i)];
      const double dy = y_mm_[at(j)] - y_mm_[at(i)];
      double squared = dx * dx + dy * dy;
      auto index = static_cast<std::int16_t>(j);
      for (unsigned k = 0; k < kReliefNeighbours; ++k) {
        if (squared >= nearest[k]) continue;
        const double swap = nearest[k];
        nearest[k] = squared;
        squared = swap;
        const std::int16_t swap_index = mine[k];
        mine[k] = index;
        index = swap_index;
      }
    }
  }
  start_slopes();
  inflated_mm_.fill(0);
  if (flat.masked) inflate(points_, x_mm_, y_mm_, is_target_, inflated_mm_);
  find_slopes(inflated_mm_, inflated_slopes_);
}

// Of what the views show at the level of the sweep: how badly the three of a point agree, robustly. In single
// precision, four channels side by side, of which the last is zero: compilers make vectors of that.
float Relief::misfit(const std::array<Light, 3>& lights, int i) const {
  using Four = std::array<float, 4>;
  const ReliefSample& l = left_[at(i)];
  const ReliefSample& r = right_[at(i)];
  const auto disagreement = [](const Light& light, const Four& a, const Four& b, double seen) {
    const auto gain = static_cast<float>(light.gain);
    const auto per_scale = static_cast<float>(1 / light.scale);
    Four part;
    for (unsigned c = 0; c < 4; ++c) {
      const float residual = (a[c] - gain * b[c] - static_cast<float>(light.offset[c])) * per_scale;
      const float squared = residual * residual;
      part[c] = squared / (1 + squared);
    }
    return seen > 0 ? part[0] + part[1] + part[2] : 3.0F;
  };
  const float sum = disagreement(lights[0], l.value, photo_[at(i)], l.seen) +
                    disagreement(lights[1], r.value, photo_[at(i)], r.seen) +
                    disagreement(lights[2], l.value, r.value, l.seen * r.seen);
  return is_target_[at(i)] > 0 ? sum : 0.0F;
}

// Over neighbours, some times.
void Relief::average(std::array<float, kMaxReliefPoints>& of_points) {
  for (int round = 0; round < kSweepRounds; ++round) {
    for (int i = 0; i < points_; ++i) {
      double sum = of_points[at(i)];
      double weight = is_target_[at(i)];
      for (const std::int16_t j : neighbour_[at(i)]) {
        sum += of_points[at(j)];
        weight += is_target_[at(j)];
      }
      product_[at(i)] = weight > 0 ? sum / weight : 0;
    }
    for (int i = 0; i < points_; ++i)
      of_points[at(i)] = static_cast<float>(is_target_[at(i)] * product_[at(i)]);
  }
}

// Tries some depths for all points at once, and keeps how badly each explains each point. Once all have been
// tried, points go to the depth that their neighbourhood likes best: far enough into the valley for
// Gauss-Newton. The first time the flat model's pose is still biased, and a repeated pattern may fit one
// stripe beside; tried again at a better pose it does not.
void Relief::sweep(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                   const PhotoModel& model, const Transform& T_H_C, int first, int count) {
  const bool is_last = first + count == kReliefHypotheses;
  look(rig, left, right, kSweepLevel, model, z_mm_, T_H_C);
  const std::array<Light, 3> lights = light_;
  if (is_last) {
    for (int i = 0; i < points_; ++i) kept_[at(i)] = misfit(lights, i);
  }
  for (int h = first; h < first + count; ++h) {
    glance(rig, left, right, kSweepLevel, model, kSweepStep_mm * (h - kMiddleHypothesis), T_H_C);
    for (int i = 0; i < points_; ++i) sweep_[at(h)][at(i)] = misfit(lights, i);
  }
  if (!is_last) return;
  for (auto& costs : sweep_) average(costs);
  average(kept_);
  const double jump = is_anew_ ? 1 : kJump;  // as it was, where nothing tells
  for (int i = 0; i < points_; ++i) {
    int best = kMiddleHypothesis;
    for (int h = 0; h < kReliefHypotheses; ++h) {
      if (sweep_[at(h)][at(i)] < sweep_[at(best)][at(i)]) best = h;
    }
    if (sweep_[at(best)][at(i)] < jump * kept_[at(i)]) {
      z_mm_[at(i)] = static_cast<double>(about_mm_[at(i)]) + kSweepStep_mm * (best - kMiddleHypothesis);
    }
  }
}

// The plane through all depths says how the pose is off rather than what the target is like: takes it out of
// them, robustly, and returns the pose that has it instead.
Transform Relief::take_plane_out() {
  constexpr int kRounds = 4;
  Vector3 plane = Vector3::Zero();  // z = plane . (1, x, y)
  const auto place = [this](int i) { return Vector3{1, x_mm_[at(i)], y_mm_[at(i)]}; };
  for (int round = 0; round < kRounds; ++round) {
    Matrix3 N = 1e-6 * Matrix3::Identity();
    Vector3 q = Vector3::Zero();
    for (int i = 0; i < points_; ++i) {
      const Vector3 p = place(i);
      const double off = round == 0 ? 0 : (z_mm_[at(i)] - plane.dot(p)) / kPlaneOutlier_mm;
      const double w = is_target_[at(i)] / (1 + off * off);
      N += w * p * p.transpose();
      q += w * z_mm_[at(i)] * p;
    }
    plane = N.ldlt().solve(q);
  }
  for (int i = 0; i < points_; ++i) z_mm_[at(i)] -= plane.dot(place(i));
  const double cosine = 1 / std::sqrt(1 + plane[1] * plane[1] + plane[2] * plane[2]);
  return {rotation_from_quaternion_vector(Vector3{plane[2], -plane[1], 0} * (0.5 * cosine)),
          {0, 0, plane[0]}};
}

// Gauss-Newton over pose and depths.
void Relief::improve(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right, int level,
                     const PhotoModel& model, int steps, double share, Transform& T_H_C) {
  for (int step = 0; step < steps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise();
    for (int i = 0; i < points_; ++i) known_[at(i)] += 0.2 * (data_[at(i)] - known_[at(i)]);
    add_priors();
    move_by(solve_jointly(), T_H_C);
    for (int i = 0; i < points_; ++i) {
      const double dz = clamped(dz_mm_[at(i)], -kMaxStep_mm, kMaxStep_mm);
      z_mm_[at(i)] = clamped(z_mm_[at(i)] + share * dz, -kMaxRelief_mm, kMaxRelief_mm);
    }
  }
}

// From nothing, near the pose T_H_C, which follows: depths tried one by one, then Gauss-Newton. Returns the
// cost.
double Relief::learn_anew(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                          const PhotoModel& model, Transform& T_H_C) {
  forget_depths();
  is_anew_ = true;
  sweep(rig, left, right, model, T_H_C, 0, kReliefHypotheses);
  T_H_C = T_H_C * take_plane_out();
  improve(rig, left, right, kReliefFirstLevel, model, kFirstSteps, 1, T_H_C);
  is_anew_ = false;
  look(rig, left, right, kReliefFirstLevel, model, z_mm_, T_H_C);
  return cost();
}

// What was learned at the flat model's pose has the tilt in it that the flat model was wrong by, and
// improving it does not always lose that. Beginning at T_H_start, a first relief may come out better.
void Relief::try_anew(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                      const PhotoModel& model, const Transform& T_H_start, Transform& T_H_C) {
  look(rig, left, right, kReliefFirstLevel, model, z_mm_, T_H_C);
  const double before = cost();
  before_z_mm_ = z_mm_;
  before_known_ = known_;
  Transform T_anew = T_H_start;
  if (learn_anew(rig, left, right, model, T_anew) < kAnewBetter * before) {
    T_H_C = T_anew;
  } else {
    z_mm_ = before_z_mm_;
    known_ = before_known_;
  }
}

double Relief::cost_in_use(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                           int level, const PhotoModel& model, const Transform& T_H_M) {
  Points& in_use = product_;
  for (int i = 0; i < points_; ++i) in_use[at(i)] = model.z_mm[at(i)];
  look(rig, left, right, level, model, in_use, T_H_M);
  return cost();
}

// Of the flat model, from the pose T_H_M on; leaves its pose in T_H_F_.
double Relief::flat_cost(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                         int level, const PhotoModel& model, const Transform& T_H_M) {
  Points& flat = before_z_mm_;
  flat.fill(0);
  T_H_F_ = T_H_M;
  for (int step = 0; step < kFlatSteps; ++step) {
    look(rig, left, right, level, model, flat, T_H_F_);
    linearise();
    move_by(solve_pose(), T_H_F_);
  }
  look(rig, left, right, level, model, flat, T_H_F_);
  return cost();
}

double Relief::spread_mm() const {
  double squares = 0;
  for (int i = 0; i < points_; ++i) squares += is_target_[at(i)] * z_mm_[at(i)] * z_mm_[at(i)];
  return std::sqrt(squares / (target_points_ > 1 ? target_points_ : 1));
}

// From where the eyes see it: the direction from its origin to the middle between them.
Vector3 Relief::view(const StereoRig& rig, const Transform& T_H_M) const {
  return unit(T_H_M.inverse() * Vector3(0.5 * (rig.left.T_H_C.t_mm + rig.right.T_H_C.t_mm)));
}

ReliefAdvice Relief::observe(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                             const PhotoModel& model, const Transform& T_H_M, bool followed) {
  // From the side the eyes do not see all that the photo shows. What they see instead would be learned, if
  // they saw it frame after frame.
  const Vector3 view_now = view(rig, T_H_M);
  const double aside = std::sqrt((view_now - photo_view_).squaredNorm());
  steady_ = (view_now - last_view_).squaredNorm() < kMoreAside * kMoreAside ? steady_ + 1 : 0;
  last_view_ = view_now;
  if (state_ == ReliefState::kAdopted && !is_early()) {
    if (steady_ > 0 && aside > aside_ + kMoreAside) return ReliefAdvice::kKeep;
    if (steady_ >= kSteady && aside < aside_ - kLessAside) {
      frames_ = kAgain;
      again_ = true;
    }
  }
  if (!learning()) return ReliefAdvice::kKeep;
  if (is_early() || (steady_ >= kSteady && aside < aside_)) aside_ = aside;
  if (state_ == ReliefState::kFlat) state_ = ReliefState::kLearning;
  Transform T_H_C = T_H_M * T_M_C_;
  if (frames_ == 0) {
    for (int i = 0; i < points_; ++i) about_mm_[at(i)] = model.z_mm[at(i)];
    T_H_C = T_H_C * Transform{Matrix3::Identity(), {kAside_mm[at(tries_)], 0, 0}};
    const double learned = learn_anew(rig, left, right, model, T_H_C);
    const PairingCosts learned_costs = costs();
    const double in_use = cost_in_use(rig, left, right, kReliefFirstLevel, model, T_H_M);
    T_M_C_ = T_H_M.inverse() * T_H_C;
    const bool good = learned < kFirstBetter * in_use && in_use - learned > kFirstGain &&
                      none_worse(learned_costs, costs()) && spread_mm() >= kLeastSpread_mm;
    // The flat model's pose may have settled badly: from that of another frame, or from a little beside, it
    // may do better. What is learned beside is taken where it is good at once, and no risk is taken on it
    // otherwise.
    if (good || ++tries_ == kFirstTries) {
      ++frames_;
    } else {
      forget_depths();
    }
    return good ? ReliefAdvice::kAdopt : ReliefAdvice::kKeep;
  }
  const bool half = frames_ < kHalfFrames;
  const int level = half ? 1 : 0;

  // The model in use explains this frame so well:
  const double in_use = cost_in_use(rig, left, right, level, model, T_H_M);
  const PairingCosts in_use_costs = costs();
  const bool adopted = state_ == ReliefState::kAdopted;
  // A relief that was adopted at a wrong pose explains that. At the right one the flat model may do as well.
  const bool revise = followed && is_early();
  const bool flat_will_do =
      revise && (in_use > kClearlyBetter * flat_cost(rig, left, right, level, model, T_H_M)) & adopted;
  // And what was learned from earlier ones, after its pose has settled on this one:
  for (int step = 0; step < kPoseSteps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise();
    move_by(solve_pose(), T_H_C);
  }
  look(rig, left, right, level, model, z_mm_, T_H_C);
  const double learned = cost();
  const double limit = adopted ? kAnyBetter : kClearlyBetter;
  const bool clearly = (in_use - learned > kLeastGain) & none_worse(costs(), in_use_costs);
  const bool better = (learned < limit * in_use) & (adopted | clearly);
  better_ = better ? better_ + 1 : 0;

  if (revise) try_anew(rig, left, right, model, T_H_C, T_H_C);
  if (revise && frames_ == kTiltFrame) {
    const Transform T_H_before = T_H_C;
    for (const auto& [e1, e2] : kTilts) {
      const Transform tilt{rotation_from_quaternion_vector(Vector3{e1, e2, 0}), Vector3::Zero()};
      try_anew(rig, left, right, model, T_H_before * tilt, T_H_C);
    }
  }
  improve(rig, left, right, level, model, half ? kHalfSteps : 1, half ? 1 : kShare, T_H_C);
  if (half) {
    sweep(rig, left, right, model, T_H_C, 0, kReliefHypotheses);
  } else if (frames_ < kLastSweep) {
    sweep(rig, left, right, model, T_H_C, (frames_ - kHalfFrames) % kSweepFrames * kSweepPerFrame,
          kSweepPerFrame);
  }
  T_M_C_ = T_H_M.inverse() * T_H_C;
  const int in_a_row = adopted && is_early() ? 1 : kBetterInARow;
  ++frames_;
  if (flat_will_do) return ReliefAdvice::kGiveBack;
  const bool adopt = better_ >= in_a_row && spread_mm() >= kLeastSpread_mm;
  return adopt ? ReliefAdvice::kAdopt : ReliefAdvice::kKeep;
}

void Relief::lay_aside(PhotoModel& model) const {
  inflate_model(0, model);
  for (int i = 0; i < points_; ++i) model.weight[at(i)] = flat_weight_[at(i)];
}

void Relief::give_back(PhotoModel& model) {
  lay_aside(model);
  drop();
}

void Relief::adopt(PhotoModel& model, Transform& T_H_M) {
  Slopes slopes;
  find_slopes(z_mm_, slopes);
  set_depths(z_mm_, slopes, 1, model);
  for (int i = 0; i < points_; ++i) model.weight[at(i)] = is_target_[at(i)] > 0 ? 1 : 0;
  state_ = ReliefState::kAdopted;
  better_ = 0;
  T_H_M = T_H_M * T_M_C_;
  T_M_C_ = Transform{};
}

}  // namespace vergence
