// What tasks tell each other.
#pragma once

#include <array>
#include <cstdint>

#include "algo/eye_mount.hpp"
#include "algo/hand_limits.hpp"
#include "algo/tracker.hpp"
#include "firmware_like/mode.hpp"
#include "firmware_like/motion_history.hpp"

namespace vergence {

// What vision made of a frame.
struct Sighting {
  std::uint64_t sequence = 0;
  std::int64_t stamp_ns = 0;       // of the frame
  std::int64_t valid_from_ns = 0;  // nobody acts on it before, however early it was ready
  Transform T_W_H;                 // the hand when the frame was taken
  Transform T_H_M;
  Estimate estimate;
  EyeAngles eyes;
};

using HandHistory = MotionHistory<kMaxJoints, 128>;  // at 1 ms, four frames
using EyeHistory = MotionHistory<3>;                 // tilt, right pan, left pan

// What the eyes need to know of hand and target, valid at an instant.
struct HandView {
  std::int64_t t_ns = 0;
  Mode mode = Mode::kInit;
  Transform T_W_H;
  Twist hand;  // of the hand's origin, in W
  bool target_known = false;
  Vector3 target_mm = Vector3::Zero();  // in W
  Vector3 target_mm_per_s = Vector3::Zero();
};

enum class OperatorCommand : std::uint8_t {
  kArm,
  kDisarm,
  kServo,
  kHold,
  kStop,
  kReset,
};

}  // namespace vergence
