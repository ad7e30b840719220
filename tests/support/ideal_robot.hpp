// A robot that does what it is told, for tests of the controller: joints follow as a first-order lag or not
// at all, eyes count steps, and the target's pose is given frame by frame.
#pragma once

#include <cmath>
#include <functional>

#include "algo/pa10.hpp"
#include "firmware_like/pipeline.hpp"
#include "hal/sim/sim_devices.hpp"

namespace vergence::testing {

// The hand before the arm, looking along -x, as the thesis has it [4.1].
inline Transform start_of_hand() {
  Transform T;
  T.R << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  T.t_mm = {-690, 0, 485};
  return T;
}

inline RobotConfig config_of_robot() {
  RobotConfig config;
  config.relation.T_Ed_M.t_mm = {0, -100, 545};
  for (double& steps : config.eye_control.steps_per_rad) steps = 2546;
  return config;
}

class IdealRobot {
 public:
  explicit IdealRobot(const RobotConfig& config = config_of_robot()) : config_(config) {
    status = pipeline.configure_given(config);
    const Pa10Inverse inverse = inverse_pa10(config.arm, start_of_hand(), JointVector::Zero());
    const JointVector q = nearest_solution(config.arm, inverse, JointVector::Zero()).value();
    for (Eigen::Index i = 0; i < kMaxJoints; ++i) feedback.position_rad[static_cast<std::size_t>(i)] = q[i];
  }

  // One millisecond.
  void tick() {
    t_ns += 1'000'000;
    move();
    if (t_ns % config_.arm_period_ns == 0) {
      feedback.stamp_ns = t_ns;
      if (arm_answers) arm.deliver(feedback);
      pipeline.step_arm(t_ns, arm);
    }
    if (t_ns % 4'000'000 == 0) {
      eyes_feedback.stamp_ns = t_ns;
      for (std::size_t i = 0; i < 3; ++i) eyes_feedback.steps[i] = std::llround(steps_[i]);
      eyes.deliver(eyes_feedback);
      pipeline.step_eyes(t_ns, eyes);
    }
    if (t_ns % kFrame_ns == 0 && camera_answers) give();
  }
  void run(double duration_s) {
    for (const std::int64_t end_ns = t_ns + std::llround(duration_s * 1e9); t_ns < end_ns;) tick();
  }
  // On, and following: what an operator does first.
  void start() {
    run(0.1);
    pipeline.command(OperatorCommand::kArm);
    run(0.01);
    pipeline.command(OperatorCommand::kServo);
    run(0.01);
  }

  [[nodiscard]] Mode mode() const { return pipeline.supervisor().mode(); }
  [[nodiscard]] Transform T_W_H() const {
    return forward_kinematics(config_.arm, JointVector(feedback.position_rad.data())).T_W_H;
  }
  // Of the hand from where it is wanted.
  [[nodiscard]] double error_mm() const {
    const Transform T_W_M = target(static_cast<double>(t_ns) * 1e-9);
    return (T_W_H().t_mm - (T_W_M * config_.relation.T_Ed_M.inverse()).t_mm).norm();
  }
  [[nodiscard]] double speed_rad_per_s() const {
    double most = 0;
    for (const double v : feedback.velocity_rad_per_s) most = std::max(most, std::abs(v));
    return most;
  }

  Status status;
  Pipeline pipeline;
  sim::SimArm arm;
  sim::SimPanTilt eyes;
  ArmFeedback feedback;
  PanTiltFeedback eyes_feedback;
  std::int64_t t_ns = 0;
  bool arm_answers = true;
  bool arm_obeys = true;
  bool fault_clears = true;  // when the drives are asked to
  bool camera_answers = true;
  double lag_periods = 21;  // of the drives, a ms each
  bool target_there = true;
  std::int64_t late_ns = -20'000'000;  // of sightings, after their release
  std::function<Transform(double)> target = [](double) {
    return start_of_hand() * to_transform({{0, -100, 545}, Vector3::Zero()});
  };

 private:
  static constexpr std::int64_t kFrame_ns = 33'000'000;

  void move() {
    if (arm.requested() == ArmRequest::kEnable && feedback.state == ArmState::kDisabled) {
      feedback.state = ArmState::kEnabled;
    }
    if (arm.requested() == ArmRequest::kDisable && feedback.state == ArmState::kEnabled) {
      feedback.state = ArmState::kDisabled;
    }
    if (arm.requested() == ArmRequest::kResetFault && feedback.state == ArmState::kFault && fault_clears) {
      feedback.state = ArmState::kDisabled;
    }
    const bool driven = feedback.state == ArmState::kEnabled && arm_obeys;
    for (std::size_t i = 0; i < kMaxJoints; ++i) {
      double& v = feedback.velocity_rad_per_s[i];
      v = driven ? v + (arm.commanded_rad_per_s()[i] - v) / lag_periods : 0;
      feedback.position_rad[i] += v * 1e-3;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (eyes.is_enabled()) steps_[i] += eyes.commanded_steps_per_s()[i] * 1e-3;
    }
  }

  // As vision would, of a frame that was taken so long ago that it is released later by -late_ns.
  void give() {
    Sighting sighting;
    sighting.sequence = static_cast<std::uint64_t>(t_ns / kFrame_ns);
    sighting.valid_from_ns = t_ns - late_ns;
    sighting.stamp_ns = sighting.valid_from_ns - config_.release_offset_ns;
    sighting.T_W_H = T_W_H();
    const Transform T_W_M = target(static_cast<double>(sighting.stamp_ns) * 1e-9);
    sighting.T_H_M = sighting.T_W_H.inverse() * T_W_M;
    sighting.estimate.confidence = target_there ? 1 : 0;
    sighting.estimate.state = target_there ? TrackState::kTracking : TrackState::kLost;
    pipeline.put_sighting(t_ns, sighting);
  }

  RobotConfig config_;
  std::array<double, 3> steps_{};
};

}  // namespace vergence::testing
