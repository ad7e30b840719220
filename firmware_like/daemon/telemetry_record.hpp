// What the controller says of a period of the arm's task: for whoever watches, and for the black box. Plain
// numbers at fixed places; a new field goes to the end and raises the version.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "algo/limits.hpp"
#include "firmware_like/task_table.hpp"
#include "hal/pan_tilt.hpp"

namespace vergence {

inline constexpr std::uint32_t kTelemetryVersion = 1;

// Millimetres, and the vector part of the quaternion.
struct PoseRecord {
  std::array<double, 3> position_mm{};
  std::array<double, 3> e{};
};

struct TaskRecord {
  std::int64_t worst_latency_ns = 0;
  std::int64_t worst_execution_ns = 0;
  std::uint64_t runs = 0;
  std::uint64_t slips = 0;        // periods left out because an earlier one took too long
  std::uint64_t misses = 0;       // of its deadline
  std::uint64_t page_faults = 0;  // looked at now and then
};

struct TelemetryRecord {
  std::int64_t t_ns = 0;
  std::uint64_t period = 0;  // of the arm's task, counted from the start
  std::uint32_t mode = 0;    // firmware_like/mode.hpp
  std::uint32_t arm_state = 0;
  std::uint32_t arm_fault = 0;  // the bus driver's code
  std::uint32_t arm_request = 0;

  std::array<double, kMaxJoints> joint_rad{};
  std::array<double, kMaxJoints> joint_rad_per_s{};
  std::array<double, kMaxJoints> command_rad_per_s{};
  PoseRecord T_W_H;
  std::uint32_t hand_limits = 0;  // LimitFlags of the period
  std::uint32_t joint_limits = 0;
  double smallest_singular_value = 0;

  std::uint32_t target_believed = 0;
  std::uint32_t track_state = 0;  // algo/tracker.hpp, of the last sighting
  PoseRecord T_W_M;               // where the target is believed to be
  std::uint64_t sighting = 0;     // its frame's number
  std::int64_t sighting_stamp_ns = 0;
  PoseRecord T_H_M;  // as seen there
  double fitness = 0;
  double confidence = 0;

  std::uint32_t camera_state = 0;
  std::uint32_t eyes_state = 0;
  std::array<std::int64_t, kPanTiltMotors> eye_steps{};

  std::uint64_t frames_left_out = 0;
  std::uint64_t late_frames = 0;  // whose pose came after it was to act
  std::uint64_t mode_changes = 0;
  std::uint32_t last_event = 0;  // that changed the mode
  std::uint32_t reserved = 0;
  std::array<TaskRecord, kTaskCount> tasks{};
};
static_assert(std::is_trivially_copyable_v<TelemetryRecord>);

}  // namespace vergence
