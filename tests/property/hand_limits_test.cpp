// Limits of the hand in space: no input whatever breaks them, and the direction asked for is kept.
#include "algo/hand_limits.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/support/bit_hash.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

using testing::Random;

constexpr double kTolerance = 1e-9;  // of a limit

Vector3 any_vector(Random& random, double most) {
  const double x = random.between(-most, most);
  const double y = random.between(-most, most);
  return {x, y, random.between(-most, most)};
}

struct Case {
  HandLimits limits;
  double period_s = 0;
  Vector3 tool_mm = Vector3::Zero();
  std::optional<Vector3> target_mm;
};

Case any_case(Random& random) {
  Case c;
  const double periods[] = {0.001, 0.002, 0.004, 1.0 / 30};
  c.period_s = periods[random.below(4)];
  c.limits.linear_velocity_mm_per_s = random.about(200, 3);
  c.limits.angular_velocity_rad_per_s = random.about(1, 3);
  const double periods_to_speed = random.about(15, 4);
  c.limits.linear_acceleration_mm_per_s2 =
      c.limits.linear_velocity_mm_per_s / (c.period_s * periods_to_speed);
  c.limits.angular_acceleration_rad_per_s2 =
      c.limits.angular_velocity_rad_per_s / (c.period_s * periods_to_speed);
  const double size = random.about(c.limits.linear_velocity_mm_per_s * c.period_s * periods_to_speed, 3);
  c.tool_mm = any_vector(random, 500);
  const Vector3 below = any_vector(random, 1).cwiseAbs() * size;
  const Vector3 above = any_vector(random, 1).cwiseAbs() * size;
  c.limits.box_min_mm = c.tool_mm - below - Vector3::Constant(0.01);
  c.limits.box_max_mm = c.tool_mm + above + Vector3::Constant(0.01);
  if (random.below(4) != 0) {
    c.target_mm = c.tool_mm + any_vector(random, size);
    c.limits.least_distance_mm = random.between(0, 1) * (*c.target_mm - c.tool_mm).norm();
  }
  return c;
}

Twist hostile(Random& random, const Case& c, const Vector3& tool, const Twist& last, int mood) {
  const double v = c.limits.linear_velocity_mm_per_s;
  const double w = c.limits.angular_velocity_rad_per_s;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Twist twist{any_vector(random, v), any_vector(random, w)};
  switch (mood) {
    case 0: break;
    case 1:
      twist.linear_mm_per_s = c.target_mm ? Vector3(100 * (*c.target_mm - tool)) : Vector3(0, 0, 1e30);
      break;
    case 2: twist.linear_mm_per_s = Vector3(1e9, 3, -2); break;
    case 3: twist.linear_mm_per_s[random.below(3)] = random.below(2) == 0 ? nan : 1 / 0.0; break;
    case 4: twist.linear_mm_per_s = 5 * last.linear_mm_per_s; break;  // on towards where it goes
    case 5: twist = {-last.linear_mm_per_s, -last.angular_rad_per_s}; break;
    case 6: twist.linear_mm_per_s = Vector3(-v, -v, -v); break;
    default: twist = {};
  }
  return twist;
}

