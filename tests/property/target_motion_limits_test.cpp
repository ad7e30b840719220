// The target's motion where observations are late, wrong or missing; and its bits.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "algo/rotation_vector.hpp"
#include "algo/target_motion.hpp"
#include "tests/support/bit_hash.hpp"
#include "tests/support/random.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::distance_mm;
using testing::distance_rad;
using testing::Random;
using testing::RandomArm;

constexpr std::int64_t kFrame_ns = 33'333'333;
constexpr double kFrame_s = 33'333'333e-9;
constexpr std::int64_t kEver_ns = std::numeric_limits<std::int64_t>::max();

// A target that goes straight on and turns about one axis.
struct Straight {
  Transform T_W_M;
  Vector3 v_mm_per_s, w_rad_per_s;

  [[nodiscard]] Transform at(double t_s) const {
    return {rotation_from_vector(w_rad_per_s * t_s) * T_W_M.R, T_W_M.t_mm + v_mm_per_s * t_s};
  }
};

const Straight kStraight{{Matrix3::Identity(), {0, 0, 500}}, {100, 20, 0}, {0, 0.3, 0}};

// After `frames` frames of it.
TargetMotion following(const Straight& truth, int frames, const TargetMotionOptions& options = {}) {
  TargetMotion motion;
  EXPECT_EQ(motion.configure(options), Status::kOk);
  for (int i = 0; i < frames; ++i) EXPECT_TRUE(motion.observe(i * kFrame_ns, truth.at(i * kFrame_s)));
  return motion;
}

void expect_same(const TargetState& a, const TargetState& b) {
  EXPECT_EQ(a.T_W_M.t_mm, b.T_W_M.t_mm);
  EXPECT_EQ(a.T_W_M.R, b.T_W_M.R);
  EXPECT_EQ(a.velocity.linear_mm_per_s, b.velocity.linear_mm_per_s);
  EXPECT_EQ(a.velocity.angular_rad_per_s, b.velocity.angular_rad_per_s);
}

TEST(TargetMotionLimits, RefusesWhatIsLateOrNoPose) {
  TargetMotion motion = following(kStraight, 30);
  const std::int64_t last_ns = motion.last_ns();
  const TargetState before = motion.at(last_ns + kFrame_ns);
  EXPECT_FALSE(motion.observe(last_ns, kStraight.at(29 * kFrame_s)));
  EXPECT_FALSE(motion.observe(last_ns - 1, kStraight.at(29 * kFrame_s)));
  EXPECT_FALSE(motion.observe(std::numeric_limits<std::int64_t>::min(), kStraight.at(0)));
  for (const double bad : {std::nan(""), HUGE_VAL, 1e10}) {
    Transform T = kStraight.at(30 * kFrame_s);
    T.t_mm[1] = bad;
    EXPECT_FALSE(motion.observe(last_ns + kFrame_ns, T));
    T = kStraight.at(30 * kFrame_s);
    T.R(2, 1) = bad;
    EXPECT_FALSE(motion.observe(last_ns + kFrame_ns, T));
  }
  Transform mirrored = kStraight.at(30 * kFrame_s);
  mirrored.R = -mirrored.R;
  EXPECT_FALSE(motion.observe(last_ns + kFrame_ns, mirrored));
  for (const double bad : {std::nan(""), 0.0, -1.0}) {
    const Transform T = kStraight.at(30 * kFrame_s);
    EXPECT_FALSE(motion.observe(last_ns + kFrame_ns, T, ObservationNoise{bad, 0.01}));
    EXPECT_FALSE(motion.observe(last_ns + kFrame_ns, T, ObservationNoise{1, bad}));
  }
  expect_same(motion.at(last_ns + kFrame_ns), before);
  EXPECT_EQ(motion.last_ns(), last_ns);
  EXPECT_TRUE(motion.observe(last_ns + kFrame_ns, kStraight.at(30 * kFrame_s)));
}

TEST(TargetMotionLimits, BelievesAnObservationAsFarAsItsNoise) {
  const TargetMotion before = following(kStraight, 30);
  const std::int64_t now_ns = before.last_ns() + kFrame_ns;
  Transform off = kStraight.at(30 * kFrame_s);
  off.t_mm[1] += 1;
  off.R = rotation_from_vector({0.01, 0, 0}) * off.R;
  TargetMotion sure = before;
  TargetMotion unsure = before;
  EXPECT_TRUE(sure.observe(now_ns, off, ObservationNoise{0.3, 0.003}));
  EXPECT_TRUE(unsure.observe(now_ns, off, ObservationNoise{30, 0.3}));
  EXPECT_LT(distance_mm(sure.at(now_ns).T_W_M, off), 0.7);
  EXPECT_LT(distance_rad(sure.at(now_ns).T_W_M, off), 0.007);
  EXPECT_LT(distance_mm(unsure.at(now_ns).T_W_M, before.at(now_ns).T_W_M), 0.01);
  EXPECT_LT(distance_rad(unsure.at(now_ns).T_W_M, before.at(now_ns).T_W_M), 1e-4);
}

