// The target's motion: followed, predicted over latency, and never run away with.
#include "algo/target_motion.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "algo/rotation_vector.hpp"
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

double seconds(std::int64_t t_ns) {
  return static_cast<double>(t_ns) * 1e-9;
}

// Sum of twelve: near enough to a normal deviate, and the same on every machine.
double deviate(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.between(0, 1);
  return sum;
}

Vector3 noise(Random& random, double deviation) {
  const double x = deviation * deviate(random);
  const double y = deviation * deviate(random);
  return {x, y, deviation * deviate(random)};
}

TargetMotion filter_with(const TargetMotionOptions& options) {
  TargetMotion motion;
  EXPECT_EQ(motion.configure(options), Status::kOk);
  return motion;
}

// Constant acceleration from a start, about a fixed axis in rotation.
struct Steady {
  Vector3 p, v, a;
  Vector3 axis;
  double w, aw;

  [[nodiscard]] Transform at(double t_s) const {
    return {rotation_from_vector(axis * (w * t_s + aw * t_s * t_s / 2)), p + v * t_s + a * (t_s * t_s / 2)};
  }
};

void expect_state(const TargetState& state, const Steady& truth, double t_s, double tolerance) {
  EXPECT_LT(distance_mm(state.T_W_M, truth.at(t_s)), tolerance);
  EXPECT_LT(distance_rad(state.T_W_M, truth.at(t_s)), 0.01 * tolerance);
  EXPECT_LT((state.velocity.linear_mm_per_s - (truth.v + truth.a * t_s)).norm(), 10 * tolerance);
  EXPECT_LT((state.velocity.angular_rad_per_s - truth.axis * (truth.w + truth.aw * t_s)).norm(),
            0.1 * tolerance);
  EXPECT_LT((state.acceleration.linear_mm_per_s2 - truth.a).norm(), 100 * tolerance);
  EXPECT_LT((state.acceleration.angular_rad_per_s2 - truth.axis * truth.aw).norm(), tolerance);
}

TEST(TargetMotion, FollowsSteadyMotionExactlyInTheLimit) {
  const Vector3 axis = Vector3(1, -2, 2) / 3;
  const Steady velocity{{10, 20, -500}, {120, -80, 30}, {0, 0, 0}, axis, 0.7, 0};
  const Steady acceleration{{10, 20, -500}, {120, -80, 30}, {40, 60, -70}, axis, 0.1, 0.05};
  TargetMotionOptions lasting;
  lasting.acceleration_memory_s = 1e6;
  struct {
    Steady truth;
    TargetMotionOptions options;
  } const cases[] = {{velocity, {}}, {acceleration, lasting}};
  for (const auto& [truth, options] : cases) {
    TargetMotion motion = filter_with(options);
    Random random(5);
    std::int64_t t_ns = 0;
    for (int frame = 0; frame < 600; ++frame) {
      t_ns += kFrame_ns / 4 + random.below(static_cast<int>(kFrame_ns));  // irregular
      EXPECT_TRUE(motion.observe(t_ns, truth.at(seconds(t_ns)))) << frame;
    }
    expect_state(motion.at(t_ns), truth, seconds(t_ns), 1e-5);
    expect_state(motion.at(t_ns + 2 * kFrame_ns), truth, seconds(t_ns + 2 * kFrame_ns), 1e-5);
  }
}

// An acceleration that fades is believed less than it deserves: how much that costs.
TEST(TargetMotion, FadingCostsLittleInSteadyAcceleration) {
  const Steady truth{{0, 0, 0}, {0, 0, 0}, {200, 0, 0}, {0, 0, 1}, 0, 0};
  TargetMotion motion = filter_with({});
  for (int frame = 0; frame < 300; ++frame) {
    ASSERT_TRUE(motion.observe(frame * kFrame_ns, truth.at(frame * kFrame_s)));
  }
  const double t_s = 299 * kFrame_s + 0.035;
  const TargetState state = motion.at(299 * kFrame_ns + 35'000'000);
  const double off_mm = distance_mm(state.T_W_M, truth.at(t_s));
  const double off_mm_per_s = (state.velocity.linear_mm_per_s - truth.a * t_s).norm();
  std::printf("at 200 mm/s^2, 35 ms ahead: %.3f mm, %.2f mm/s\n", off_mm, off_mm_per_s);
  EXPECT_LT(off_mm, 0.5);
  EXPECT_LT(off_mm_per_s, 5);
}

