// How a relief is learned, frame by frame, and when it is adopted.
#include <Eigen/Cholesky>
#include <cmath>

#include "algo/hue.hpp"
#include "algo/relief_parts.hpp"

namespace vergence {
namespace {

// The frames of learning: the first kReliefCoarseFrames coarse, so that depths are pulled in from far.
constexpr int kMiddleFrames = 11;  // up to here at half resolution
constexpr int kLearningFrames = 60;
constexpr int kEarliestAdoption = 13;
constexpr int kBetterInARow = 3;
constexpr double kClearlyBetter = 0.85;  // of the cost of the model in use
constexpr double kLeastGain = 0.2;       // of the cost, where 3 is no likeness at all
constexpr double kAnyBetter = 0.995;     // once there is a relief

constexpr int kLeastPoints = 64;
constexpr double kLeastTarget = 0.3;   // of S_in
constexpr double kLeastSpread_mm = 1;  // a relief less deep is noise

constexpr double kMaxRelief_mm = 80;
constexpr double kMaxStep_mm = 8;
constexpr double kMaxTurn_rad = 0.05;
constexpr int kPoseSteps = 2;
constexpr int kSteps = 3;
constexpr double kShare = 0.6;

// Depths tried: some each frame, all of them every kSweepFrames.
constexpr int kSweepFrames = 5;
constexpr int kFlatHypothesis = kReliefHypotheses / 2;  // the one in the middle
constexpr int kSweepPerFrame = kReliefHypotheses / kSweepFrames;
static_assert(kSweepFrames * kSweepPerFrame == kReliefHypotheses);
constexpr int kSweepLevel = 1;
constexpr int kSweepRounds = 3;
constexpr double kSweepStep_mm = 3;
constexpr int kLastSweep = 25;  // frames; until then depths are tried again and again
constexpr double kJump = 0.95;  // of the cost of the depth it has: a point goes to another one below that
constexpr double kPlaneOutlier_mm = 8;  // off the plane through all depths

Vector3 limited(const Vector3& step, double limit) {
  const double length = std::sqrt(step.squaredNorm());
  return length > limit ? Vector3(step * (limit / length)) : step;
}

// As in refinement: the increment is [translation; rotation vector] in the target frame.
void move_by(const Vector6& step, Transform& T) {
  const Vector3 move = limited(step.head<3>(), kMaxStep_mm);
  const Vector3 turn = limited(step.tail<3>(), kMaxTurn_rad);
  T = T * Transform{rotation_from_quaternion_vector(turn * 0.5), move};
  T.R = rotation_from_quaternion_vector(quaternion_vector_from_rotation(T.R));
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

void Relief::drop() {
  if (state_ == ReliefState::kAdopted) return;
  state_ = ReliefState::kFlat;
  frames_ = 0;
  better_ = 0;
  T_M_C_ = Transform{};
  z_mm_.fill(0);
  known_.fill(0);
  trust_.fill(0);
}

void Relief::start(const PhotoModel& flat) {
  points_ = flat.inner < kMaxReliefPoints ? flat.inner : kMaxReliefPoints;
  state_ = ReliefState::kFlat;
  drop();
  target_points_ = 0;
  const int tolerance = hue_tolerance_steps(20);
  for (int i = 0; i < points_; ++i) {
    x_mm_[at(i)] = flat.x_mm[at(i)];
    y_mm_[at(i)] = flat.y_mm[at(i)];
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
}

// Of what look() saw at the level of the sweep: how badly the three views of a point agree, robustly.
float Relief::misfit(const PhotoModel& model, const std::array<Light, 3>& lights, int i) const {
  const ReliefSample& l = left_[at(i)];
  const ReliefSample& r = right_[at(i)];
  const std::array<float, 4> photo = photo_colour(model, kSweepLevel, i);
  double sum = 0;
  for (unsigned c = 0; c < 3; ++c) {
    const auto add = [&](const Light& light, double a, double b, double seen) {
      const double residual = (a - light.gain * b - light.offset[c]) / light.scale;
      const double squared = residual * residual;
      sum += seen > 0 ? squared / (1 + squared) : 1;
    };
    add(lights[0], l.value[c], photo[c], l.seen);
    add(lights[1], r.value[c], photo[c], r.seen);
    add(lights[2], l.value[c], r.value[c], l.seen * r.seen);
  }
  return static_cast<float>(is_target_[at(i)] * sum);
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

// Tries some depths for all points at once, and keeps how badly each explains each point. Every kSweepFrames
// frames all have been tried, and points go to the depth that their neighbourhood likes best: far enough into
// the valley for Gauss-Newton. The first time the flat model's pose is still biased, and a repeated pattern
// may fit one stripe beside; tried again at a better pose it does not.
void Relief::sweep(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                   const PhotoModel& model, const Transform& T_H_C) {
  const int first = frames_ % kSweepFrames * kSweepPerFrame;
  const bool is_last = first + kSweepPerFrame == kReliefHypotheses;
  look(rig, left, right, kSweepLevel, model, z_mm_, T_H_C);
  const std::array<Light, 3> lights = light_;
  if (is_last) {
    for (int i = 0; i < points_; ++i) kept_[at(i)] = misfit(model, lights, i);
  }
  Points& depth = product_;
  for (int h = first; h < first + kSweepPerFrame; ++h) {
    depth.fill(kSweepStep_mm * (h - kFlatHypothesis));
    look(rig, left, right, kSweepLevel, model, depth, T_H_C);
    for (int i = 0; i < points_; ++i) sweep_[at(h)][at(i)] = misfit(model, lights, i);
  }
  if (!is_last) return;
  for (auto& costs : sweep_) average(costs);
  average(kept_);
  const double jump = frames_ < kSweepFrames ? 1 : kJump;  // flat, where nothing tells
  for (int i = 0; i < points_; ++i) {
    int best = kFlatHypothesis;
    for (int h = 0; h < kReliefHypotheses; ++h) {
      if (sweep_[at(h)][at(i)] < sweep_[at(best)][at(i)]) best = h;
    }
    if (sweep_[at(best)][at(i)] < jump * kept_[at(i)])
      z_mm_[at(i)] = kSweepStep_mm * (best - kFlatHypothesis);
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

bool Relief::observe(const StereoRig& rig, const ColourPyramid& left, const ColourPyramid& right,
                     const PhotoModel& model, const Transform& T_H_M) {
  if (!learning()) return false;
  if (state_ == ReliefState::kFlat) state_ = ReliefState::kLearning;
  if (frames_ < kSweepFrames) {
    sweep(rig, left, right, model, T_H_M);
    if (++frames_ == kSweepFrames) T_M_C_ = take_plane_out();
    return false;
  }
  const int level = frames_ < kReliefCoarseFrames ? 2 : (frames_ < kMiddleFrames ? 1 : 0);

  // The model in use explains this frame so well:
  Points& in_use = product_;
  for (int i = 0; i < points_; ++i) in_use[at(i)] = model.z_mm[at(i)];
  look(rig, left, right, level, model, in_use, T_H_M);
  const double cost_in_use = cost();
  // And what was learned from earlier ones, after its pose has settled on this one:
  Transform T_H_C = T_H_M * T_M_C_;
  for (int step = 0; step < kPoseSteps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise(model, level);
    move_by(solve_pose(), T_H_C);
  }
  look(rig, left, right, level, model, z_mm_, T_H_C);
  const bool adopted = state_ == ReliefState::kAdopted;
  const double limit = adopted ? kAnyBetter : kClearlyBetter;
  ratio_ = cost() / (cost_in_use + 1e-9);
  const bool better = (ratio_ < limit) & (adopted | (cost_in_use - cost() > kLeastGain));
  better_ = better ? better_ + 1 : 0;

  const int steps = frames_ < kMiddleFrames ? kSteps : 1;
  for (int step = 0; step < steps; ++step) {
    look(rig, left, right, level, model, z_mm_, T_H_C);
    linearise(model, level);
    for (int i = 0; i < points_; ++i) known_[at(i)] += 0.2 * (data_[at(i)] - known_[at(i)]);
    add_priors();
    move_by(solve_jointly(), T_H_C);
    const double share = frames_ < kMiddleFrames ? 1 : kShare;
    for (int i = 0; i < points_; ++i) {
      const double dz = clamped(dz_mm_[at(i)], -kMaxStep_mm, kMaxStep_mm);
      z_mm_[at(i)] = clamped(z_mm_[at(i)] + share * dz, -kMaxRelief_mm, kMaxRelief_mm);
    }
  }
  if (frames_ < kLastSweep) sweep(rig, left, right, model, T_H_C);
  T_M_C_ = T_H_M.inverse() * T_H_C;
  double squares = 0;
  for (int i = 0; i < points_; ++i) squares += is_target_[at(i)] * z_mm_[at(i)] * z_mm_[at(i)];
  spread_mm_ = std::sqrt(squares / (target_points_ > 1 ? target_points_ : 1));
  ++frames_;
  return frames_ >= kEarliestAdoption && better_ >= kBetterInARow && spread_mm_ >= kLeastSpread_mm;
}

void Relief::adopt(PhotoModel& model, Transform& T_H_M) {
  for (int i = 0; i < points_; ++i) {
    const Vector3 ray = ray_of(model, x_mm_[at(i)], y_mm_[at(i)]);
    const Vector3 p = Vector3{x_mm_[at(i)], y_mm_[at(i)], 0} + z_mm_[at(i)] * ray;
    model.x_mm[at(i)] = static_cast<float>(p[0]);
    model.y_mm[at(i)] = static_cast<float>(p[1]);
    model.z_mm[at(i)] = static_cast<float>(p[2]);
    model.weight[at(i)] = is_target_[at(i)] > 0 ? 1 : 0;
  }
  state_ = ReliefState::kAdopted;
  better_ = 0;
  T_H_M = T_H_M * T_M_C_;
  T_M_C_ = Transform{};
}

}  // namespace vergence
