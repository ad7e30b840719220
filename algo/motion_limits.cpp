#include "algo/motion_limits.hpp"

#include <algorithm>
#include <cmath>

namespace vergence {
namespace {

// Slack for rounding, in parts of a limit, so that what lands exactly on a limit keeps it; and in parts of a
// position.
constexpr double kSlack = 1e-12;
constexpr double kPositionSlack = 1e-14;
constexpr int kHalvings = 26;
constexpr double kMostPeriods = 1e9;  // fits an int

// Limits per period, and how far a joint may go at present.
struct Bounds {
  StepBounds per_period;
  double velocity;
  double min_rad, max_rad;
  double least_velocity, greatest_velocity;
};

// A bound with slack; or, where braking would pass it by more, what braking reaches: then nothing may go
// further. The slack is measured from the limit itself, so it cannot add up over periods.
double upper(double limit, double slack, double braking_reaches) {
  return braking_reaches > limit + 2 * slack ? braking_reaches : limit + slack;
}
double lower(double limit, double slack, double braking_reaches) {
  return -upper(-limit, slack, -braking_reaches);
}

StepBounds per_period(const JointLimits& limits, double period_s) {
  return {limits.acceleration_rad_per_s2 * period_s, limits.jerk_rad_per_s3 * period_s * period_s};
}

bool is_finite(const JointMotion& motion) {
  return std::isfinite(motion.position_rad) && std::isfinite(motion.velocity_rad_per_s) &&
         std::isfinite(motion.acceleration_rad_per_s2);
}

JointMotion moved(const JointMotion& last, double velocity, double step, double period_s) {
  JointMotion next;
  next.velocity_rad_per_s = velocity;
  next.acceleration_rad_per_s2 = step / period_s;
  next.position_rad = last.position_rad + velocity * period_s;
  next.desired_rad_per_s = last.desired_rad_per_s;
  return next;
}

// The flags of what would be broken if (position, velocity, step) were followed by braking. None where a
// position is no number: then neither comparison holds, and the position counts as broken.
LimitFlags broken(const Bounds& bounds, const JointMotion& next, double step, double period_s) {
  const BrakePath path = brake_path(next.velocity_rad_per_s, step, bounds.per_period);
  LimitFlags flags = 0;
  const bool inside = next.position_rad + period_s * path.highest <= bounds.max_rad &&
                      next.position_rad + period_s * path.lowest >= bounds.min_rad;
  if (!inside) flags |= kPositionLimited;
  if (path.greatest_speed > bounds.greatest_velocity || path.least_speed < bounds.least_velocity) {
    flags |= kVelocityLimited;
  }
  return flags;
}

Bounds present_bounds(const JointLimits& limits, double period_s, const JointMotion& last, double step,
                      LimitFlags& flags) {
  Bounds b{per_period(limits, period_s), limits.velocity_rad_per_s, 0, 0, 0, 0};
  const BrakePath path = brake_path(last.velocity_rad_per_s, step, b.per_period);
  const double position_slack = kSlack * (limits.max_rad - limits.min_rad) +
                                kPositionSlack * (std::abs(limits.min_rad) + std::abs(limits.max_rad));
  const double velocity_slack = kSlack * b.velocity;
  b.max_rad = upper(limits.max_rad, position_slack, last.position_rad + period_s * path.highest);
  b.min_rad = lower(limits.min_rad, position_slack, last.position_rad + period_s * path.lowest);
  b.greatest_velocity = upper(b.velocity, velocity_slack, path.greatest_speed);
  b.least_velocity = lower(-b.velocity, velocity_slack, path.least_speed);
  if (b.max_rad > limits.max_rad + position_slack || b.min_rad < limits.min_rad - position_slack ||
      b.greatest_velocity > b.velocity + velocity_slack || b.least_velocity < -b.velocity - velocity_slack) {
    flags |= kBeyondLimits;
  }
  return b;
}

// The step towards the desired velocity, by the limits of acceleration and jerk alone. On the desired
// velocity, or one change of step away, it goes straight there; from further away it lands with the slope
// that the desired has.
double step_towards(double desired, const JointMotion& last, double step, const Bounds& bounds,
                    LimitFlags& flags) {
  const auto& [most_step, most_change] = bounds.per_period;
  const double last_desired = std::clamp(last.desired_rad_per_s, -bounds.velocity, bounds.velocity);
  const double slope = std::clamp(desired - last_desired, -most_step, most_step);
  const double behind = desired - slope - last.velocity_rad_per_s;
  double wanted = desired - last.velocity_rad_per_s;
  if (std::abs(behind) > most_change) {
    const double caught_up = largest_step(std::abs(behind), most_change);
    wanted = slope + (behind > 0 ? caught_up : -caught_up);
    flags |= kJerkLimited;
  }
  const double within = std::clamp(wanted, -most_step, most_step);
  if (within != wanted) flags |= kAccelerationLimited;
  const double reachable = std::clamp(within, step - most_change, step + most_change);
  if (reachable != within) flags |= kJerkLimited;
  return reachable;
}

}  // namespace

Status check(const JointLimits& limits, double period_s) {
  const bool finite = std::isfinite(limits.min_rad) && std::isfinite(limits.max_rad) &&
                      std::isfinite(limits.velocity_rad_per_s) &&
                      std::isfinite(limits.acceleration_rad_per_s2) &&
                      std::isfinite(limits.jerk_rad_per_s3) && std::isfinite(period_s);
  if (!finite || !(period_s > 0) || !(limits.min_rad < limits.max_rad)) return Status::kBadLimits;
  const auto [step, change] = per_period(limits, period_s);
  const bool positive = limits.velocity_rad_per_s > 0 && step > 0 && change > 0;
  return positive && step <= change * kMostPeriodsToFullAcceleration ? Status::kOk : Status::kBadLimits;
}

LimitedMotion limit_motion(const JointLimits& limits, double period_s, const JointMotion& last,
                           double desired_rad_per_s) {
  if (!std::isfinite(desired_rad_per_s) || !is_finite(last)) {
    LimitedMotion out = brake_motion(limits, period_s, last);
    out.flags |= kNotFinite;
    return out;
  }
  LimitedMotion out;
  const double step = last.acceleration_rad_per_s2 * period_s;
  const Bounds bounds = present_bounds(limits, period_s, last, step, out.flags);
  const double desired = std::clamp(desired_rad_per_s, -bounds.velocity, bounds.velocity);
  if (desired != desired_rad_per_s) out.flags |= kVelocityLimited;

  const double asked = step_towards(desired, last, step, bounds, out.flags);
  const bool direct = asked == desired - last.velocity_rad_per_s;
  double taken = asked;
  out.motion = moved(last, direct ? desired : last.velocity_rad_per_s + asked, asked, period_s);
  if (const LimitFlags flags = broken(bounds, out.motion, asked, period_s); flags != 0) {
    // Braking is always allowed; how far from it towards what was asked?
    out.flags |= flags;
    taken = brake_step(last.velocity_rad_per_s, step, bounds.per_period);
    out.motion = moved(last, last.velocity_rad_per_s + taken, taken, period_s);
    double refused = asked;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = taken + (refused - taken) / 2;
      const JointMotion tried = moved(last, last.velocity_rad_per_s + middle, middle, period_s);
      if (broken(bounds, tried, middle, period_s) != 0) {
        refused = middle;
      } else {
        taken = middle;
        out.motion = tried;
      }
    }
  }
  out.motion.desired_rad_per_s = desired;
  return out;
}

