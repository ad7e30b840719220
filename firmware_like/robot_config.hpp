// Everything the controller must be told of a robot and its task. Fixed size; defaults are those of the
// thesis's robot where it says them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "algo/camera_model.hpp"
#include "algo/damped_velocity.hpp"
#include "algo/eye_vergence.hpp"
#include "algo/hand_limits.hpp"
#include "algo/hand_servo.hpp"
#include "algo/pa10.hpp"
#include "algo/target_motion.hpp"
#include "algo/tracker.hpp"
#include "firmware_like/task_table.hpp"

namespace vergence {

struct RobotConfig {
  StereoRig rig;  // cameras at zero angles of the eyes
  TrackerSettings tracker;
  // Of a target whose orientation is known beforehand: seen are only x, y, z.
  std::optional<Matrix3> R_W_M_given;

  SerialArm arm = pa10();
  bool has_arm = true;                                        // without: the hand stands at T_W_H_fixed
  std::int64_t arm_period_ns = task(TaskId::kArm).period_ns;  // of its task, and of SYNC
  Transform T_W_H_fixed;
  HandGains gains = vergence_gains();
  JointServo joint_servo = {.position_per_s = 5, .damping = {}};  // K_PQ [3.31]
  HandLimits hand_limits = {.linear_velocity_mm_per_s = 1000,
                            .angular_velocity_rad_per_s = 2,
                            .linear_acceleration_mm_per_s2 = 1000,
                            .angular_acceleration_rad_per_s2 = 3,
                            .box_min_mm = {-1100, -700, 50},
                            .box_max_mm = {-300, 700, 1200},
                            .least_distance_mm = 150};
  Vector3 tool_mm = Vector3::Zero();  // the point the box and the distance hold for, in the hand
  DesiredRelation relation;
  TargetMotionOptions target_motion;

  bool has_eyes = true;
  EyeMount mount;
  EyeControl eye_control = {.gain_per_period = 0.2, .latency_s = 0, .steps_per_rad = {8000, 8000, 8000}};
  // Steppers follow any jerk: the limit only keeps it finite.
  std::array<JointLimits, kEyeMotors> eye_limits = {JointLimits{-0.8, 0.8, 4, 60, 15000},
                                                    JointLimits{-0.7, 1.1, 4, 60, 15000},
                                                    JointLimits{-0.7, 1.1, 4, 60, 15000}};

  // A frame's pose is acted on so long after its stamp, ready or not: 9 ms of transfer and 24 ms of work.
  std::int64_t release_offset_ns = 33'000'000;
  std::int64_t drive_lag_ns = 20'000'000;    // of the arm's velocity loop: what the hand is led by
  std::int64_t believe_ns = 150'000'000;     // after the last sighting the target counts as lost
  std::int64_t arm_timeout_ns = 10'000'000;  // without feedback the drives count as gone
  std::int64_t camera_timeout_ns = 1'000'000'000;
  double following_error_rad = 0.15;
  int most_missed_deadlines = 3;
  double least_confidence = 0.5;  // of a sighting that is acted on
};

}  // namespace vergence
