// Joint limits: no input whatever breaks them, what keeps them passes unchanged, and braking ends when it
// says.
#include "algo/motion_limits.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/support/bit_hash.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

using testing::Random;

constexpr double kTolerance = 1e-9;  // of a limit

struct Case {
  JointLimits limits;
  double period_s;
};

Case any_case(Random& random) {
  const double periods[] = {0.001, 0.002, 0.004, 1.0 / 30};
  Case c{};
  c.period_s = periods[random.below(4)];
  c.limits.velocity_rad_per_s = random.about(1, 4);
  // From a few to hundreds of periods to full speed, and to full acceleration.
  c.limits.acceleration_rad_per_s2 = c.limits.velocity_rad_per_s / (c.period_s * random.about(20, 5));
  c.limits.jerk_rad_per_s3 = c.limits.acceleration_rad_per_s2 / (c.period_s * random.about(8, 5));
  // From less than the way to full speed and back, to a whole turn.
  c.limits.min_rad = random.between(-3, 0);
  const double brake_rad =
      c.limits.velocity_rad_per_s * c.limits.velocity_rad_per_s / c.limits.acceleration_rad_per_s2;
  c.limits.max_rad = c.limits.min_rad + random.about(brake_rad, 5);
  return c;
}

double hostile(Random& random, const JointLimits& limits, const JointMotion& motion, int period, int mood) {
  const double v = limits.velocity_rad_per_s;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  switch (mood) {
    case 0: return random.between(-2 * v, 2 * v);
    case 1: return period % 2 == 0 ? v : -v;
    case 2: return 1e300;
    case 3: return -std::numeric_limits<double>::max();
    case 4: return random.below(3) == 0 ? nan : random.between(-v, v);
    case 5: return random.below(2) == 0 ? inf : -inf;
    case 6: return motion.velocity_rad_per_s > 0 ? 2 * v : -2 * v;  // on towards the end it is going to
    case 7: return motion.velocity_rad_per_s + random.between(-2, 2) * limits.acceleration_rad_per_s2 * 0.001;
    case 8: return 0;
    default: return random.between(-1e-6, 1e-6) * v;
  }
}

// The largest excess over any limit, as a part of that limit.
struct Excess {
  double position = 0, velocity = 0, acceleration = 0, jerk = 0;

  void look(const Case& c, const JointMotion& before, const JointMotion& after) {
    const auto& [limits, period_s] = c;
    const double beyond = std::max(after.position_rad - limits.max_rad, limits.min_rad - after.position_rad);
    const double rounding =
        1e-13 * (std::abs(limits.min_rad) + std::abs(limits.max_rad));  // of thousands of sums
    position = std::max(position, (beyond - rounding) / (limits.max_rad - limits.min_rad));
    velocity = std::max(velocity, std::abs(after.velocity_rad_per_s) / limits.velocity_rad_per_s - 1);
    // By differences of the velocities sent, not by the acceleration the limiter reports.
    const double step = after.velocity_rad_per_s - before.velocity_rad_per_s;
    acceleration = std::max(acceleration, std::abs(step) / (limits.acceleration_rad_per_s2 * period_s) - 1);
    const double change = step - before.acceleration_rad_per_s2 * period_s;
    jerk = std::max(jerk, std::abs(change) / (limits.jerk_rad_per_s3 * period_s * period_s) - 1);
  }
};

TEST(MotionLimits, HostileInputNeverBreaksALimit) {
  Excess worst;
  ASSERT_TRUE(rc::check([&worst] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Case c = any_case(random);
      RC_ASSERT(check(c.limits, c.period_s) == Status::kOk);
      JointMotion motion;
      motion.position_rad = random.between(c.limits.min_rad, c.limits.max_rad);
      Excess excess;
      int mood = 0;
      for (int period = 0; period < 2000; ++period) {
        if (period % 64 == 0 || random.below(50) == 0) mood = random.below(10);
        const double desired = hostile(random, c.limits, motion, period, mood);
        const LimitedMotion out = limit_motion(c.limits, c.period_s, motion, desired);
        excess.look(c, motion, out.motion);
        RC_ASSERT((out.flags & kBeyondLimits) == 0U);
        RC_ASSERT(((out.flags & kNotFinite) != 0U) == !std::isfinite(desired));
        motion = out.motion;
      }
      RC_ASSERT(excess.position <= kTolerance);
      RC_ASSERT(excess.velocity <= kTolerance);
      RC_ASSERT(excess.acceleration <= kTolerance);
      RC_ASSERT(excess.jerk <= kTolerance);
      worst = {std::max(worst.position, excess.position), std::max(worst.velocity, excess.velocity),
               std::max(worst.acceleration, excess.acceleration), std::max(worst.jerk, excess.jerk)};
    }
  }));
  std::printf(
      "largest excess, in parts of the limit: position %.2g velocity %.2g acceleration %.2g jerk %.2g\n",
      worst.position, worst.velocity, worst.acceleration, worst.jerk);
}