TEST(HandLimits, HostileInputNeverBreaksALimit) {
  double nearest_mm = 1e9;
  double farthest_mm = -1e9;
  int reached_wall = 0;
  int reached_target = 0;
  ASSERT_TRUE(rc::check([&] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Case c = any_case(random);
      RC_ASSERT(check(c.limits, c.period_s) == Status::kOk);
      Vector3 tool = c.tool_mm;
      Twist last;
      int mood = 0;
      double room = 1e9;
      double clearance = 1e9;
      for (int period = 0; period < 1500; ++period) {
        if (random.below(50) == 0) mood = random.below(9);
        const Twist desired = hostile(random, c, tool, last, mood);
        const auto [twist, flags] = limit_twist(c.limits, c.period_s, tool, last, desired, c.target_mm);
        const Vector3 dv = twist.linear_mm_per_s - last.linear_mm_per_s;
        const Vector3 dw = twist.angular_rad_per_s - last.angular_rad_per_s;
        const double more = 1 + kTolerance;
        RC_ASSERT(twist.linear_mm_per_s.norm() <= c.limits.linear_velocity_mm_per_s * more);
        RC_ASSERT(twist.angular_rad_per_s.norm() <= c.limits.angular_velocity_rad_per_s * more);
        RC_ASSERT(dv.norm() <= c.limits.linear_acceleration_mm_per_s2 * c.period_s * more);
        RC_ASSERT(dw.norm() <= c.limits.angular_acceleration_rad_per_s2 * c.period_s * more);
        RC_ASSERT((flags & kBeyondLimits) == 0U);
        tool += twist.linear_mm_per_s * c.period_s;
        last = twist;
        room = std::min(
            {room, (c.limits.box_max_mm - tool).minCoeff(), (tool - c.limits.box_min_mm).minCoeff()});
        if (c.target_mm) {
          clearance = std::min(clearance, (*c.target_mm - tool).norm() - c.limits.least_distance_mm);
        }
      }
      RC_ASSERT(room >= -1e-8);
      RC_ASSERT(clearance >= -1e-8);
      farthest_mm = std::max(farthest_mm, -room);
      nearest_mm = std::min(nearest_mm, clearance);
      reached_wall += room < 0.01 ? 1 : 0;
      reached_target += clearance < 0.01 ? 1 : 0;
    }
  }));
  // The limits were met, not just never come near.
  EXPECT_GT(reached_wall, 100);
  EXPECT_GT(reached_target, 100);
  std::printf(
      "beyond a wall %.2g mm, nearer than the least distance %.2g mm; at a wall %d, at the target %d of "
      "500\n",
      farthest_mm, -nearest_mm, reached_wall, reached_target);
}

const HandLimits kHand{200, 0.5, 400, 2, {-300, -300, 0}, {300, 300, 600}, 100};
constexpr double kPeriod_s = 0.002;

TEST(HandLimits, WhatKeepsTheLimitsPassesBitForBit) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const Twist last{any_vector(random, 60), any_vector(random, 0.2)};
    const Twist desired{last.linear_mm_per_s + any_vector(random, 0.8 / 1.74),
                        last.angular_rad_per_s + any_vector(random, 0.004 / 1.74)};
    const auto [twist, flags] = limit_twist(kHand, kPeriod_s, {0, 0, 300}, last, desired, Vector3(0, 0, 450));
    RC_ASSERT(twist.linear_mm_per_s == desired.linear_mm_per_s);
    RC_ASSERT(twist.angular_rad_per_s == desired.angular_rad_per_s);
    RC_ASSERT(flags == 0U);
  }));
}

TEST(HandLimits, OneFactorKeepsTheDirection) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const Twist desired{any_vector(random, 1000), any_vector(random, 3)};
    Vector6 direction;
    direction << desired.linear_mm_per_s, desired.angular_rad_per_s;
    // Up to speed along it, and on.
    Twist last;
    Vector3 tool{0, 0, 300};
    double factor = 0;
    for (int period = 0; period < 50; ++period) {
      const auto out = limit_twist(kHand, kPeriod_s, tool, last, desired, std::nullopt);
      Vector6 got;
      got << out.twist.linear_mm_per_s, out.twist.angular_rad_per_s;
      const double share = got.dot(direction) / direction.squaredNorm();
      RC_ASSERT((got - share * direction).norm() <= 1e-12 * direction.norm());
      RC_ASSERT(share > 0);
      RC_ASSERT(share >= factor * (1 - 1e-12));
      factor = share;
      last = out.twist;
      tool += last.linear_mm_per_s * kPeriod_s;
    }
  }));
}

TEST(HandLimits, AtAWallTheWayAlongItIsFree) {
  Twist last;
  Vector3 tool{0, 0, 300};
  LimitFlags seen = 0;
  for (int period = 0; period < 3000; ++period) {
    const double along = 100 * (period % 1000 < 500 ? 1 : -1);
    const auto out = limit_twist(kHand, kPeriod_s, tool, last, {{150, along, 0}, {0, 0, 0}}, std::nullopt);
    last = out.twist;
    seen |= out.flags;
    tool += last.linear_mm_per_s * kPeriod_s;
    if (period > 1500 && period % 500 == 499) {
      EXPECT_NEAR(last.linear_mm_per_s[1], along, 1e-9) << period;
    }
  }
  EXPECT_NEAR(tool[0], 300, 1e-6);
  EXPECT_NEAR(last.linear_mm_per_s[0], 0, 1e-6);
  EXPECT_NE(seen & kBoxLimited, 0U);
}

