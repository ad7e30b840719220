// Gaze: targets in the centre of both images, and kept there while they move.
#include "algo/eye_vergence.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "algo/trigonometry.hpp"
#include "tests/support/random.hpp"

namespace vergence {
namespace {

using testing::Random;

const double kNan = std::numeric_limits<double>::quiet_NaN();

Vector3 any_target(Random& random) {
  const double x = random.between(-600, 600);
  const double y = random.between(-500, 400);
  return {x, y, random.between(100, 1500)};
}

EyeMount any_mount(Random& random) {
  return {random.between(20, 200), random.between(-150, 50), random.between(-80, 80)};
}

TEST(ArcTangent, AgreesWithLibmTo1e14) {
  for (int i = -2000; i <= 2000; ++i) {
    const double angle = i * 0.00157 + 1e-7;
    for (const double r : {1e-200, 1.0, 3e100}) {
      const double x = r * std::cos(angle);
      const double y = r * std::sin(angle);
      ASSERT_NEAR(arc_tangent2(y, x), std::atan2(y, x), 1e-15 + 4e-16 * std::abs(angle));
    }
  }
  EXPECT_EQ(arc_tangent2(0, 0), 0);
  EXPECT_EQ(arc_tangent2(0, 1), 0);
  EXPECT_DOUBLE_EQ(arc_tangent2(0, -1), std::acos(-1.0));
  EXPECT_DOUBLE_EQ(arc_tangent2(-2, 0), -std::acos(-1.0) / 2);
}

TEST(EyeAngles, CentreTheTargetInBothImages) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const EyeMount mount = any_mount(random);
    const Vector3 target = any_target(random);
    const auto angles = desired_eye_angles(mount, target);
    RC_ASSERT(angles.has_value());
    const Vector3 in_left = left_eye_in_hand(left_eye_at_zero(mount), *angles).inverse() * target;
    const Vector3 in_right = right_eye_in_hand(right_eye_at_zero(mount), *angles).inverse() * target;
    for (const Vector3& seen : {in_left, in_right}) {
      RC_ASSERT(seen[2] > 0);
      RC_ASSERT(std::abs(seen[0]) < 1e-9);
      RC_ASSERT(std::abs(seen[1]) < 1e-9);
    }
  }));
}

TEST(EyeAngles, AreThoseOfThePrintedEquationsWithoutTilt) {
  const EyeMount mount;
  const auto angles = desired_eye_angles(mount, {50, -100, 545});
  ASSERT_TRUE(angles.has_value());
  EXPECT_EQ(angles->tilt_rad, 0);
  EXPECT_NEAR(angles->pan_right_rad, std::atan2(120 - 50, 545), 1e-14);
  EXPECT_NEAR(angles->pan_left_rad, std::atan2(120 + 50, 545), 1e-14);
}

TEST(Gaze, MeetsAtTheTarget) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const EyeMount mount = any_mount(random);
    const Vector3 target = any_target(random);
    const Gaze g = gaze(mount, *desired_eye_angles(mount, target));
    RC_ASSERT(g.point_mm.has_value());
    // The nearer the eyes are together, the more an angle's rounding moves the point.
    RC_ASSERT((*g.point_mm - target).norm() < 1e-12 * target.squaredNorm() / mount.half_baseline_mm + 1e-10);
  }));
}

TEST(Gaze, IsThatOfThePrintedEquationsWithoutTilt) {
  const EyeAngles angles{0, 0.3, 0.2};
  const double r = 1 / std::tan(0.3);
  const double l = 1 / std::tan(0.2);
  const auto point = gaze(EyeMount{}, angles).point_mm;
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR((*point)[0], 240 * r / (l + r) - 120, 1e-10);
  EXPECT_NEAR((*point)[1], -100, 1e-10);
  EXPECT_NEAR((*point)[2], 240 * l * r / (l + r), 1e-10);
}