// Root mean squares, in mm and mm/s or rad and rad/s.
struct SineResult {
  double ahead = 0;     // of the pose predicted 35 ms ahead
  double rate = 0;      // of the velocity there
  double held = 0;      // of the last observation, taken as it is for 35 ms
  double filtered = 0;  // of the pose at the observation's instant
  double raw = 0;       // of the observation
  int refused = 0;
};

enum class Part {
  kPosition,
  kRotation
};

struct Sine {
  Part part;
  double amplitude;
  double w;
  double deviation;   // of the noise of each axis
  bool gaps = false;  // every fifth frame missing, the others up to a third of a period late
};

// Along or about a skew axis, at 30 fps for a minute; the first 2 s do not count.
SineResult follow(const Sine& sine, TargetMotionOptions options) {
  const bool moves = sine.part == Part::kPosition;
  (moves ? options.position_noise_mm : options.rotation_noise_rad) = sine.deviation;
  TargetMotion motion = filter_with(options);
  Random random(11);
  const Vector3 axis = Vector3(2, -1, 2) / 3;
  const auto pose = [&](double t_s, const Vector3& off) -> Transform {
    const Vector3 x = axis * (sine.amplitude * std::sin(sine.w * t_s));
    if (moves) return {Matrix3::Identity(), x + off};
    return {rotation_from_vector(off) * rotation_from_vector(x), Vector3::Zero()};
  };
  const auto squared = [&](const Transform& T, double t_s) {
    const Transform truth = pose(t_s, Vector3::Zero());
    const double distance = moves ? distance_mm(T, truth) : distance_rad(T, truth);
    return distance * distance;
  };
  SineResult result;
  int count = 0;
  for (int frame = 0; frame < 1800; ++frame) {
    const std::int64_t late_ns = sine.gaps ? random.below(static_cast<int>(kFrame_ns / 3)) : 0;
    const Vector3 off = noise(random, sine.deviation);
    if (sine.gaps && random.below(5) == 0) continue;
    const std::int64_t now_ns = frame * kFrame_ns + late_ns;
    const Transform seen = pose(seconds(now_ns), off);
    result.refused += motion.observe(now_ns, seen) ? 0 : 1;
    if (frame < 60) continue;
    const std::int64_t then_ns = now_ns + 35'000'000;
    const TargetState state = motion.at(then_ns);
    const Twist& v = state.velocity;
    const Vector3 rate = axis * (sine.amplitude * sine.w * std::cos(sine.w * seconds(then_ns)));
    result.ahead += squared(state.T_W_M, seconds(then_ns));
    result.rate += ((moves ? v.linear_mm_per_s : v.angular_rad_per_s) - rate).squaredNorm();
    result.held += squared(seen, seconds(then_ns));
    result.filtered += squared(motion.at(now_ns).T_W_M, seconds(now_ns));
    result.raw += squared(seen, seconds(now_ns));
    ++count;
  }
  for (double* x : {&result.ahead, &result.rate, &result.held, &result.filtered, &result.raw}) {
    *x = std::sqrt(*x / count);
  }
  std::printf("%6.3g at %.3f /s, noise %.3g: ahead %.4f, velocity %.3f, held %.4f; filtered %.4f, raw %.4f\n",
              sine.amplitude, sine.w, sine.deviation, result.ahead, result.rate, result.held, result.filtered,
              result.raw);
  return result;
}