// Any motion within the limits of velocity and acceleration, not only what a limiter leads to.
JointMotion any_motion(Random& random, const JointLimits& limits) {
  JointMotion motion;
  motion.position_rad = random.between(limits.min_rad, limits.max_rad);
  motion.velocity_rad_per_s = random.between(-1, 1) * limits.velocity_rad_per_s;
  motion.acceleration_rad_per_s2 = random.between(-1, 1) * limits.acceleration_rad_per_s2;
  return motion;
}

TEST(BrakePath, IsWhatTheBrakeLawDoes) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    for (int repeat = 0; repeat < 50; ++repeat) {
      const Case c = any_case(random);
      const StepBounds bounds{c.limits.acceleration_rad_per_s2 * c.period_s,
                              c.limits.jerk_rad_per_s3 * c.period_s * c.period_s};
      const JointMotion start = any_motion(random, c.limits);
      double v = start.velocity_rad_per_s;
      double w = start.acceleration_rad_per_s2 * c.period_s;
      const BrakePath path = brake_path(v, w, bounds);
      BrakePath walked;
      walked.least_speed = walked.greatest_speed = v;
      double x = 0;
      for (; v != 0 || w != 0; ++walked.periods) {
        const double last = w;
        w = brake_step(v, w, bounds);
        RC_ASSERT(std::abs(w) <= bounds.step * (1 + kTolerance));
        RC_ASSERT(std::abs(w - last) <= bounds.change * (1 + kTolerance));
        v += w;
        x += v;
        walked.lowest = std::min(walked.lowest, x);
        walked.highest = std::max(walked.highest, x);
        walked.least_speed = std::min(walked.least_speed, v);
        walked.greatest_speed = std::max(walked.greatest_speed, v);
        RC_ASSERT(walked.periods < path.periods + 2);
      }
      const double scale = std::max({1e-3 * c.limits.velocity_rad_per_s, -walked.lowest, walked.highest});
      // From full acceleration at a low jerk the way may lead far beyond the limit of velocity.
      const double fastest =
          std::max({c.limits.velocity_rad_per_s, walked.greatest_speed, -walked.least_speed});
      RC_ASSERT(std::abs(path.lowest - walked.lowest) < 1e-11 * scale);
      RC_ASSERT(std::abs(path.highest - walked.highest) < 1e-11 * scale);
      RC_ASSERT(std::abs(path.least_speed - walked.least_speed) < 1e-11 * fastest);
      RC_ASSERT(std::abs(path.greatest_speed - walked.greatest_speed) < 1e-11 * fastest);
    }
  }));
}

TEST(Brake, EndsAtExactlyZeroWithinTheStatedPeriods) {
  double closest = 0;
  ASSERT_TRUE(rc::check([&closest] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Case c = any_case(random);
      JointMotion motion = any_motion(random, c.limits);
      const int stated = brake_periods(c.limits, c.period_s, motion);
      RC_ASSERT(stated <= most_brake_periods(c.limits, c.period_s));
      closest = std::max(closest, static_cast<double>(stated) / most_brake_periods(c.limits, c.period_s));
      for (int i = 0; i < stated; ++i) motion = brake_motion(c.limits, c.period_s, motion).motion;
      RC_ASSERT(motion.velocity_rad_per_s == 0);
      RC_ASSERT(motion.acceleration_rad_per_s2 == 0);
    }
  }));
  EXPECT_GT(closest, 0.5);  // a bound that says something
}

// A sum of two sines that keeps the limits of velocity, acceleration and jerk.
struct Wave {
  double a, b, wa, wb, fading_s;