TEST(Gaze, ParallelAndDivergingEyesMeetNowhere) {
  for (const EyeAngles& angles :
       {EyeAngles{0.1, 0, 0}, EyeAngles{0.1, -0.2, 0.2}, EyeAngles{0.1, -0.3, 0.1}}) {
    const Gaze g = gaze(EyeMount{}, angles);
    EXPECT_FALSE(g.point_mm.has_value());
    EXPECT_NEAR(g.direction.norm(), 1, 1e-14);
    EXPECT_GT(g.direction[2], 0);
    EXPECT_NEAR(g.direction[1] / g.direction[2], std::tan(0.1), 1e-14);
  }
  // Lines that meet behind the eyes.
  EXPECT_FALSE(gaze(EyeMount{}, {0, 2.0, 0.5}).point_mm.has_value());
  // Both 0.2 to the right: parallel, and the direction says so.
  EXPECT_NEAR(gaze(EyeMount{}, {0, -0.2, 0.2}).direction[0], std::sin(0.2), 1e-14);
}

TEST(EyeAngles, ThereAreNoneForWhatIsNotInFront) {
  const EyeMount mount;
  for (const Vector3& target :
       {Vector3(0, 0, -500), Vector3(0, 0, 0), Vector3(0, -100, 0.5), Vector3(kNan, 0, 500),
        Vector3(0, kNan, 500), Vector3(0, 0, kNan), Vector3(0, 0, INFINITY), Vector3(-INFINITY, 0, 500),
        Vector3(1e200, 0, 500)}) {
    EXPECT_FALSE(desired_eye_angles(mount, target).has_value()) << target.transpose();
  }
  EXPECT_TRUE(desired_eye_angles(mount, {0, 0, 2}).has_value());
}

TEST(EyeRates, AreTheDerivativesOfTheAngles) {
  ASSERT_TRUE(rc::check([] {
    Random random(*rc::gen::arbitrary<std::uint64_t>());
    const EyeMount mount = any_mount(random);
    const Vector3 target = any_target(random);
    const Vector3 v{random.between(-300, 300), random.between(-300, 300), random.between(-300, 300)};
    constexpr double kStep_s = 1e-5;
    const auto before = desired_eye_angles(mount, target - v * kStep_s);
    const auto after = desired_eye_angles(mount, target + v * kStep_s);
    const EyeRates rates = desired_eye_rates(mount, target, v);
    const double per_s = 1 / (2 * kStep_s);
    RC_ASSERT(std::abs((after->tilt_rad - before->tilt_rad) * per_s - rates.tilt_rad_per_s) < 1e-7);
    RC_ASSERT(std::abs((after->pan_right_rad - before->pan_right_rad) * per_s - rates.pan_right_rad_per_s) <
              1e-7);
    RC_ASSERT(std::abs((after->pan_left_rad - before->pan_left_rad) * per_s - rates.pan_left_rad_per_s) <
              1e-7);
  }));
}

TEST(ApparentVelocity, IsThatOfTheTargetSeenFromAMovingHand) {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Transform T_W_H = to_transform({any_target(random), Vector3(random.between(-0.5, 0.5), 0.2, 0.3)});
    const Vector3 p = any_target(random);
    const Vector3 target_velocity{random.between(-100, 100), 20, 5};  // all in the hand's axes
    const Vector3 linear{random.between(-100, 100), -30, 10};
    const Vector3 angular{random.between(-1, 1), 0.4, -0.2};
    constexpr double kStep_s = 1e-6;
    const auto seen_at = [&](double t) -> Vector3 {
      const Transform moved{T_W_H.R * rotation_from_quaternion_vector(angular * t / 2),
                            T_W_H.t_mm + T_W_H.R * linear * t};
      return moved.inverse() * Vector3(T_W_H * p + T_W_H.R * target_velocity * t);
    };
    const Vector3 difference = (seen_at(kStep_s) - seen_at(-kStep_s)) / (2 * kStep_s);
    EXPECT_LT((difference - apparent_velocity(p, target_velocity, linear, angular)).norm(), 1e-5);
  }
}

// Motors of 0.9 degrees a step in sixteenths.
constexpr double kStepsPerRad = 400 * 16 / 6.283185307179586;
constexpr double kPeriod_s = 1.0 / 30;

std::array<JointLimits, kEyeMotors> motor_limits() {
  const JointLimits pan{-0.6, 1.0, 3.0, 30.0, 900.0};
  return {JointLimits{-0.8, 0.8, 3.0, 30.0, 900.0}, pan, pan};
}

EyeVergence eyes(double latency_s) {
  EyeVergence eyes;
  EyeControl control;
  control.latency_s = latency_s;
  control.steps_per_rad.fill(kStepsPerRad);
  EXPECT_EQ(eyes.configure(EyeMount{}, control, motor_limits(), kPeriod_s), Status::kOk);
  return eyes;
}

