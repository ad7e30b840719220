#include "algo/hand_limits.hpp"

#include <algorithm>
#include <cmath>

namespace vergence {
namespace {

constexpr double kSlack_mm = 1e-9;    // for rounding
constexpr double kMostSpeed = 1e100;  // what is beyond is no command; squares stay finite
constexpr double kAxisShare =
    0.5773;  // < 1 / sqrt(3): three axes braking at once stay within the acceleration
constexpr int kHalvings = 26;

// What holds at present: limits, and where the tool or the target is out of them already, no further.
struct Room {
  Vector3 min_mm, max_mm;
  std::optional<Vector3> target_mm;
  double least_distance_mm = 0;
};

Vector3 nearest_in_box(const Vector3& p, const Vector3& a, const Vector3& b) {
  return p.cwiseMax(a.cwiseMin(b)).cwiseMin(a.cwiseMax(b));
}

double distance_to_segment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 along = b - a;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + share * along)).norm();
}

// Limits per period.
struct Steps {
  double period_s;
  double linear, angular;
  double axis;  // linear, when each axis brakes on its own
};

Room present_room(const HandLimits& limits, const Vector3& tool, const std::optional<Vector3>& target,
                  LimitFlags& flags) {
  Room room;
  room.min_mm = tool.cwiseMin(limits.box_min_mm - Vector3::Constant(kSlack_mm));
  room.max_mm = tool.cwiseMax(limits.box_max_mm + Vector3::Constant(kSlack_mm));
  room.target_mm = target;
  const double distance = target ? (*target - tool).norm() : 0.0;
  room.least_distance_mm = std::min(distance, limits.least_distance_mm - kSlack_mm);
  const bool too_near = target && distance < limits.least_distance_mm - 4 * kSlack_mm;
  const bool outside = ((limits.box_min_mm - tool).array() > 4 * kSlack_mm).any() ||
                       ((tool - limits.box_max_mm).array() > 4 * kSlack_mm).any();
  if (too_near || outside) flags |= kBeyondLimits;
  return room;
}

// A little more of it, to recognise a state that was let in a period ago: rounding may have moved it over the
// edge.
Room widened(Room room) {
  room.min_mm -= Vector3::Constant(kSlack_mm);
  room.max_mm += Vector3::Constant(kSlack_mm);
  room.least_distance_mm -= kSlack_mm;
  return room;
}

bool in_box(const Room& room, const Vector3& p) {
  return (p.array() >= room.min_mm.array()).all() && (p.array() <= room.max_mm.array()).all();
}

// Two ways to brake. Straight: the speed falls, the direction stays. By axes: each component falls on its
// own, so the part along a wall costs no room across it. From a state that one of them brings to rest in the
// room, it still does a period later.
bool stops_straight(const Room& room, const Steps& steps, const Vector3& p, const Vector3& v) {
  const double speed = v.norm();
  const double distance = steps.period_s * stopping_distance(speed, steps.linear);
  const Vector3 end = speed > 0 ? Vector3(p + v * (distance / speed)) : p;
  if (!in_box(room, p) || !in_box(room, end)) return false;
  return !room.target_mm || distance_to_segment(*room.target_mm, p, end) >= room.least_distance_mm;
}

bool stops_by_axes(const Room& room, const Steps& steps, const Vector3& p, const Vector3& v) {
  Vector3 end = p;
  for (int i = 0; i < 3; ++i) {
    const double distance = steps.period_s * stopping_distance(std::abs(v[i]), steps.axis);
    end[i] += v[i] < 0 ? -distance : distance;
  }
  if (!in_box(room, p) || !in_box(room, end)) return false;
  // The way is somewhere in the box that p and end span, which only shrinks.
  return !room.target_mm ||
         (*room.target_mm - nearest_in_box(*room.target_mm, p, end)).norm() >= room.least_distance_mm;
}

Vector3 slower(const Vector3& v, double step) {
  const double speed = v.norm();
  return speed > step ? Vector3(v * ((speed - step) / speed)) : Vector3(Vector3::Zero());
}