TEST(TargetMotion, PredictsASineOverTheLatency) {
  for (const bool gaps : {false, true}) {
    const SineResult slow = follow({Part::kPosition, 150, 0.314, 0.3, gaps}, {});
    EXPECT_LT(slow.ahead, 1);
    const SineResult r = follow({Part::kPosition, 150, 1.256, 0.3, gaps}, {});
    EXPECT_EQ(r.refused, 0);
    EXPECT_LT(r.ahead, 1);
    EXPECT_LT(r.rate, 15);
    EXPECT_LT(r.ahead, r.held / 4);
    EXPECT_LT(r.filtered, 0.9 * r.raw);
  }
  TargetMotionOptions quick;
  quick.jerk_mm_per_s3 = 3000;
  const SineResult r = follow({Part::kPosition, 30, 6, 0.3}, quick);
  EXPECT_EQ(r.refused, 0);
  EXPECT_LT(r.ahead, 1.5);
}

TEST(TargetMotion, PredictsATurnOverTheLatency) {
  for (const bool gaps : {false, true}) {
    const SineResult r = follow({Part::kRotation, 0.4, 1.256, 0.003, gaps}, {});
    EXPECT_EQ(r.refused, 0);
    EXPECT_LT(r.ahead, 0.01);
    EXPECT_LT(r.rate, 0.15);
    EXPECT_LT(r.ahead, r.held);
    EXPECT_LT(r.filtered, 0.9 * r.raw);
  }
  // Over half a turn each way: no branch of the rotation's description shows.
  const SineResult wide = follow({Part::kRotation, 4, 0.628, 0.003}, {});
  EXPECT_EQ(wide.refused, 0);
  EXPECT_LT(wide.ahead, 0.01);
}

TEST(TargetMotion, QuietensNoiseOfATargetAtRest) {
  TargetMotionOptions calm;
  calm.jerk_mm_per_s3 = 20;
  calm.angular_jerk_rad_per_s3 = 0.1;
  const SineResult position = follow({Part::kPosition, 0, 0, 1}, calm);
  EXPECT_LT(position.filtered, 0.55 * position.raw);
  const SineResult rotation = follow({Part::kRotation, 0, 0, 0.01}, calm);
  EXPECT_LT(rotation.filtered, 0.55 * rotation.raw);
}

// Anything a target may do: a pose at each of some instants.
struct Seen {
  std::int64_t stamp_ns;
  Transform T_W_M;
};

std::array<Seen, 60> any_motion(Random& random) {
  RandomArm poses(random.bits());
  const Transform start = poses.transform(500);
  const Vector3 v = poses.vector(200);
  const Vector3 w = poses.vector(1);
  std::array<Seen, 60> seen{};
  std::int64_t t_ns = random.below(1'000'000'000);
  const std::int64_t first_ns = t_ns;
  for (Seen& one : seen) {
    const double t_s = seconds(t_ns - first_ns);
    one = {t_ns,
           {rotation_from_vector(w * t_s + noise(random, 0.004)) * start.R,
            start.t_mm + v * t_s + noise(random, 0.4)}};
    t_ns += kFrame_ns / 2 + random.below(static_cast<int>(kFrame_ns));
  }
  return seen;
}

TEST(TargetMotion, TurnsWithTheWorld) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const auto seen = any_motion(random);
    const Transform T_V_W = RandomArm(random.bits()).transform(1000);
    TargetMotion in_W = filter_with({});
    TargetMotion in_V = filter_with({});
    for (const Seen& one : seen) {
      RC_ASSERT(in_W.observe(one.stamp_ns, one.T_W_M) == in_V.observe(one.stamp_ns, T_V_W * one.T_W_M));
      const std::int64_t then_ns = one.stamp_ns + random.below(1'200'000'000);
      const TargetState a = in_W.at(then_ns);
      const TargetState b = in_V.at(then_ns);
      const Matrix3& R = T_V_W.R;
      RC_ASSERT(distance_mm(T_V_W * a.T_W_M, b.T_W_M) < 1e-8);
      RC_ASSERT(distance_rad(T_V_W * a.T_W_M, b.T_W_M) < 1e-10);
      RC_ASSERT((R * a.velocity.linear_mm_per_s - b.velocity.linear_mm_per_s).norm() < 1e-7);
      RC_ASSERT((R * a.velocity.angular_rad_per_s - b.velocity.angular_rad_per_s).norm() < 1e-9);
      RC_ASSERT((R * a.acceleration.linear_mm_per_s2 - b.acceleration.linear_mm_per_s2).norm() < 1e-6);
      RC_ASSERT((R * a.acceleration.angular_rad_per_s2 - b.acceleration.angular_rad_per_s2).norm() < 1e-8);
    }
  }));
}

