#include "tools/rig/rig_world.hpp"

#include <utility>

#include "hal/clock.hpp"

namespace vergence::rig {
namespace {

// Offsets in devices.env: step and direction of each motor, then the enable line.
constexpr int kEnableLine = 2 * kPanTiltMotors;

plant::PanTiltOptions motors_of(const std::array<double, kPanTiltMotors>& steps_per_rad) {
  plant::PanTiltOptions options;
  for (std::size_t i = 0; i < steps_per_rad.size(); ++i) options.motor[i].steps_per_rad = steps_per_rad[i];
  return options;
}

void note_shortest(std::int64_t& shortest_ns, std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns < 0) return;
  const std::int64_t time_ns = to_ns - from_ns;
  if (shortest_ns < 0 || time_ns < shortest_ns) shortest_ns = time_ns;
}

}  // namespace

EyeMotors::EyeMotors(const std::array<double, kPanTiltMotors>& steps_per_rad)
    : motors_(motors_of(steps_per_rad)) {}

void EyeMotors::take(const Edge& edge) {
  ++edges_;
  if (edge.line == kEnableLine) {
    enabled_ = edge.level;
    motors_.enable(enabled_);
    return;
  }
  if (edge.line < 0 || edge.line > kEnableLine) return;
  Line& line = lines_[static_cast<std::size_t>(edge.line / 2)];
  if (edge.line % 2 == 1) {
    line.is_forward = edge.level;
    line.turned_ns = edge.stamp_ns;
    return;
  }
  if (edge.level) {
    note_shortest(times_.low_ns, line.changed_ns, edge.stamp_ns);
    note_shortest(times_.setup_ns, line.turned_ns, edge.stamp_ns);
    if (enabled_) line.pulses += line.is_forward ? 1 : -1;
  } else {
    note_shortest(times_.high_ns, line.changed_ns, edge.stamp_ns);
  }
  line.is_high = edge.level;
  line.changed_ns = edge.stamp_ns;
}

void EyeMotors::advance(std::int64_t dt_ns) {
  std::array<double, kPanTiltMotors> rates{};
  for (std::size_t i = 0; i < rates.size(); ++i) {
    rates[i] = static_cast<double>(std::exchange(lines_[i].pulses, 0)) / seconds(dt_ns);
  }
  motors_.command(rates);
  motors_.advance(dt_ns);
}

RigWorld::RigWorld(render::Scene scene, const SerialArm& arm, const Transform& T_W_S)
    : scene_(std::move(scene)), arm_(arm), T_W_S_(T_W_S) {}

Transform RigWorld::T_W_H(const plant::JointArray& joints_rad) const {
  const JointVector q = Eigen::Map<const JointVector>(joints_rad.data());
  return forward_kinematics(arm_, q).T_W_H;
}

Transform RigWorld::T_W_M(double t_s) const {
  return T_W_S_ * to_transform(scene_.target_motion.at(t_s));
}

render::SceneState RigWorld::state(double t_s, const Transform& T_W_H, const EyeAngles& eyes) const {
  render::SceneState state = render::state_at(scene_, t_s);
  const Transform T_S_H = T_W_S_.inverse() * T_W_H;
  for (render::SceneMoment& moment : state.moments) {
    moment.T_W_H = T_S_H;
    moment.eyes = eyes;
  }
  return state;
}

}  // namespace vergence::rig