void turn(EyeAngles& angles, const EyeCommand& command, double seconds) {
  angles.tilt_rad += command.rate_rad_per_s[0] * seconds;
  angles.pan_right_rad += command.rate_rad_per_s[1] * seconds;
  angles.pan_left_rad += command.rate_rad_per_s[2] * seconds;
}

enum class Knowledge {
  kNone,
  kDifference,
  kExact
};

struct Response {
  double gain_db;
  double phase_deg;
};

// Gaze along x over that of a target on a lateral sine, 150 mm either side, 545 mm ahead and at another
// height than the eyes. A frame is stamped every 1/30 s, what follows from it acts 9 ms later, for a period.
Response lateral_response(double w, Knowledge knowledge) {
  constexpr double kLatency_s = 0.009;
  EyeVergence controller = eyes(kLatency_s);
  const auto target_at = [w](double t) { return Vector3(150 * std::sin(w * t), 0, 545); };
  EyeAngles angles = *desired_eye_angles(EyeMount{}, target_at(0));
  double in_phase = 0;
  double quadrature = 0;
  int samples = 0;
  const int frames = static_cast<int>(std::lround(4 * 6.283185307179586 / w / kPeriod_s));
  for (int frame = 0; frame < frames; ++frame) {
    const double t = frame * kPeriod_s;
    Vector3 velocity = Vector3::Zero();
    if (knowledge == Knowledge::kExact) velocity[0] = 150 * w * std::cos(w * t);
    if (knowledge == Knowledge::kDifference) velocity = (target_at(t) - target_at(t - kPeriod_s)) / kPeriod_s;
    const EyeCommand command = controller.step(target_at(t), velocity, angles);
    EXPECT_FALSE(command.holds);
    constexpr int kParts = 20;
    for (int part = 0; part < kParts; ++part) {
      turn(angles, command, kPeriod_s / kParts);
      if (frame < frames / 4) continue;  // settled: three full turns are measured
      const double now = t + kLatency_s + (part + 1) * kPeriod_s / kParts;
      const double x = (*gaze(EyeMount{}, angles).point_mm)[0];
      in_phase += x * std::sin(w * now);
      quadrature += x * std::cos(w * now);
      ++samples;
    }
  }
  const double amplitude = 2 * std::hypot(in_phase, quadrature) / samples;
  return {20 * std::log10(amplitude / 150), std::atan2(quadrature, in_phase) * 57.29577951308232};
}

TEST(EyeVergence, FollowsALateralSineWithoutLag) {
  const char* names[] = {"none", "difference", "exact"};
  for (const double w : {0.314, 0.628, 1.256}) {
    for (const Knowledge knowledge : {Knowledge::kNone, Knowledge::kDifference, Knowledge::kExact}) {
      const Response r = lateral_response(w, knowledge);
      std::printf("%.3f rad/s, velocity %-10s: gain %+.4f dB, phase %+.3f deg\n", w,
                  names[static_cast<int>(knowledge)], r.gain_db, r.phase_deg);
      EXPECT_LT(std::abs(r.gain_db), 0.1);
      if (knowledge != Knowledge::kNone) {
        EXPECT_LT(std::abs(r.phase_deg), 2);
      }
    }
  }
  // Without feed-forward the lag is latency, half a period of holding and half of ramping: what it is there
  // for.
  EXPECT_LT(lateral_response(1.256, Knowledge::kNone).phase_deg, -1.5);
  EXPECT_LT(std::abs(lateral_response(1.256, Knowledge::kDifference).phase_deg), 0.2);
}

TEST(EyeVergence, AimsAtWhereASteadyTargetWillBe) {
  EyeVergence controller = eyes(0.009);
  const Vector3 velocity{300, 40, -60};
  const auto target_at = [&velocity](double t) -> Vector3 { return Vector3(-200, 0, 350) + velocity * t; };
  EyeAngles angles = *desired_eye_angles(EyeMount{}, target_at(0.009));
  for (int frame = 0; frame < 40; ++frame) {
    const double t = frame * kPeriod_s;
    turn(angles, controller.step(target_at(t), velocity, angles), kPeriod_s);
    if (frame < 5) continue;  // the motors start from rest
    const EyeAngles goal = *desired_eye_angles(EyeMount{}, target_at(t + 0.009 + kPeriod_s));
    EXPECT_NEAR(angles.tilt_rad, goal.tilt_rad, 3e-5) << frame;
    EXPECT_NEAR(angles.pan_right_rad, goal.pan_right_rad, 3e-5) << frame;
    EXPECT_NEAR(angles.pan_left_rad, goal.pan_left_rad, 3e-5) << frame;
  }
}