  Wave(Random& random, const JointLimits& limits, double period_s) {
    wa = random.about(2, 3);
    wb = random.about(2, 3);
    a = random.between(0.1, 1);
    b = random.between(0.1, 1);
    const double w = std::max(wa, wb);
    const double most = std::min(
        {limits.velocity_rad_per_s, limits.acceleration_rad_per_s2 / w, limits.jerk_rad_per_s3 / (w * w)});
    fading_s = 8 / w;  // slow enough to add less than half to acceleration and jerk
    const double scale = most / (1.5 * (a + b) * (1 + w * period_s));
    a *= scale;
    b *= scale;
  }
  [[nodiscard]] double velocity(double t) const {
    const double fade = std::min(t / fading_s, 1.0);  // from rest
    return fade * fade * (3 - 2 * fade) * (a * std::sin(wa * t) + b * std::sin(wb * t));
  }
};

TEST(MotionLimits, WhatKeepsTheLimitsPassesBitForBit) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    Case c = any_case(random);
    const double middle = (c.limits.min_rad + c.limits.max_rad) / 2;
    c.limits.min_rad -= 1000;  // what is near an end is for the next test
    c.limits.max_rad += 1000;
    const Wave wave(random, c.limits, c.period_s);
    JointMotion motion;
    motion.position_rad = middle;
    for (int period = 0; period < 3000; ++period) {
      const double desired = wave.velocity(period * c.period_s);
      const LimitedMotion out = limit_motion(c.limits, c.period_s, motion, desired);
      RC_ASSERT(std::bit_cast<std::uint64_t>(out.motion.velocity_rad_per_s) ==
                std::bit_cast<std::uint64_t>(desired));
      RC_ASSERT(out.flags == 0U);
      motion = out.motion;
    }
  }));
}

// The recorded output of one limiter is a feasible input of another.
TEST(MotionLimits, ItsOwnOutputPassesUnchanged) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const Case c = any_case(random);
    JointLimits wider = c.limits;
    wider.velocity_rad_per_s *= 1 + 1e-6;  // differences of rounded velocities are a little off
    wider.acceleration_rad_per_s2 *= 1 + 1e-6;
    wider.jerk_rad_per_s3 *= 1 + 1e-6;
    wider.min_rad -= 1e-6;
    wider.max_rad += 1e-6;
    JointMotion first;
    first.position_rad = random.between(c.limits.min_rad, c.limits.max_rad);
    JointMotion second = first;
    int mood = 0;
    for (int period = 0; period < 2000; ++period) {
      if (period % 64 == 0) mood = random.below(10);
      first =
          limit_motion(c.limits, c.period_s, first, hostile(random, c.limits, first, period, mood)).motion;
      const LimitedMotion out = limit_motion(wider, c.period_s, second, first.velocity_rad_per_s);
      RC_ASSERT(out.motion.velocity_rad_per_s == first.velocity_rad_per_s);
      RC_ASSERT(out.flags == 0U);
      second = out.motion;
    }
  }));
}

const JointLimits kElbow{-2.0, 2.0, 1.0, 4.0, 40.0};

TEST(MotionLimits, RunsUpToTheEndAndStaysThere) {
  JointMotion motion;
  LimitFlags seen = 0;
  int changes_of_direction = 0;
  double last_change = 0;
  for (int period = 0; period < 5000; ++period) {
    const double before = motion.acceleration_rad_per_s2;
    const LimitedMotion out = limit_motion(kElbow, 0.001, motion, 5.0);
    motion = out.motion;
    seen |= out.flags;
    const double change = motion.acceleration_rad_per_s2 - before;
    if (std::abs(change) < 1e-6) continue;
    if (change * last_change < 0) ++changes_of_direction;
    last_change = change;
  }
  EXPECT_NEAR(motion.position_rad, 2.0, 1e-6);
  EXPECT_EQ(seen, LimitFlags{kVelocityLimited | kAccelerationLimited | kJerkLimited | kPositionLimited});
  EXPECT_EQ(changes_of_direction, 2);  // up, down to cruise and to brake, up to rest: no chatter at the end
  // And leaves it again.
  for (int period = 0; period < 1000; ++period) motion = limit_motion(kElbow, 0.001, motion, -0.5).motion;
  EXPECT_EQ(motion.velocity_rad_per_s, -0.5);
}

