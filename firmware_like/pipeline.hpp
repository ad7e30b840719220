// The whole controller: three tasks and the mailboxes between them, in one object that is placed statically.
// Nothing here waits, and time is handed in; what calls the steps, on which thread and by which clock,
// decides whether this runs on a robot or in a simulation.
#pragma once

#include <cstdint>

#include "firmware_like/eye_task.hpp"
#include "firmware_like/hand_task.hpp"
#include "firmware_like/messages.hpp"
#include "firmware_like/robot_config.hpp"
#include "firmware_like/self_test.hpp"
#include "firmware_like/supervisor.hpp"
#include "firmware_like/target_belief.hpp"
#include "firmware_like/task_table.hpp"
#include "firmware_like/vision_task.hpp"
#include "hal/arm.hpp"
#include "hal/latest_value.hpp"
#include "hal/pan_tilt.hpp"
#include "hal/stereo_camera.hpp"

namespace vergence {

// What the vision task says of its cameras.
struct CameraHealth {
  CameraState state = CameraState::kOk;
  bool seen = false;  // a pair has come
  std::int64_t last_ns = 0;
};

// What the arm's task did last; for telemetry and logs, and only in its own thread.
struct ArmPeriod {
  std::int64_t t_ns = 0;
  Mode mode = Mode::kInit;
  HandPeriod hand;
  bool target_believed = false;
  TargetState target;  // at t_ns, while it is believed
  ArmRequest request = ArmRequest::kDisable;
};

class Pipeline {
 public:
  // Errors: those of the parts. Nothing may be stepped before.
  [[nodiscard]] Status configure(const RobotConfig& config, const MarkerModel& model);
  [[nodiscard]] Status configure(const RobotConfig& config, const PhotoModel& model);
  // Without vision: sightings are given by put_sighting() instead of step_vision().
  [[nodiscard]] Status configure_given(const RobotConfig& config);

  // Once each kTasks period; that of the arm is the configuration's. The three may run in three threads.
  template <StereoCamera Cameras>
  void step_vision(std::int64_t now_ns, Cameras& cameras) {
    StereoFrame frame;
    const bool fresh = cameras.take(frame);
    look(now_ns, cameras.state(), fresh ? &frame : nullptr);
  }
  template <Arm ArmDevice>
  void step_arm(std::int64_t now_ns, ArmDevice& arm) {
    ArmFeedback feedback;
    const bool fresh = arm.read(feedback);
    move(now_ns, fresh ? &feedback : nullptr);
    arm.request(arm_period_.request);
    arm.command(arm_period_.hand.velocity_rad_per_s);
  }
  template <PanTilt Eyes>
  void step_eyes(std::int64_t now_ns, Eyes& eyes) {
    PanTiltFeedback feedback;
    const bool fresh = eyes.read(feedback);
    turn(now_ns, fresh ? &feedback : nullptr);
    eyes.enable(eyes_on_);
    eyes.command(eye_command_.steps_per_s);
  }

  // In place of vision, in the thread that would have run it.
  void put_sighting(std::int64_t now_ns, const Sighting& sighting);

  // From the thread that runs step_arm().
  void command(OperatorCommand command);
  void report_missed_deadlines(int in_a_row) { missed_deadlines_ = in_a_row; }

  // For telemetry, each in its own task's thread.
  [[nodiscard]] const ArmPeriod& arm_period() const { return arm_period_; }
  [[nodiscard]] const EyeCommand& eye_command() const { return eye_command_; }
  [[nodiscard]] const Sighting& sighting() const { return sighting_; }
  [[nodiscard]] const Supervisor& supervisor() const { return supervisor_; }
  [[nodiscard]] const TargetBelief& belief() const { return belief_; }
  // Of the arm's task: what it knows of the devices, and the last sighting that reached it.
  [[nodiscard]] const ArmFeedback& arm_feedback() const { return feedback_; }
  [[nodiscard]] const PanTiltFeedback& eyes_feedback() const { return eyes_seen_; }
  [[nodiscard]] const CameraHealth& camera_health() const { return camera_health_; }
  [[nodiscard]] const Sighting& last_sighting() const { return last_sighting_; }
  [[nodiscard]] const VisionTask& vision() const { return vision_; }
  [[nodiscard]] const SelfTestResult& self_test_result() const { return self_test_; }

 private:
  [[nodiscard]] Status configure_rest(const RobotConfig& config);
  void look(std::int64_t now_ns, CameraState state, const StereoFrame* frame);
  void move(std::int64_t now_ns, const ArmFeedback* feedback);
  void turn(std::int64_t now_ns, const PanTiltFeedback* feedback);
  [[nodiscard]] Conditions conditions(std::int64_t now_ns);
  void plan(std::int64_t now_ns);

  RobotConfig config_;

  // The arm's task.
  Supervisor supervisor_;
  TargetBelief belief_;
  HandTask hand_;
  HandHistory hand_history_;
  ArmFeedback feedback_;
  bool fed_back_ = false;
  CameraHealth camera_health_;
  PanTiltFeedback eyes_seen_;
  bool eyes_seen_once_ = false;
  Sighting last_sighting_;
  SelfTestResult self_test_;
  int missed_deadlines_ = 0;
  std::int64_t reset_until_ns_ = 0;  // a reset is wanted, and the drives are asked to clear their fault
  ArmPeriod arm_period_;

  // The eyes' task.
  EyeTask eyes_;
  EyeHistory eye_history_;
  HandView view_;
  PanTiltFeedback eye_feedback_;
  bool eye_fed_back_ = false;
  EyeCommand eye_command_;
  bool eyes_on_ = false;

  // The vision task.
  VisionTask vision_;
  HandHistory hand_history_seen_;
  EyeHistory eye_history_seen_;
  CameraHealth camera_;
  Sighting sighting_;

  LatestValue<Sighting> to_arm_;
  LatestValue<CameraHealth> camera_to_arm_;
  LatestValue<PanTiltFeedback> eyes_to_arm_;
  LatestValue<HandView> arm_to_eyes_;
  LatestValue<HandHistory> hand_to_vision_;
  LatestValue<EyeHistory> eyes_to_vision_;
};

}  // namespace vergence