TEST(TargetMotion, KnowsTheVelocityFromTheSecondObservation) {
  const Steady truth{{0, 0, 500}, {100, 0, 0}, {0, 0, 0}, {0, 1, 0}, 0.5, 0};
  TargetMotion motion = filter_with({});
  EXPECT_FALSE(motion.known());
  EXPECT_TRUE(motion.observe(7, truth.at(0)));
  EXPECT_TRUE(motion.known());
  EXPECT_EQ(motion.at(7).velocity.linear_mm_per_s.norm(), 0);
  EXPECT_TRUE(motion.observe(7 + kFrame_ns, truth.at(kFrame_s)));
  EXPECT_NEAR(motion.at(7 + kFrame_ns).velocity.linear_mm_per_s[0], 100, 2);
  EXPECT_NEAR(motion.at(7 + kFrame_ns).velocity.angular_rad_per_s[1], 0.5, 0.03);
  EXPECT_EQ(motion.last_ns(), 7 + kFrame_ns);
  motion.forget();
  EXPECT_FALSE(motion.known());
}

// The closed form of an acceleration that fades, over all ratios of time and memory.
TEST(TargetMotion, FadesAsTheExponential) {
  for (const double memory_s : {1e-3, 0.01, 0.1, 0.5, 1.0, 3.0, 100.0, 1e6}) {
    TargetMotionOptions options;
    options.acceleration_memory_s = memory_s;
    options.coast_s = 10;
    TargetMotion motion = filter_with(options);
    const Steady truth{{0, 0, 0}, {10, 0, 0}, {50, 0, 0}, {0, 0, 1}, 0, 0};
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(motion.observe(i * kFrame_ns, truth.at(i * kFrame_s)));
    const TargetState from = motion.at(motion.last_ns());
    const double v = from.velocity.linear_mm_per_s[0];
    const double a = from.acceleration.linear_mm_per_s2[0];
    for (const std::int64_t t_ns : {1'000LL, 1'000'000LL, 35'000'000LL, 400'000'000LL, 9'000'000'000LL}) {
      const TargetState to = motion.at(motion.last_ns() + t_ns);
      const double t_s = seconds(t_ns);
      const long double x = static_cast<long double>(t_s) / memory_s;
      const long double rate_s = -std::expm1(-x) * memory_s;
      // From 1e-3 up the difference has digits enough in long double.
      const long double value_s2 =
          x < 1e-3L ? t_s * t_s * (0.5L - x / 6 + x * x / 24) : memory_s * (t_s - rate_s);
      EXPECT_NEAR(to.acceleration.linear_mm_per_s2[0], static_cast<double>(a * std::exp(-x)),
                  1e-11 * (1 + std::fabs(a)));
      EXPECT_NEAR(to.velocity.linear_mm_per_s[0], static_cast<double>(v + a * rate_s),
                  1e-11 * (1 + std::fabs(a)));
      EXPECT_NEAR(to.T_W_M.t_mm[0], static_cast<double>(from.T_W_M.t_mm[0] + v * t_s + a * value_s2),
                  1e-10 * (1 + std::fabs(a)));
    }
  }
}

}  // namespace
}  // namespace vergence