TEST(TargetMotionLimits, LeavesOutliersOutAndStartsAnewWhereTheyStay) {
  const Vector3 jumps_mm[] = {{40, 0, 0}, {0, 0, 0}};
  const Vector3 jumps_rad[] = {{0, 0, 0}, {0.5, 0, 0}};
  for (int kind = 0; kind < 2; ++kind) {
    const auto elsewhere = [&](int frame) {
      const Transform T = kStraight.at(frame * kFrame_s);
      return Transform{rotation_from_vector(jumps_rad[kind]) * T.R, T.t_mm + jumps_mm[kind]};
    };
    TargetMotion motion = following(kStraight, 60);
    int frame = 60;
    // Three wrong ones, a right one, three wrong ones: the count is of those in a row.
    for (int round = 0; round < 2; ++round) {
      for (int i = 0; i < 3; ++i, ++frame) {
        const TargetState before = motion.at(frame * kFrame_ns);
        EXPECT_FALSE(motion.observe(frame * kFrame_ns, elsewhere(frame)));
        EXPECT_FALSE(motion.observe(frame * kFrame_ns, elsewhere(frame)));  // the same again does not count
        expect_same(motion.at(frame * kFrame_ns), before);
      }
      EXPECT_TRUE(motion.observe(frame * kFrame_ns, kStraight.at(frame * kFrame_s)));
      ++frame;
    }
    EXPECT_LT(distance_mm(motion.at(frame * kFrame_ns).T_W_M, kStraight.at(frame * kFrame_s)), 0.1);
    for (int i = 0; i < 4; ++i, ++frame) {
      EXPECT_EQ(motion.observe(frame * kFrame_ns, elsewhere(frame)), i == 3) << kind;
    }
    EXPECT_LT(distance_mm(motion.at(motion.last_ns()).T_W_M, elsewhere(frame - 1)), 1e-9);
    EXPECT_LT(distance_rad(motion.at(motion.last_ns()).T_W_M, elsewhere(frame - 1)), 1e-9);
    for (int i = 0; i < 30; ++i, ++frame) {
      EXPECT_TRUE(motion.observe(frame * kFrame_ns, elsewhere(frame)));
    }
    EXPECT_NEAR(motion.at(frame * kFrame_ns).velocity.linear_mm_per_s[0], 100, 0.5);
  }
}

TEST(TargetMotionLimits, ComesToRestWhereNothingIsSeen) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    RandomArm poses(random.bits());
    const Transform T = poses.transform(500);
    const Vector3 v = poses.vector(300);
    const Straight truth{T, v, poses.vector(2)};
    TargetMotionOptions options;
    options.coast_s = random.between(0.05, 1);
    options.rest_s = random.between(0.05, 1);
    const TargetMotion motion = following(truth, 20, options);
    const TargetState last = motion.at(motion.last_ns());
    // Continuous in value and velocity, which is the value's derivative.
    const std::int64_t step_ns = 1'000'000;
    TargetState before = last;
    for (std::int64_t t_ns = step_ns; t_ns < 2'200'000'000; t_ns += step_ns) {
      const TargetState now = motion.at(motion.last_ns() + t_ns);
      const Vector6 moved = pose_difference(before.T_W_M, now.T_W_M) / 0.001;
      const Vector3 v_mean = 0.5 * (before.velocity.linear_mm_per_s + now.velocity.linear_mm_per_s);
      const Vector3 w_mean = 0.5 * (before.velocity.angular_rad_per_s + now.velocity.angular_rad_per_s);
      RC_ASSERT((moved.head<3>() - v_mean).norm() < 0.01 * (1 + v.norm()));
      RC_ASSERT((moved.tail<3>() - w_mean).norm() < 0.05);
      before = now;
    }
    const TargetState ever = motion.at(kEver_ns);
    RC_ASSERT(ever.velocity.linear_mm_per_s == Vector3(0, 0, 0));
    RC_ASSERT(ever.velocity.angular_rad_per_s == Vector3(0, 0, 0));
    RC_ASSERT(ever.acceleration.linear_mm_per_s2 == Vector3(0, 0, 0));
    RC_ASSERT(distance_mm(ever.T_W_M, before.T_W_M) < 1e-9);
    const double most_mm =
        (last.velocity.linear_mm_per_s.norm() + last.acceleration.linear_mm_per_s2.norm() * options.coast_s) *
        (options.coast_s + options.rest_s / 2);
    RC_ASSERT(distance_mm(ever.T_W_M, last.T_W_M) <= most_mm + 1e-9);
  }));
}

