#include "firmware_like/pipeline.hpp"

#include "hal/clock.hpp"

namespace vergence {
namespace {

// So long the drives may take to clear a fault before the operator has to ask again.
constexpr std::int64_t kResetTime_ns = 1'000'000'000;

}  // namespace

Status Pipeline::configure_rest(const RobotConfig& config) {
  config_ = config;
  supervisor_.configure(config.most_missed_deadlines);
  if (const Status status = belief_.configure(config); status != Status::kOk) return status;
  if (config.has_arm) {
    const Status status = hand_.configure(config, seconds(config.arm_period_ns));
    if (status != Status::kOk) return status;
  }
  if (config.has_eyes) return eyes_.configure(config, seconds(task(TaskId::kEyes).period_ns));
  return Status::kOk;
}

Status Pipeline::configure(const RobotConfig& config, const MarkerModel& model) {
  const Status status = configure_rest(config);
  return status == Status::kOk ? vision_.configure(config, model) : status;
}

Status Pipeline::configure(const RobotConfig& config, const PhotoModel& model) {
  const Status status = configure_rest(config);
  return status == Status::kOk ? vision_.configure(config, model) : status;
}

Status Pipeline::configure_given(const RobotConfig& config) {
  return configure_rest(config);
}

void Pipeline::command(OperatorCommand command) {
  const bool is_drive_faulty = config_.has_arm && feedback_.state == ArmState::kFault;
  if (command == OperatorCommand::kReset && is_drive_faulty) {
    reset_until_ns_ = arm_period_.t_ns + kResetTime_ns;
    return;
  }
  if (command == OperatorCommand::kStop) reset_until_ns_ = 0;
  supervisor_.command(command);
}

void Pipeline::put_sighting(std::int64_t now_ns, const Sighting& sighting) {
  sighting_ = sighting;
  to_arm_.write(sighting);
  camera_ = {CameraState::kOk, true, now_ns};
  camera_to_arm_.write(camera_);
}

void Pipeline::look(std::int64_t now_ns, CameraState state, const StereoFrame* frame) {
  camera_.state = state;
  if (frame != nullptr) {
    camera_.seen = true;
    camera_.last_ns = now_ns;
  }
  camera_to_arm_.write(camera_);
  (void)hand_to_vision_.read(hand_history_seen_);
  (void)eyes_to_vision_.read(eye_history_seen_);
  if (frame != nullptr && vision_.step(*frame, hand_history_seen_, eye_history_seen_, sighting_)) {
    to_arm_.write(sighting_);
  }
}

Conditions Pipeline::conditions(std::int64_t now_ns) {
  if (eyes_to_arm_.read(eyes_seen_)) eyes_seen_once_ = true;

  Conditions now;
  const bool arm_there = !config_.has_arm || fed_back_;
  const bool eyes_there = !config_.has_eyes || eyes_seen_once_;
  now.devices_ready = arm_there && eyes_there && camera_health_.seen;
  if (supervisor_.mode() == Mode::kSelfTest) {
    self_test_ = self_test(config_, feedback_, eyes_seen_);
    now.self_test = self_test_.finding == SelfTestFinding::kNone ? SelfTest::kPassed : SelfTest::kFailed;
  }
  const bool arm_silent =
      config_.has_arm && fed_back_ && now_ns - feedback_.stamp_ns > config_.arm_timeout_ns;
  const bool camera_silent =
      camera_health_.seen && now_ns - camera_health_.last_ns > config_.camera_timeout_ns;
  now.device_fault = arm_silent || camera_silent || camera_health_.state == CameraState::kFault ||
                     (config_.has_arm && feedback_.state == ArmState::kFault) ||
                     (config_.has_eyes && eyes_seen_.state == PanTiltState::kFault);
  now.following_error = arm_period_.hand.following_error;
  now.target_believed = belief_.is_believed(now_ns);
  now.at_rest = arm_period_.hand.at_rest;
  now.missed_deadlines = missed_deadlines_;
  return now;
}

void Pipeline::plan(std::int64_t now_ns) {
  ArmPeriod& period = arm_period_;
  period.target_believed = belief_.is_believed(now_ns);
  if (period.target_believed) period.target = belief_.at(now_ns);
  if (config_.has_arm) {
    period.hand = hand_.step(now_ns, period.mode, feedback_, period.target_believed,
                             [this](std::int64_t t_ns) { return belief_.at(t_ns); });
  } else {
    period.hand.T_W_H = config_.T_W_H_fixed;
    period.hand.at_rest = true;
  }
  // A controlled stop first, torque off only at rest; at once where the drives are broken anyway.
  const bool stopping = period.mode == Mode::kSafeStop && !period.hand.at_rest;
  period.request = is_armed(period.mode) || stopping ? ArmRequest::kEnable : ArmRequest::kDisable;
  if (now_ns < reset_until_ns_) {
    if (feedback_.state == ArmState::kFault) {
      period.request = ArmRequest::kResetFault;
    } else {
      reset_until_ns_ = 0;
      supervisor_.command(OperatorCommand::kReset);
    }
  }
}

void Pipeline::move(std::int64_t now_ns, const ArmFeedback* feedback) {
  if (feedback != nullptr) {
    feedback_ = *feedback;
    fed_back_ = true;
    HandHistory::Values q{};
    q = feedback->position_rad;
    hand_history_.add(feedback->stamp_ns, q);
    hand_to_vision_.write(hand_history_);
  }
  (void)camera_to_arm_.read(camera_health_);
  if (to_arm_.read(last_sighting_)) belief_.put(last_sighting_);
  // A camera that is gone says so at once: the hand need not go on blindly until believe_ms are over.
  if (camera_health_.state != CameraState::kOk) belief_.lose();
  belief_.step(now_ns);

  arm_period_.t_ns = now_ns;
  arm_period_.mode = supervisor_.step(now_ns, conditions(now_ns));
  plan(now_ns);

  HandView view;
  view.t_ns = now_ns;
  view.mode = arm_period_.mode;
  view.T_W_H = arm_period_.hand.T_W_H;
  view.hand = arm_period_.hand.hand;
  view.target_known = arm_period_.target_believed;
  if (view.target_known) {
    view.target_mm = arm_period_.target.T_W_M.t_mm;
    view.target_mm_per_s = arm_period_.target.velocity.linear_mm_per_s;
  }
  arm_to_eyes_.write(view);
}

void Pipeline::turn(std::int64_t now_ns, const PanTiltFeedback* feedback) {
  (void)arm_to_eyes_.read(view_);
  if (feedback != nullptr) {
    eye_feedback_ = *feedback;
    eye_fed_back_ = true;
    const EyeAngles angles = eyes_.angles(*feedback);
    eye_history_.add(feedback->stamp_ns, {angles.tilt_rad, angles.pan_right_rad, angles.pan_left_rad});
    eyes_to_vision_.write(eye_history_);
    eyes_to_arm_.write(*feedback);
  }
  eye_command_ = eyes_.step(now_ns, view_, eye_feedback_);
  // Steppers cut off at speed lose steps: they come to rest first.
  bool turning = false;
  for (const double rate : eye_command_.steps_per_s) turning = turning || rate != 0;
  eyes_on_ = eye_fed_back_ && (is_armed(view_.mode) || turning);
}

}  // namespace vergence