TEST(EyeVergence, LooksAtATargetThatAppearsWithoutOvershoot) {
  EyeVergence controller = eyes(0);
  EyeAngles angles;
  const Vector3 target{200, 250, 500};
  const EyeAngles goal = *desired_eye_angles(EyeMount{}, target);
  int frames = 0;
  while (std::abs(angles.tilt_rad - goal.tilt_rad) + std::abs(angles.pan_left_rad - goal.pan_left_rad) +
             std::abs(angles.pan_right_rad - goal.pan_right_rad) >
         1e-9) {
    const EyeCommand command = controller.step(target, Vector3::Zero(), angles);
    for (std::size_t i = 0; i < kEyeMotors; ++i) {
      EXPECT_LE(std::abs(command.rate_rad_per_s[i]), 3.0 * (1 + 1e-9));
      EXPECT_DOUBLE_EQ(command.steps_per_s[i], command.rate_rad_per_s[i] * kStepsPerRad);
    }
    turn(angles, command, kPeriod_s);
    EXPECT_LT(angles.tilt_rad, goal.tilt_rad + 0.02);
    EXPECT_LT(angles.pan_left_rad, goal.pan_left_rad + 0.02);
    ASSERT_LT(++frames, 20);
  }
  std::printf("a glance of %.2f rad takes %d frames\n", goal.tilt_rad, frames);
}

TEST(EyeVergence, StopsAtTheEndOfAMotor) {
  EyeVergence controller = eyes(0);
  EyeAngles angles;
  for (int frame = 0; frame < 100; ++frame) {
    const EyeCommand command = controller.step(Vector3(0, 2000, 200), Vector3::Zero(), angles);
    turn(angles, command, kPeriod_s);
    ASSERT_LE(angles.tilt_rad, 0.8 + 1e-9);
  }
  EXPECT_NEAR(angles.tilt_rad, 0.8, 1e-6);
}

TEST(EyeVergence, HoldsWithNothingToLookAt) {
  for (const auto& [target, velocity] : {std::pair<std::optional<Vector3>, Vector3>{std::nullopt, {0, 0, 0}},
                                         {Vector3(0, 0, -300), {0, 0, 0}},
                                         {Vector3(kNan, 0, 500), {0, 0, 0}},
                                         {Vector3(0, 0, 500), {0, kNan, 0}},
                                         {Vector3(0, 0, 500), {0, 0, -1e6}}}) {
    EyeVergence controller = eyes(0.009);
    EyeAngles angles;
    turn(angles, controller.step(Vector3(100, 0, 500), Vector3::Zero(), angles), kPeriod_s);
    EyeCommand command;
    for (int frame = 0; frame < 10; ++frame) {
      command = controller.step(target, velocity, angles);
      EXPECT_TRUE(command.holds);
      turn(angles, command, kPeriod_s);
    }
    for (const double rate : command.rate_rad_per_s) EXPECT_EQ(rate, 0);
    EXPECT_TRUE(std::isfinite(angles.tilt_rad));
  }
}

TEST(EyeVergence, RefusesWhatIsNoSetting) {
  EyeVergence controller;
  EyeControl control;
  control.steps_per_rad.fill(kStepsPerRad);
  EXPECT_EQ(controller.configure({}, control, motor_limits(), kPeriod_s), Status::kOk);
  EXPECT_EQ(controller.configure({0, 0, 0}, control, motor_limits(), kPeriod_s), Status::kBadLimits);
  EXPECT_EQ(controller.configure({}, control, motor_limits(), 0), Status::kBadLimits);
  control.gain_per_period = 1.5;
  EXPECT_EQ(controller.configure({}, control, motor_limits(), kPeriod_s), Status::kBadLimits);
  control = {};
  EXPECT_EQ(controller.configure({}, control, motor_limits(), kPeriod_s), Status::kBadLimits);
}

}  // namespace
}  // namespace vergence
