// A world the controller cannot tell from the real one: it reads what was commanded from the simulated
// devices, moves arm and eyes by their physics, takes pictures, and puts what a driver would report into the
// devices. Virtual time, in lock-step: it knows no clock, and the same calls give the same bits.
//
// Scenes are set in a frame S of their own, in which the scene's target moves, lamps shine and the backdrop
// stands; T_W_S says where that is in the arm's world W.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "algo/arm_kinematics.hpp"
#include "hal/sim/sim_devices.hpp"
#include "tools/plant/arm_servo.hpp"
#include "tools/plant/camera_timing.hpp"
#include "tools/plant/state_history.hpp"
#include "tools/plant/stepper.hpp"
#include "tools/render/scene.hpp"

namespace vergence::plant {

// Arm, eyes and history move in steps of this.
inline constexpr std::int64_t kStep_ns = 1'000'000;

// T_W_M at a time in s.
using TargetPath = std::function<Transform(double)>;

struct WorldOptions {
  std::optional<SerialArm> arm;  // none: the hand stays where T_W_H says, and the arm device hears nothing
  ArmServoOptions servo;         // of the arm; its start is the hand's
  Transform T_W_H;               // of a hand without an arm
  PanTiltOptions eyes;
  CameraTimingOptions camera;
  Transform T_W_S;
  TargetPath target;   // empty: the scene's motion
  bool render = true;  // false: pairs are delivered without images
  std::uint64_t seed = 1;
};

// Frame rate, exposure, seed, and the eyes' angles at the start, as the scene has them; no arm.
[[nodiscard]] WorldOptions options_of(const render::Scene& scene);

// With the drives of that arm.
[[nodiscard]] WorldOptions options_of(const render::Scene& scene, const SerialArm& arm,
                                      const JointVector& start_rad);

// The controller's side of the world; they must outlive it.
struct Devices {
  sim::SimStereoCamera& camera;
  sim::SimArm& arm;
  sim::SimPanTilt& eyes;
};

class World {
 public:
  // The exposure is that of options.camera; it is averaged over scene.shutter_samples instants. The scene's
  // hand motion and eyes_on_target have no effect. Throws std::invalid_argument for options out of range.
  World(render::Scene scene, WorldOptions options, const Devices& devices);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Commands found in the devices hold for all whole steps up to t; feedback is of the last of them. Of the
  // pairs due by t the newest is delivered. Throws std::invalid_argument where t is in the past.
  void advance_to(std::int64_t t_ns);

  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }
  [[nodiscard]] const render::Scene& scene() const { return scene_; }

  // The truth, which the controller does not see; of the hand and eyes at the last whole step.
  [[nodiscard]] Transform T_W_H() const;
  [[nodiscard]] Transform T_W_M(double t_s) const;
  [[nodiscard]] Transform T_H_M() const;
  [[nodiscard]] bool has_arm() const { return servo_.has_value(); }
  [[nodiscard]] const JointArray& joints_rad() const { return servo_.value().true_position_rad(); }
  [[nodiscard]] double lost_steps(int motor) const { return eyes_.motor(motor).lost_steps(); }
  [[nodiscard]] EyeAngles eye_angles() const { return eyes_.true_angles(); }
  // Where the lines of sight meet, or are closest; none where they are parallel or meet behind the eyes.
  [[nodiscard]] std::optional<Vector3> gaze_point_W_mm() const;
  // At a time for which pictures may still be taken: from the oldest exposure not delivered yet to now.
  [[nodiscard]] HeadState head_at(std::int64_t t_ns) const { return history_.at(t_ns); }

  // From now on, also for pictures exposed before that are not delivered yet: paths should join.
  void set_target(TargetPath T_W_M_at) { options_.target = std::move(T_W_M_at); }
  // For blows, loads and faults. Throws std::logic_error without an arm.
  [[nodiscard]] ArmServo& arm();
  [[nodiscard]] PanTiltPlant& eyes() { return eyes_; }

  [[nodiscard]] std::uint64_t pairs_delivered() const { return pairs_delivered_; }
  [[nodiscard]] std::uint64_t pairs_lost() const { return pairs_lost_; }

 private:
  struct Shot {
    PairTiming timing;
    render::SceneState state;
  };

  void step();
  void take_commands();
  void deliver_feedback();
  void take_due(std::int64_t t_ns);
  void deliver_shot();
  [[nodiscard]] render::SceneState state_during(const PairTiming& timing) const;

  render::Scene scene_;
  WorldOptions options_;
  Devices devices_;
  std::optional<ArmServo> servo_;
  PanTiltPlant eyes_;
  CameraTiming timing_;
  StateHistory history_;
  std::int64_t now_ns_ = 0;
  std::int64_t stepped_to_ns_ = 0;
  std::uint64_t arm_commands_ = 0;  // seen
  std::uint64_t arm_requests_ = 0;
  std::uint64_t next_pair_ = 0;
  std::uint64_t pairs_delivered_ = 0;
  std::uint64_t pairs_lost_ = 0;
  std::optional<Shot> shot_;  // due, not developed yet
  // The controller may still look at the pair it took last; the next is put into the other place.
  struct Pair {
    tools::RgbImage left;
    tools::RgbImage right;
  };
  std::array<Pair, 2> pairs_;
  std::size_t place_ = 0;
};

}  // namespace vergence::plant