LimitedMotion brake_motion(const JointLimits& limits, double period_s, const JointMotion& last) {
  LimitedMotion out;
  if (!std::isfinite(last.velocity_rad_per_s) || !std::isfinite(last.acceleration_rad_per_s2)) {
    out.motion.position_rad = last.position_rad;  // no telling what to brake from: rest
    out.flags = kNotFinite;
    return out;
  }
  const StepBounds bounds = per_period(limits, period_s);
  const double step = brake_step(last.velocity_rad_per_s, last.acceleration_rad_per_s2 * period_s, bounds);
  out.motion = moved(last, last.velocity_rad_per_s + step, step, period_s);
  out.motion.desired_rad_per_s = 0;
  if (!std::isfinite(last.position_rad)) out.flags = kNotFinite;
  return out;
}

int brake_periods(const JointLimits& limits, double period_s, const JointMotion& last) {
  const BrakePath path = brake_path(last.velocity_rad_per_s, last.acceleration_rad_per_s2 * period_s,
                                    per_period(limits, period_s));
  return static_cast<int>(std::min(path.periods, kMostPeriods)) + 2;  // two more for what rounding leaves
}

int most_brake_periods(const JointLimits& limits, double period_s) {
  const auto [step, change] = per_period(limits, period_s);
  // From full acceleration to full braking, at full braking, and back to none.
  const double periods = 3 * std::ceil(step / change) + std::ceil(limits.velocity_rad_per_s / step);
  return static_cast<int>(std::min(periods, kMostPeriods)) + 6;
}

}  // namespace vergence