TEST(TargetMotionLimits, StartsAnewAfterALongGap) {
  TargetMotion motion = following(kStraight, 30);
  const Transform back = {rotation_from_vector({1, 0, 0}), {0, 0, 900}};
  const std::int64_t then_ns = motion.last_ns() + 600'000'000;
  EXPECT_TRUE(motion.observe(then_ns, back));
  EXPECT_LT(distance_mm(motion.at(then_ns).T_W_M, back), 1e-9);
  EXPECT_EQ(motion.at(then_ns + kFrame_ns).velocity.linear_mm_per_s.norm(), 0);
}

TEST(TargetMotionLimits, AnyInstantIsAnswered) {
  TargetMotion motion;
  EXPECT_FALSE(motion.known());
  EXPECT_EQ(motion.at(123).T_W_M.R, Matrix3::Identity());
  EXPECT_EQ(motion.at(kEver_ns).velocity.linear_mm_per_s.norm(), 0);
  const std::int64_t first_ns = std::numeric_limits<std::int64_t>::min();
  EXPECT_TRUE(motion.observe(first_ns, kStraight.at(0)));
  EXPECT_TRUE(motion.observe(first_ns + kFrame_ns, kStraight.at(kFrame_s)));
  expect_same(motion.at(first_ns), motion.at(motion.last_ns()));  // no way back
  EXPECT_TRUE(motion.at(kEver_ns).T_W_M.t_mm.allFinite());
  EXPECT_TRUE(motion.observe(kEver_ns, kStraight.at(0)));
  EXPECT_FALSE(motion.observe(kEver_ns, kStraight.at(0)));
  // As fast as may be: still rigid.
  TargetMotionOptions wild;
  wild.start_angular_speed_rad_per_s = 1e9;
  wild.coast_s = 10;
  EXPECT_EQ(motion.configure(wild), Status::kOk);
  EXPECT_TRUE(motion.observe(0, kStraight.at(0)));
  EXPECT_TRUE(motion.observe(1000, {rotation_from_vector({0, 3, 0}), {0, 0, 500}}));
  EXPECT_TRUE(is_rigid(motion.at(kEver_ns).T_W_M, 1e-9));
}

TEST(TargetMotionLimits, RefusesOptionsThatMakeNoSense) {
  const auto status = [](auto change) {
    TargetMotionOptions options;
    change(options);
    return TargetMotion{}.configure(options);
  };
  EXPECT_EQ(status([](auto&) {}), Status::kOk);
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(status([&](auto& o) { o.position_noise_mm = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.rotation_noise_rad = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.jerk_mm_per_s3 = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.angular_jerk_rad_per_s3 = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.acceleration_memory_s = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.start_speed_mm_per_s = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.start_angular_speed_rad_per_s = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.coast_s = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.rest_s = bad; }), Status::kBadGains);
    EXPECT_EQ(status([&](auto& o) { o.gate_sigma = bad; }), Status::kBadGains);
  }
  EXPECT_EQ(status([](auto& o) { o.restart_after = 0; }), Status::kBadGains);
}

// One number proves behaviour unchanged, on x86-64 and arm64.
TEST(TargetMotionLimits, KeepsItsBits) {
  Random random(42);
  RandomArm poses(7);
  testing::BitHash hash;
  TargetMotion motion;
  std::int64_t t_ns = 0;
  for (int start = 0; start < 20; ++start) {
    const Transform T = poses.transform(500);
    const Vector3 v = poses.vector(200);
    const Straight truth{T, v, poses.vector(1)};
    for (int frame = 0; frame < 100; ++frame) {
      t_ns += kFrame_ns / 2 + random.below(static_cast<int>(kFrame_ns));
      const Vector3 off_mm = poses.vector(1);
      const Transform seen = truth.at(frame * kFrame_s);
      hash.add(motion.observe(t_ns, {rotation_from_vector(poses.vector(0.01)) * seen.R, seen.t_mm + off_mm}));
      const TargetState state = motion.at(t_ns + random.below(1'200'000'000));
      for (int i = 0; i < 3; ++i) {
        hash.add(state.T_W_M.t_mm[i]);
        hash.add(state.T_W_M.R(i, 0));
        hash.add(state.T_W_M.R(i, 2));
        hash.add(state.velocity.linear_mm_per_s[i]);
        hash.add(state.velocity.angular_rad_per_s[i]);
        hash.add(state.acceleration.linear_mm_per_s2[i]);
        hash.add(state.acceleration.angular_rad_per_s2[i]);
      }
    }
  }
  EXPECT_EQ(hash.value(), 0x2F10691B03960ACFULL)
      << "0x" << std::hex << std::uppercase << hash.value() << "ULL";
}

}  // namespace
}  // namespace vergence