Twist brake_twist(const Room& room, const Steps& steps, const Vector3& p, const Twist& last,
                  LimitFlags& flags) {
  Twist twist{slower(last.linear_mm_per_s, steps.linear), slower(last.angular_rad_per_s, steps.angular)};
  const bool straight = stops_straight(room, steps, p, last.linear_mm_per_s);
  if (!straight && stops_by_axes(room, steps, p, last.linear_mm_per_s)) {
    for (int i = 0; i < 3; ++i) {
      const double v = last.linear_mm_per_s[i];
      twist.linear_mm_per_s[i] = v < 0 ? std::min(v + steps.axis, 0.0) : std::max(v - steps.axis, 0.0);
    }
  } else if (!straight) {
    flags |= kBeyondLimits;
  }
  return twist;
}

// Takes from the velocity what braking could not stop before a wall or the target, and leaves the rest.
void turn_from_walls(const Room& room, const Steps& steps, const Vector3& p, Vector3& v, LimitFlags& flags) {
  const auto most = [&steps](double distance, double step) {
    return largest_step(std::max(distance, 0.0) / steps.period_s, step);
  };
  if (room.target_mm) {
    const Vector3 towards = *room.target_mm - p;
    const double distance = towards.norm();
    const Vector3 direction = distance > 0 ? Vector3(towards / distance) : Vector3(Vector3::Zero());
    const double approach = v.dot(direction);
    const double left = std::max(distance - room.least_distance_mm, 0.0) / steps.period_s;
    double kept = std::min(approach, largest_step(left, steps.linear));
    // Braking straight takes the longer, the faster the hand is sideways.
    const double speed = (v - (approach - kept) * direction).norm();
    if (speed > 0) kept = std::min(kept, left / (1 + stopping_distance(speed, steps.linear) / speed));
    if (approach > 0 && approach > kept) {
      v -= (approach - kept) * direction;
      flags |= kDistanceLimited;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double kept =
        std::clamp(v[i], -most(p[i] - room.min_mm[i], steps.axis), most(room.max_mm[i] - p[i], steps.axis));
    if (kept != v[i]) flags |= kBoxLimited;
    v[i] = kept;
  }
}

// The s for which |s d - last| <= step, as an interval; empty where low > high.
struct Interval {
  double low, high;
};
Interval within_step(const Vector3& d, const Vector3& last, double step) {
  const double a = d.squaredNorm();
  const double c = last.squaredNorm() - step * step;
  if (!(a > 0)) return c <= 0 ? Interval{0, 1} : Interval{1, 0};
  const double b = d.dot(last);
  const double root2 = b * b - a * c;
  if (root2 < 0) return {1, 0};
  const double root = std::sqrt(root2);
  return {(b - root) / a, (b + root) / a};
}

// The fastest twist in the direction of `desired` that the accelerations allow; where there is none, towards
// the nearest one of that direction.
Twist accelerated(const Steps& steps, const Twist& last, const Twist& desired, LimitFlags& flags) {
  const Vector3 dv = desired.linear_mm_per_s - last.linear_mm_per_s;
  const Vector3 dw = desired.angular_rad_per_s - last.angular_rad_per_s;
  if (dv.norm() <= steps.linear && dw.norm() <= steps.angular) return desired;
  flags |= kHandAccelerationLimited;
  const Interval linear = within_step(desired.linear_mm_per_s, last.linear_mm_per_s, steps.linear);
  const Interval angular = within_step(desired.angular_rad_per_s, last.angular_rad_per_s, steps.angular);
  const double high = std::min({linear.high, angular.high, 1.0});
  if (high >= std::max({linear.low, angular.low, 0.0})) {
    return {desired.linear_mm_per_s * high, desired.angular_rad_per_s * high};
  }
  const double a2 = steps.linear * steps.linear;
  const double b2 = steps.angular * steps.angular;
  const double length2 =
      desired.linear_mm_per_s.squaredNorm() / a2 + desired.angular_rad_per_s.squaredNorm() / b2;
  const double along = desired.linear_mm_per_s.dot(last.linear_mm_per_s) / a2 +
                       desired.angular_rad_per_s.dot(last.angular_rad_per_s) / b2;
  const double share = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
  const Vector3 to_v = desired.linear_mm_per_s * share - last.linear_mm_per_s;
  const Vector3 to_w = desired.angular_rad_per_s * share - last.angular_rad_per_s;
  const double t = 1 / std::max({1.0, to_v.norm() / steps.linear, to_w.norm() / steps.angular});
  return {last.linear_mm_per_s + t * to_v, last.angular_rad_per_s + t * to_w};
}

bool is_command(const Twist& twist) {
  // Negated, so that NaN is none.
  return (twist.linear_mm_per_s.array().abs() < kMostSpeed).all() &&
         (twist.angular_rad_per_s.array().abs() < kMostSpeed).all();
}

}  // namespace

