#include "algo/brake_profile.hpp"

#include <algorithm>
#include <cmath>

namespace vergence {
namespace {

constexpr double kMostRampPeriods = 1 << 18;  // more than check() of the limits lets a ramp have

// Sums of the first n integers, and of those sums.
double sum1(double n) {
  return n * (n + 1) / 2;
}
double sum2(double n) {
  return n * (n + 1) * (n + 2) / 6;
}

double falls(double remaining, double change) {
  return std::max(1.0, std::ceil((std::sqrt(1 + 8 * (remaining / change)) - 1) / 2));
}

// The step the law is after: towards zero velocity, as steep as can still be taken back by then.
double wanted_step(double v, const StepBounds& bounds) {
  const double w = std::min(largest_step(std::abs(v), bounds.change), bounds.step);
  return v > 0 ? -w : w;
}

// First part of the way: w falls by j each period while it is more than j above what is wanted.
struct Ramp {
  double v, w, j;

  [[nodiscard]] double velocity(double k) const { return v + k * w - j * sum1(k); }
  [[nodiscard]] double displacement(double k) const { return k * v + w * sum1(k) - j * sum2(k); }
  [[nodiscard]] bool over_after(double k, const StepBounds& bounds) const {
    return w - (k + 1) * j <= wanted_step(velocity(k), bounds);
  }
  // Once over, the ramp stays over (docs/motion_limits.md), so halving finds where.
  [[nodiscard]] double periods(const StepBounds& bounds) const {
    double low = 0;
    double high = std::clamp(std::ceil((w + bounds.step) / j - 1), 0.0, kMostRampPeriods);
    while (low < high) {
      const double middle = std::floor((low + high) / 2);
      if (over_after(middle, bounds)) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }
};

// From a velocity >= 0 with the ramp over: hold -step, then fall to zero. Sets distance and periods.
struct Landing {
  double distance = 0;
  double periods = 0;

  Landing(double v, const StepBounds& bounds) {
    const double j = bounds.change;
    const double n_steep = std::ceil(bounds.step / j);
    const double v_steep =
        n_steep * bounds.step - j * sum1(n_steep - 1);  // from here the fall begins at -step
    const double holds = v > v_steep ? std::floor((v - v_steep) / bounds.step) + 1 : 0;
    distance = holds * v - bounds.step * sum1(holds);
    const double rest = std::max(0.0, v - holds * bounds.step);
    const double n = falls(rest, j);
    const double first = rest / n + j * (n - 1) / 2;
    distance += first * sum1(n - 1) - j * (n - 1) * n * (2 * n - 1) / 6;
    periods = holds + n;
  }
};

}  // namespace

double largest_step(double remaining, double change) {
  const double n = falls(remaining, change);
  return remaining / n + change * (n - 1) / 2;
}

double stopping_distance(double speed, double step) {
  const double n = std::floor(speed / step);
  return n * speed - step * sum1(n);
}

double brake_step(double v, double w, const StepBounds& bounds) {
  return std::clamp(wanted_step(v, bounds), w - bounds.change, w + bounds.change);
}

BrakePath brake_path(double v, double w, const StepBounds& bounds) {
  // Mirrored so that the ramp falls.
  const bool mirrored = w < wanted_step(v, bounds);
  const Ramp ramp = mirrored ? Ramp{-v, -w, bounds.change} : Ramp{v, w, bounds.change};
  const double n = ramp.periods(bounds);
  const double v_landing = ramp.velocity(n);
  const double at_landing = ramp.displacement(n);
  const Landing landing(std::abs(v_landing), bounds);
  const double at_rest = at_landing + (v_landing < 0 ? -landing.distance : landing.distance);

  double low = std::min({0.0, at_landing, at_rest});
  const double high = std::max({0.0, at_landing, at_rest});
  if (ramp.v < 0 && ramp.w > 0) {
    // Turns round where v + k w - j k (k + 1) / 2 comes up through zero; the root may be a rounding off.
    const double b = ramp.w - ramp.j / 2;
    const double discriminant = b * b + 2 * ramp.j * ramp.v;
    if (b > 0 && discriminant >= 0) {
      const double k = std::floor(-2 * ramp.v / (b + std::sqrt(discriminant)));
      for (const double turn : {k, k + 1}) low = std::min(low, ramp.displacement(std::min(turn, n)));
    }
  }
  const double peak = ramp.velocity(std::clamp(std::floor(ramp.w / ramp.j), 0.0, n));
  const double fastest = std::max({0.0, ramp.v, peak, v_landing});
  const double slowest = std::min({0.0, ramp.v, v_landing});

  BrakePath path;
  path.lowest = mirrored ? -high : low;
  path.highest = mirrored ? -low : high;
  path.least_speed = mirrored ? -fastest : slowest;
  path.greatest_speed = mirrored ? -slowest : fastest;
  path.periods = n + landing.periods + 1;
  return path;
}

}  // namespace vergence
