// The quickest way to rest that a bounded acceleration and jerk allow, sampled at a fixed period, and where
// it leads: in closed form, so that asking costs the same however long the braking takes.
//
// Everything is per period: a velocity v, its step w from one period to the next (acceleration * period), and
// the most that a step may differ from the one before, j (jerk * period^2). The velocity holds for its whole
// period, so a position moves by v * period.
#pragma once

namespace vergence {

struct StepBounds {
  double step = 0;    // |w| at most, > 0
  double change = 0;  // |w - w before| at most, > 0
};

// The largest first step w_1 of a fall w_1, w_1 - j, w_1 - 2 j, ... > 0 whose sum is `remaining` >= 0. What
// is left after it asks for exactly w_1 - j next, so a velocity led by it lands without a jolt.
[[nodiscard]] double largest_step(double remaining, double change);

// Distance, in velocity * periods, covered after the present period while `speed` >= 0 falls by `step` each
// period.
[[nodiscard]] double stopping_distance(double speed, double step);

// The brake law: the next step of a velocity v whose last step was w. Repeated, it ends at v = 0 and w = 0
// exactly.
[[nodiscard]] double brake_step(double v, double w, const StepBounds& bounds);

// What the brake law does from (v, w) on until rest, if it is obeyed from the next period on.
struct BrakePath {
  double lowest = 0;          // least displacement on the way, <= 0, in velocity * periods
  double highest = 0;         // greatest displacement on the way, >= 0
  double least_speed = 0;     // least velocity on the way, v and rest among them
  double greatest_speed = 0;  // greatest velocity on the way
  double periods = 0;         // at most so many until v and w are zero
};
[[nodiscard]] BrakePath brake_path(double v, double w, const StepBounds& bounds);

}  // namespace vergence
