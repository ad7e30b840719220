// The last stage before a bus: whatever is asked for, what a joint is sent keeps its limits of velocity,
// acceleration and jerk, and can still be stopped by them before the joint's end. What keeps all limits
// passes bit for bit. Why no input can break this: docs/motion_limits.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algo/brake_profile.hpp"
#include "algo/joint_limits.hpp"
#include "algo/status.hpp"

namespace vergence {

// Which limits bit, for telemetry. Bits of LimitFlags.
enum LimitFlag : std::uint32_t {
  kVelocityLimited = 1U << 0,
  kAccelerationLimited = 1U << 1,
  kJerkLimited = 1U << 2,
  kPositionLimited = 1U << 3,  // slowed down, or stopped, because of a joint's end
  kBeyondLimits = 1U << 4,     // not even braking keeps the limits: the state was not left here by this stage
  kNotFinite = 1U << 5,        // input that is no number: braked
  kHandVelocityLimited = 1U << 6,  // of the hand: see algo/hand_limits.hpp
  kHandAccelerationLimited = 1U << 7,
  kBoxLimited = 1U << 8,
  kDistanceLimited = 1U << 9,
};
using LimitFlags = std::uint32_t;

// A joint as it was last commanded. The position may be a measured one, if it is close to the commanded one.
struct JointMotion {
  double position_rad = 0;
  double velocity_rad_per_s = 0;
  double acceleration_rad_per_s2 = 0;
  double desired_rad_per_s = 0;  // what was asked for then: tells a slope from a jump
};

struct LimitedMotion {
  JointMotion motion;  // to be held for the coming period; the position is that at its end
  LimitFlags flags = 0;
};

// A jerk limit so low that the acceleration takes longer to build up than so many periods is refused.
inline constexpr double kMostPeriodsToFullAcceleration = 65536;

// kOk, or kBadLimits: not finite, an empty range, a limit that is not positive.
[[nodiscard]] Status check(const JointLimits& limits, double period_s);

// The command of the coming period: `desired_rad_per_s` itself where it keeps all limits, else the closest to
// it on the way there that does.
[[nodiscard]] LimitedMotion limit_motion(const JointLimits& limits, double period_s, const JointMotion& last,
                                         double desired_rad_per_s);

// The same for the safe stop: to rest as quickly as acceleration and jerk allow.
[[nodiscard]] LimitedMotion brake_motion(const JointLimits& limits, double period_s, const JointMotion& last);

// So many calls of brake_motion, at most, bring `last` to velocity and acceleration zero, exactly; and, of
// any motion within the limits.
[[nodiscard]] int brake_periods(const JointLimits& limits, double period_s, const JointMotion& last);
[[nodiscard]] int most_brake_periods(const JointLimits& limits, double period_s);

// Several joints: an arm's, or the three motors of the eyes.
template <std::size_t kJoints>
struct MotionLimiter {
  std::array<JointLimits, kJoints> limits{};
  double period_s = 0;
  std::array<JointMotion, kJoints> last{};

  [[nodiscard]] Status check_limits() const {
    for (const JointLimits& joint : limits) {
      if (const Status status = check(joint, period_s); status != Status::kOk) return status;
    }
    return Status::kOk;
  }

  // Advances `last`, and answers the flags of each joint. Velocities to be sent are in `last`.
  std::array<LimitFlags, kJoints> limit(const std::array<double, kJoints>& desired_rad_per_s) {
    std::array<LimitFlags, kJoints> flags{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      const LimitedMotion out = limit_motion(limits[i], period_s, last[i], desired_rad_per_s[i]);
      last[i] = out.motion;
      flags[i] = out.flags;
    }
    return flags;
  }

  // One period of the safe stop. True once all joints rest.
  bool brake() {
    bool at_rest = true;
    for (std::size_t i = 0; i < kJoints; ++i) {
      last[i] = brake_motion(limits[i], period_s, last[i]).motion;
      at_rest = at_rest && last[i].velocity_rad_per_s == 0 && last[i].acceleration_rad_per_s2 == 0;
    }
    return at_rest;
  }
};

}  // namespace vergence
