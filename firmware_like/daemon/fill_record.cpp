#include "firmware_like/daemon/fill_record.hpp"

#include "algo/pose.hpp"

namespace vergence {
namespace {

PoseRecord record_of(const Pose& pose) {
  PoseRecord record;
  for (int i = 0; i < 3; ++i) {
    record.position_mm[static_cast<std::size_t>(i)] = pose.position_mm[i];
    record.e[static_cast<std::size_t>(i)] = pose.e[i];
  }
  return record;
}

template <typename Enum>
std::uint32_t number_of(Enum value) {
  return static_cast<std::uint32_t>(value);
}

}  // namespace

void fill_record(const Pipeline& pipeline, TelemetryRecord& record) {
  const ArmPeriod& period = pipeline.arm_period();
  const ArmFeedback& arm = pipeline.arm_feedback();
  record.t_ns = period.t_ns;
  record.mode = number_of(period.mode);
  record.arm_state = number_of(arm.state);
  record.arm_fault = arm.fault;
  record.arm_request = number_of(period.request);
  record.joint_rad = arm.position_rad;
  record.joint_rad_per_s = arm.velocity_rad_per_s;
  record.command_rad_per_s = period.hand.velocity_rad_per_s;
  record.T_W_H = record_of(to_pose(period.hand.T_W_H));
  record.hand_limits = period.hand.hand_flags;
  record.joint_limits = period.hand.joint_flags;
  record.smallest_singular_value = period.hand.smallest_singular_value;
  record.target_believed = period.target_believed ? 1 : 0;
  if (period.target_believed) record.T_W_M = record_of(to_pose(period.target.T_W_M));

  const Sighting& sighting = pipeline.last_sighting();
  record.track_state = number_of(sighting.estimate.state);
  record.sighting = sighting.sequence;
  record.sighting_stamp_ns = sighting.stamp_ns;
  record.T_H_M = record_of(sighting.estimate.pose);
  record.fitness = sighting.estimate.fitness;
  record.confidence = sighting.estimate.confidence;

  record.camera_state = number_of(pipeline.camera_health().state);
  record.eyes_state = number_of(pipeline.eyes_feedback().state);
  record.eye_steps = pipeline.eyes_feedback().steps;
  record.late_frames = pipeline.belief().late();

  const Supervisor& supervisor = pipeline.supervisor();
  record.mode_changes = supervisor.changes();
  if (supervisor.changes() > 0) {
    record.last_event = number_of(supervisor.change(supervisor.changes() - 1).event);
  }
}

}  // namespace vergence
