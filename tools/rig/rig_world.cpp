#include "tools/rig/rig_world.hpp"

#include <algorithm>
#include <utility>

#include "hal/clock.hpp"

namespace vergence::rig {
namespace {

// Offsets in devices.env: step and direction of each motor, then the enable line.
constexpr int kEnableLine = 2 * kPanTiltMotors;

constexpr std::int64_t kAtRest_ns = 10'000'000;  // without a pulse
constexpr std::int64_t kShortest_ns = 1'000;

plant::Stepper motor_of(double steps_per_rad) {
  plant::StepperOptions options;
  options.steps_per_rad = steps_per_rad;
  return plant::Stepper(options);
}

void note_shortest(std::int64_t& shortest_ns, std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns < 0) return;
  const std::int64_t time_ns = to_ns - from_ns;
  if (shortest_ns < 0 || time_ns < shortest_ns) shortest_ns = time_ns;
}

}  // namespace

EyeMotors::EyeMotors(const std::array<double, kPanTiltMotors>& steps_per_rad)
    : motors_{motor_of(steps_per_rad[0]), motor_of(steps_per_rad[1]), motor_of(steps_per_rad[2])} {}

void EyeMotors::take(const Edge& edge) {
  ++edges_;
  if (edge.line == kEnableLine) enabled_ = edge.level;
  if (edge.line < 0 || edge.line >= kEnableLine) return;
  const auto index = static_cast<std::size_t>(edge.line / 2);
  Line& line = lines_[index];
  if (edge.line % 2 == 1) {
    line.is_forward = edge.level;
    line.turned_ns = edge.stamp_ns;
    return;
  }
  if (edge.level) {
    note_shortest(times_.low_ns, line.changed_ns, edge.stamp_ns);
    note_shortest(times_.setup_ns, line.turned_ns, edge.stamp_ns);
    if (enabled_) {
      const double dt_s = seconds(std::max(edge.stamp_ns - line.moved_to_ns, kShortest_ns));
      motors_[index].advance((line.is_forward ? 1 : -1) / dt_s, dt_s);
      line.moved_to_ns = edge.stamp_ns;
    }
  } else {
    note_shortest(times_.high_ns, line.changed_ns, edge.stamp_ns);
  }
  line.changed_ns = edge.stamp_ns;
}

void EyeMotors::advance(std::int64_t now_ns) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    Line& line = lines_[i];
    if (!enabled_) motors_[i].stop();
    if (now_ns - line.moved_to_ns < kAtRest_ns) continue;
    motors_[i].advance(0, seconds(now_ns - line.moved_to_ns));
    line.moved_to_ns = now_ns;
  }
}

EyeAngles EyeMotors::angles() const {
  return {motors_[0].true_rad(), motors_[1].true_rad(), motors_[2].true_rad()};
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
