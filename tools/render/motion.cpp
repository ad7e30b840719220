#include "tools/render/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/render/random.hpp"

namespace vergence::render {
namespace {

Pose moved(const Pose& pose, const std::array<double, 6>& by, double factor) {
  Pose result = pose;
  for (int i = 0; i < 3; ++i) {
    result.position_mm[i] += by[static_cast<std::size_t>(i)] * factor;
    result.e[i] += by[static_cast<std::size_t>(i) + 3] * factor;
  }
  return result;
}

// Sine and cosine of an angle of any size.
SinCos turning(double angle_rad) {
  const double turns = angle_rad / (2 * std::numbers::pi);
  return sin_cos(2 * std::numbers::pi * (turns - std::floor(turns)));
}

// Starts at zero, rises first.
double triangle_wave(double phase_turns) {
  const double p = phase_turns + 0.25 - std::floor(phase_turns + 0.25);
  return p < 0.5 ? 4 * p - 1 : 3 - 4 * p;
}

Pose between(const PoseKey& a, const PoseKey& b, double t_s) {
  if (b.teleport || b.t_s <= a.t_s) return a.pose;
  const double t = std::clamp((t_s - a.t_s) / (b.t_s - a.t_s), 0.0, 1.0);
  Pose pose;
  pose.position_mm = a.pose.position_mm + t * (b.pose.position_mm - a.pose.position_mm);
  // Along the shorter arc, normalised.
  const auto eta = [](const Vector3& e) { return std::sqrt(std::max(0.0, 1 - e.squaredNorm())); };
  const double ea = eta(a.pose.e);
  const double eb = eta(b.pose.e);
  const double sign = a.pose.e.dot(b.pose.e) + ea * eb < 0 ? -1 : 1;
  const Vector3 e = (1 - t) * a.pose.e + t * sign * b.pose.e;
  const double w = (1 - t) * ea + t * sign * eb;
  pose.e = e / std::copysign(std::sqrt(e.squaredNorm() + w * w), w);
  return pose;
}

Pose along_keys(const std::vector<PoseKey>& keys, double t_s) {
  const auto next = std::upper_bound(keys.begin(), keys.end(), t_s,
                                     [](double t, const PoseKey& key) { return t < key.t_s; });
  if (next == keys.begin()) return keys.front().pose;
  if (next == keys.end()) return keys.back().pose;
  return between(*(next - 1), *next, t_s);
}

}  // namespace

Pose Motion::at(double t_s) const {
  switch (kind) {
    case Kind::kStill: return pose;
    case Kind::kSine: return moved(pose, amplitude, turning(omega_rad_s * t_s + phase_rad).sine);
    case Kind::kCosine: return moved(pose, amplitude, 1 - turning(omega_rad_s * t_s + phase_rad).cosine);
    case Kind::kSwing: {
      const double period_s = 4 * swing_rad / swing_rad_s;
      const double half = 0.5 * swing_rad * triangle_wave(t_s / period_s);
      const Transform turned{rotation_from_quaternion_vector({0, sin_cos(half).sine, 0}), Vector3::Zero()};
      const Transform T = to_transform(pose);
      return to_pose({turned.R * T.R, pivot_mm + turned.R * (T.t_mm - pivot_mm)});
    }
    case Kind::kKeys: return along_keys(keys, t_s);
    case Kind::kRandom: break;
  }
  constexpr std::uint64_t kDraws = 2000;  // then a pose is taken as it is
  const auto frame = static_cast<std::uint64_t>(std::max(0L, std::lround(t_s * fps)));
  Pose result;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    const std::uint64_t draw_seed = draw == 0 ? seed : hash(seed, draw);
    result = pose;
    for (int i = 0; i < 6; ++i) {
      const double by = amplitude[static_cast<std::size_t>(i)] *
                        (2 * uniform(draw_seed, 6 * frame + static_cast<std::uint64_t>(i)) - 1);
      (i < 3 ? result.position_mm[i] : result.e[i - 3]) += by;
    }
    if (!accepts || accepts(result)) break;
  }
  return result;
}

std::vector<PoseKey> twenty_steps(const Pose& centre, double rest_s) {
  constexpr double kSpeed_mm_s = 50;
  constexpr double kSpeed_rad_s = 10 * std::numbers::pi / 180;
  constexpr double kE = 0.174;
  constexpr double kTable[20][6] = {
      {0, 0, 0, 0, 0, 0},    {-50, 0, 0, 0, 0, 0}, {-50, -50, 0, 0, 0, 0}, {0, -50, 0, 0, 0, 0},
      {0, 0, 0, 0, 0, 0},    {0, 0, 50, 0, 0, 0},  {-50, 0, 50, 0, 0, 0},  {-50, -50, 50, 0, 0, 0},
      {0, -50, 50, 0, 0, 0}, {0, 0, 50, 0, 0, 0},  {0, 0, 0, 0, 0, 0},     {0, 0, 0, kE, 0, 0},
      {0, 0, 0, -kE, 0, 0},  {0, 0, 0, 0, 0, 0},   {0, 0, 0, 0, kE, 0},    {0, 0, 0, 0, -kE, 0},
      {0, 0, 0, 0, 0, 0},    {0, 0, 0, 0, 0, -kE}, {0, 0, 0, 0, 0, kE},    {0, 0, 0, 0, 0, 0}};
  std::vector<PoseKey> keys;
  double t_s = 0;
  for (const auto& row : kTable) {
    Pose pose = centre;
    pose.position_mm += Vector3(row[0], row[1], row[2]);
    pose.e = multiply_quaternion_vectors(centre.e, {row[3], row[4], row[5]});
    if (!keys.empty()) {
      const double way_mm = (pose.position_mm - keys.back().pose.position_mm).norm();
      const double turn_rad = 2 * (pose.e - keys.back().pose.e).norm();
      t_s += std::max(way_mm / kSpeed_mm_s, turn_rad / kSpeed_rad_s);
      keys.push_back({t_s, pose, false});
    }
    if (keys.empty()) keys.push_back({t_s, pose, false});
    t_s += rest_s;
    keys.push_back({t_s, pose, false});
  }
  return keys;
}

}  // namespace vergence::render
