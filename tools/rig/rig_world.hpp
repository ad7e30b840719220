// What the cameras see and where things are: the scene, the hand by the arm's joints, the eyes by the pulses
// on the GPIO lines.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "algo/arm_kinematics.hpp"
#include "tools/plant/arm_servo.hpp"
#include "tools/plant/stepper.hpp"
#include "tools/render/scene.hpp"
#include "tools/rig/trace_reader.hpp"

namespace vergence::rig {

// Shortest times seen between edges, of all motors; -1: there was none.
struct PulseTimes {
  std::int64_t high_ns = -1;
  std::int64_t low_ns = -1;
  std::int64_t setup_ns = -1;  // of the direction, before a step
};

// Each pulse is a step over the time since the one before. A motor that got none for a while is at rest.
class EyeMotors {
 public:
  explicit EyeMotors(const std::array<double, kPanTiltMotors>& steps_per_rad);

  void take(const Edge& edge);
  // Each millisecond, once the edges up to now were taken.
  void advance(std::int64_t now_ns);

  [[nodiscard]] EyeAngles angles() const;
  [[nodiscard]] bool is_enabled() const { return enabled_; }
  [[nodiscard]] std::int64_t issued_steps(std::size_t motor) const { return motors_[motor].issued_steps(); }
  [[nodiscard]] double lost_steps(std::size_t motor) const { return motors_[motor].lost_steps(); }
  [[nodiscard]] const PulseTimes& times() const { return times_; }
  [[nodiscard]] std::uint64_t edges() const { return edges_; }

 private:
  struct Line {
    bool is_forward = false;
    std::int64_t changed_ns = -1;
    std::int64_t turned_ns = -1;
    std::int64_t moved_to_ns = 0;
  };

  std::array<plant::Stepper, kPanTiltMotors> motors_;
  std::array<Line, kPanTiltMotors> lines_{};
  bool enabled_ = false;
  PulseTimes times_;
  std::uint64_t edges_ = 0;
};

class RigWorld {
 public:
  RigWorld(render::Scene scene, const SerialArm& arm, const Transform& T_W_S);

  // All poses in W.
  [[nodiscard]] Transform T_W_H(const plant::JointArray& joints_rad) const;
  [[nodiscard]] Transform T_W_M(double t_s) const;
  [[nodiscard]] const Transform& T_W_S() const { return T_W_S_; }
  [[nodiscard]] render::SceneState state(double t_s, const Transform& T_W_H, const EyeAngles& eyes) const;
  [[nodiscard]] const render::Scene& scene() const { return scene_; }

 private:
  render::Scene scene_;
  SerialArm arm_;
  Transform T_W_S_;
};

}  // namespace vergence::rig