TEST(MotionLimits, AStepIsTakenWithoutOvershoot) {
  JointMotion motion;
  double fastest = 0;
  int periods = 0;
  while (motion.velocity_rad_per_s != 0.7 || motion.acceleration_rad_per_s2 != 0) {
    motion = limit_motion(kElbow, 0.001, motion, 0.7).motion;
    fastest = std::max(fastest, motion.velocity_rad_per_s);
    ASSERT_LT(++periods, 1000);
  }
  EXPECT_NEAR(fastest, 0.7, 1e-12);
  EXPECT_LE(periods, 278);  // 0.7 / 4 + 4 / 40 = 0.275 s is the quickest there is
}

TEST(MotionLimits, OutOfRangeGoesNoFurtherAndFindsBack) {
  JointMotion motion;
  motion.position_rad = 2.3;
  LimitedMotion out = limit_motion(kElbow, 0.001, motion, 1.0);
  EXPECT_NE(out.flags & kBeyondLimits, 0U);
  EXPECT_NEAR(out.motion.position_rad, 2.3, 1e-9);
  for (int i = 0; i < 2000; ++i) {
    out = limit_motion(kElbow, 0.001, out.motion, -1.0);
    ASSERT_LE(out.motion.position_rad, 2.3 + 1e-9);
  }
  EXPECT_LT(out.motion.position_rad, 2.0);
  EXPECT_EQ(out.flags, 0U);
}

TEST(MotionLimits, StateThatIsNoNumberRests) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  JointMotion motion{0, nan, 0, 0};
  LimitedMotion out = limit_motion(kElbow, 0.001, motion, 0.5);
  EXPECT_EQ(out.motion.velocity_rad_per_s, 0);
  EXPECT_NE(out.flags & kNotFinite, 0U);
  // Where only the place is unknown, braking is still by the limits.
  motion = {nan, 0.5, 0, 0};
  out = limit_motion(kElbow, 0.001, motion, 0.5);
  EXPECT_NE(out.flags & kNotFinite, 0U);
  EXPECT_NEAR(out.motion.velocity_rad_per_s, 0.5 - 40 * 1e-6, 1e-12);
}

TEST(MotionLimits, RefusesWhatIsNoLimit) {
  EXPECT_EQ(check(kElbow, 0.001), Status::kOk);
  EXPECT_EQ(check(kElbow, 0), Status::kBadLimits);
  for (double JointLimits::*field : {&JointLimits::velocity_rad_per_s, &JointLimits::acceleration_rad_per_s2,
                                     &JointLimits::jerk_rad_per_s3}) {
    for (const double bad : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
      JointLimits limits = kElbow;
      limits.*field = bad;
      EXPECT_EQ(check(limits, 0.001), Status::kBadLimits) << bad;
    }
  }
  JointLimits limits = kElbow;
  limits.max_rad = limits.min_rad;
  EXPECT_EQ(check(limits, 0.001), Status::kBadLimits);
  limits = kElbow;
  limits.jerk_rad_per_s3 = 1e-3;
  EXPECT_EQ(check(limits, 0.001), Status::kBadLimits);
}

// One number proves behaviour unchanged, on x86-64 and arm64.
TEST(MotionLimits, KeepsItsBits) {
  MotionLimiter<7> limiter;
  limiter.period_s = 0.002;
  limiter.limits.fill(kElbow);
  ASSERT_EQ(limiter.check_limits(), Status::kOk);
  Random random(42);
  testing::BitHash hash;
  for (int period = 0; period < 5000; ++period) {
    std::array<double, 7> desired{};
    for (std::size_t i = 0; i < 7; ++i) {
      desired[i] =
          hostile(random, kElbow, limiter.last[i], period, (period / 100 + static_cast<int>(i)) % 10);
    }
    for (const LimitFlags flags : limiter.limit(desired)) hash.add(flags);
    for (const JointMotion& motion : limiter.last) {
      hash.add(motion.velocity_rad_per_s);
      hash.add(motion.acceleration_rad_per_s2);
      hash.add(motion.position_rad);
    }
  }
  int periods = 0;
  while (!limiter.brake()) ASSERT_LE(++periods, most_brake_periods(kElbow, 0.002));
  hash.add(periods);
  EXPECT_EQ(hash.value(), 0xA3A6B31E4BE79179ULL)
      << "0x" << std::hex << std::uppercase << hash.value() << "ULL";
}

}  // namespace
}  // namespace vergence