Status check(const HandLimits& limits, double period_s) {
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  const bool good =
      positive(period_s) && positive(limits.linear_velocity_mm_per_s) &&
      positive(limits.angular_velocity_rad_per_s) && positive(limits.linear_acceleration_mm_per_s2) &&
      positive(limits.angular_acceleration_rad_per_s2) && limits.box_min_mm.allFinite() &&
      limits.box_max_mm.allFinite() && (limits.box_min_mm.array() < limits.box_max_mm.array()).all() &&
      limits.least_distance_mm >= 0 && std::isfinite(limits.least_distance_mm);
  return good ? Status::kOk : Status::kBadLimits;
}

LimitedTwist limit_twist(const HandLimits& limits, double period_s, const Vector3& tool_mm, const Twist& last,
                         const Twist& desired, const std::optional<Vector3>& target_mm) {
  LimitedTwist out;
  if (!is_command(last)) return {Twist{}, kNotFinite};  // no telling what to brake from: rest
  const Steps steps{period_s, limits.linear_acceleration_mm_per_s2 * period_s,
                    limits.angular_acceleration_rad_per_s2 * period_s,
                    limits.linear_acceleration_mm_per_s2 * period_s * kAxisShare};
  const bool known = tool_mm.allFinite() && (!target_mm || target_mm->allFinite());
  if (!known || !is_command(desired)) out.flags |= kNotFinite;
  const Room room = present_room(limits, tool_mm, target_mm, out.flags);
  const Twist braked = brake_twist(widened(room), steps, tool_mm, last, out.flags);
  if ((out.flags & kNotFinite) != 0) {
    out.twist = braked;
    return out;
  }

  Twist wanted = desired;
  const double factor = std::min({1.0, limits.linear_velocity_mm_per_s / desired.linear_mm_per_s.norm(),
                                  limits.angular_velocity_rad_per_s / desired.angular_rad_per_s.norm()});
  if (factor < 1) {
    wanted = {desired.linear_mm_per_s * factor, desired.angular_rad_per_s * factor};
    out.flags |= kHandVelocityLimited;
  }
  turn_from_walls(room, steps, tool_mm, wanted.linear_mm_per_s, out.flags);
  const Twist asked = accelerated(steps, last, wanted, out.flags);

  const auto stops = [&](const Twist& twist) {
    const Vector3 next = tool_mm + twist.linear_mm_per_s * period_s;
    return stops_straight(room, steps, next, twist.linear_mm_per_s) ||
           stops_by_axes(room, steps, next, twist.linear_mm_per_s);
  };
  const auto between = [&](double share) {
    return Twist{braked.linear_mm_per_s + share * (asked.linear_mm_per_s - braked.linear_mm_per_s),
                 braked.angular_rad_per_s + share * (asked.angular_rad_per_s - braked.angular_rad_per_s)};
  };
  out.twist = asked;
  if (!stops(asked)) {
    out.flags |= target_mm ? kBoxLimited | kDistanceLimited : kBoxLimited;
    double taken = 0;
    double refused = 1;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = taken + (refused - taken) / 2;
      (stops(between(middle)) ? taken : refused) = middle;
    }
    out.twist = taken > 0 ? between(taken) : braked;
  }
  return out;
}

}  // namespace vergence