TEST(HandLimits, StopsAtTheLeastDistanceAndSlidesRound) {
  Twist last;
  Vector3 tool{5, 0, 100};
  const Vector3 target{0, 0, 500};
  double least_mm = 1e9;
  for (int period = 0; period < 3000; ++period) {
    last = limit_twist(kHand, kPeriod_s, tool, last, {{0, 0, 200}, {0, 0, 0}}, target).twist;
    tool += last.linear_mm_per_s * kPeriod_s;
    least_mm = std::min(least_mm, (target - tool).norm());
  }
  EXPECT_NEAR(least_mm, 100, 0.01);
  EXPECT_GE(least_mm, 100 - 1e-8);
  EXPECT_GT(tool[2], 590);  // went round the target, on to the wall behind
}

TEST(HandLimits, TooNearMayGoAwayOnly) {
  const Vector3 tool{0, 0, 450};
  const Vector3 target{0, 0, 500};
  const auto nearer = limit_twist(kHand, kPeriod_s, tool, {}, {{0, 0, 50}, {0, 0, 0}}, target);
  EXPECT_LE(nearer.twist.linear_mm_per_s[2], 1e-6);
  EXPECT_NE(nearer.flags & kBeyondLimits, 0U);
  const auto away = limit_twist(kHand, kPeriod_s, tool, {}, {{0, 0, -50}, {0, 0, 0}}, target);
  EXPECT_NEAR(away.twist.linear_mm_per_s[2], -0.8, 1e-9);
}

TEST(HandLimits, NoNumberBrakesToRest) {
  Twist last{{100, -50, 20}, {0.1, 0.3, 0}};
  const Twist nonsense{{std::nan(""), 0, 0}, {0, 0, 0}};
  int periods = 0;
  while (last.linear_mm_per_s.norm() > 0 || last.angular_rad_per_s.norm() > 0) {
    const auto out = limit_twist(kHand, kPeriod_s, {0, 0, 300}, last, nonsense, std::nullopt);
    EXPECT_NE(out.flags & kNotFinite, 0U);
    last = out.twist;
    ASSERT_LE(++periods, 144);  // 113.6 mm/s by 0.8 mm/s a period
  }
}

TEST(HandLimits, RefusesWhatIsNoLimit) {
  EXPECT_EQ(check(kHand, kPeriod_s), Status::kOk);
  EXPECT_EQ(check(kHand, -1), Status::kBadLimits);
  HandLimits limits = kHand;
  limits.box_min_mm[1] = 300;
  EXPECT_EQ(check(limits, kPeriod_s), Status::kBadLimits);
  limits = kHand;
  limits.least_distance_mm = -1;
  EXPECT_EQ(check(limits, kPeriod_s), Status::kBadLimits);
  limits = kHand;
  limits.angular_acceleration_rad_per_s2 = std::nan("");
  EXPECT_EQ(check(limits, kPeriod_s), Status::kBadLimits);
}

// One number proves behaviour unchanged, on x86-64 and arm64.
TEST(HandLimits, KeepsItsBits) {
  Random random(42);
  testing::BitHash hash;
  Case c;
  c.limits = kHand;
  c.period_s = kPeriod_s;
  c.target_mm = Vector3(30, -20, 450);
  Vector3 tool{0, 0, 100};
  Twist last;
  for (int period = 0; period < 10000; ++period) {
    const auto out = limit_twist(kHand, kPeriod_s, tool, last,
                                 hostile(random, c, tool, last, period / 250 % 9), c.target_mm);
    last = out.twist;
    tool += last.linear_mm_per_s * kPeriod_s;
    hash.add(out.flags);
    for (int i = 0; i < 3; ++i) {
      hash.add(tool[i]);
      hash.add(last.angular_rad_per_s[i]);
    }
  }
  EXPECT_EQ(hash.value(), 0xEE082D3D09F28C78ULL)
      << "0x" << std::hex << std::uppercase << hash.value() << "ULL";
}

}  // namespace
}  // namespace vergence
