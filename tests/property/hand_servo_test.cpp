// The twist of the hand: its equations, and the joint velocities for it. Closed loops: hand_servo_loop_test.
#include "algo/hand_servo.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "algo/pa10.hpp"
#include "algo/rotation_vector.hpp"
#include "tests/support/bit_hash.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::RandomArm;

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Twist any_twist(RandomArm& random) {
  const Vector3 v = random.vector(200);
  return {v, random.vector(1)};
}

// A frame that moves: origin and rotation at time t from those at 0, at constant rates. The rates' axes are
// those of the frame it is seen from.
Transform moved(const Transform& T, const Twist& twist, double t_s) {
  return {rotation_from_vector(twist.angular_rad_per_s * t_s) * T.R, T.t_mm + twist.linear_mm_per_s * t_s};
}

struct Scene {
  Transform T_W_E;
  Twist hand;
  TargetState target;
  DesiredRelation relation;

  [[nodiscard]] Scene at(double t_s) const {
    Scene later = *this;
    later.T_W_E = moved(T_W_E, hand, t_s);
    later.target.T_W_M = moved(target.T_W_M, target.velocity, t_s);
    later.relation.T_Ed_M = moved(relation.T_Ed_M, relation.rate, t_s);
    return later;
  }
  [[nodiscard]] Transform T_E_Ed() const {
    return T_W_E.inverse() * target.T_W_M * relation.T_Ed_M.inverse();  // [3.23]
  }
  [[nodiscard]] HandError error() const { return hand_error(T_W_E, hand, target, relation); }
  [[nodiscard]] Twist desired() const { return desired_hand_velocity(T_W_E, target, relation); }
};

Scene any_scene(RandomArm& random) {
  Scene scene;
  scene.T_W_E = random.transform(600);
  scene.hand = any_twist(random);
  scene.target.T_W_M = random.transform(600);
  scene.target.velocity = any_twist(random);
  scene.relation.T_Ed_M = random.transform(600);
  scene.relation.rate = any_twist(random);
  return scene;
}

TEST(HandServo, RatesAreTheDerivativesOfTheError) {
  ASSERT_TRUE(rc::check([] {
    RandomArm random(*rc::gen::arbitrary<std::uint64_t>());
    Scene scene = any_scene(random);
    scene.relation.position_only = random.between(0, 1) < 0.3;
    if (scene.relation.position_only) scene.hand.angular_rad_per_s.setZero();
    const double h_s = 1e-5;
    const HandError error = scene.error();
    const HandError after = scene.at(h_s).error();
    const HandError before = scene.at(-h_s).error();
    const Vector3 rate = (after.position_mm - before.position_mm) / (2 * h_s);
    RC_ASSERT((rate - error.rate.linear_mm_per_s).norm() < 1e-4);
    RC_ASSERT(error.R_W_E == scene.T_W_E.R);
    const Twist of_Ed = scene.desired();
    RC_ASSERT((of_Ed.linear_mm_per_s - scene.hand.linear_mm_per_s - error.rate.linear_mm_per_s).norm() <
              1e-9);
    if (scene.relation.position_only) {
      RC_ASSERT(error.e == Vector3(0, 0, 0));
      RC_ASSERT(error.rate.angular_rad_per_s == Vector3(0, 0, 0));
      RC_ASSERT(of_Ed.angular_rad_per_s == Vector3(0, 0, 0));
      // The target is where it is wanted in the hand once the hand has gone there.
      const Transform there{scene.T_W_E.R, scene.T_W_E.t_mm + error.position_mm};
      RC_ASSERT((there.inverse() * scene.target.T_W_M.t_mm - scene.relation.T_Ed_M.t_mm).norm() < 1e-9);
      return;
    }
    const Transform T_E_Ed = scene.T_E_Ed();
    RC_ASSERT((scene.T_W_E.R * T_E_Ed.t_mm - error.position_mm).norm() < 1e-9);
    RC_ASSERT((quaternion_vector_from_rotation(T_E_Ed.R) - error.e).norm() < 1e-9);
    // S(omega) = E_R'_Ed E_R_Ed^-1 [3.28, 3.29], and what [3.25] says of the translation.
    const Transform next = scene.at(h_s).T_E_Ed();
    const Transform last = scene.at(-h_s).T_E_Ed();
    const Matrix3 S = (next.R - last.R) / (2 * h_s) * T_E_Ed.R.transpose();
    const Vector3 omega = scene.T_W_E.R * Vector3(S(2, 1), S(0, 2), S(1, 0));
    RC_ASSERT((omega - error.rate.angular_rad_per_s).norm() < 1e-6);
    const Vector3 seen = scene.T_W_E.R * (next.t_mm - last.t_mm) / (2 * h_s);
    RC_ASSERT(
        (seen + cross(scene.hand.angular_rad_per_s, error.position_mm) - error.rate.linear_mm_per_s).norm() <
        1e-4);
  }));
}

TEST(HandServo, TurnsWithTheWorld) {
  ASSERT_TRUE(rc::check([] {
    RandomArm random(*rc::gen::arbitrary<std::uint64_t>());
    Scene scene = any_scene(random);
    scene.relation.position_only = random.between(0, 1) < 0.3;
    const Transform T_V_W = random.transform(1000);
    Scene turned = scene;
    const auto turn = [&](const Twist& twist) {
      return Twist{T_V_W.R * twist.linear_mm_per_s, T_V_W.R * twist.angular_rad_per_s};
    };
    turned.T_W_E = T_V_W * scene.T_W_E;
    turned.hand = turn(scene.hand);
    turned.target.T_W_M = T_V_W * scene.target.T_W_M;
    turned.target.velocity = turn(scene.target.velocity);
    const HandGains gains{1.3, 0.2, 2.1, 0.3, 0.7};
    const Twist twist = turn(hand_twist(gains, scene.error(), scene.desired()));
    const Twist of_turned = hand_twist(gains, turned.error(), turned.desired());
    RC_ASSERT((twist.linear_mm_per_s - of_turned.linear_mm_per_s).norm() < 1e-8);
    RC_ASSERT((twist.angular_rad_per_s - of_turned.angular_rad_per_s).norm() < 1e-10);
  }));
}

// The law, term by term [3.26, 3.27].
TEST(HandServo, EachGainHasItsTerm) {
  RandomArm random(3);
  const Scene scene = any_scene(random);
  const HandError error = scene.error();
  const Twist v = scene.desired();
  const auto expect = [&](const HandGains& gains, const Vector3& linear, const Vector3& angular) {
    const Twist twist = hand_twist(gains, error, v);
    EXPECT_LT((twist.linear_mm_per_s - linear).norm(), 1e-9);
    EXPECT_LT((twist.angular_rad_per_s - angular).norm(), 1e-12);
  };
  const Vector3 zero = Vector3::Zero();
  expect({2, 0, 0, 0, 0}, 2 * error.position_mm, zero);
  expect({0, 0.5, 0, 0, 0}, 0.5 * error.rate.linear_mm_per_s, zero);
  expect({0, 0, 3, 0, 0}, zero, 3 * (scene.T_W_E.R * error.e));
  expect({0, 0, 0, 0.5, 0}, zero, 0.5 * error.rate.angular_rad_per_s);
  expect({0, 0, 0, 0, 0.5}, 0.5 * v.linear_mm_per_s, 0.5 * v.angular_rad_per_s);
}

TEST(HandServo, WithoutErrorTheFeedForwardIsAllThereIs) {
  // Poses whose products are exact, so that the error is zero to the last bit.
  Scene scene;
  scene.T_W_E.t_mm = Vector3(16, -8, 256);
  scene.relation.T_Ed_M.t_mm = Vector3(0, -128, 512);
  scene.target.T_W_M.t_mm = Vector3(16, -136, 768);
  scene.target.velocity = {{50, -20, 10}, {0.5, 0, -0.25}};
  scene.hand = scene.desired();
  const HandError error = scene.error();
  EXPECT_EQ(error.position_mm, Vector3(0, 0, 0));
  EXPECT_EQ(error.e, Vector3(0, 0, 0));
  for (HandGains gains : {vergence_gains(), thesis_gains()}) {
    const Twist twist = hand_twist(gains, error, scene.desired());
    EXPECT_EQ(twist.linear_mm_per_s, gains.feed_forward * scene.desired().linear_mm_per_s);
    EXPECT_EQ(twist.angular_rad_per_s, gains.feed_forward * scene.desired().angular_rad_per_s);
  }
  // Round the turning target: v_M + w_M x (r_Ed - r_M).
  const Vector3 arm = scene.T_W_E.t_mm - scene.target.T_W_M.t_mm;
  EXPECT_EQ(scene.desired().linear_mm_per_s,
            scene.target.velocity.linear_mm_per_s + cross(scene.target.velocity.angular_rad_per_s, arm));
}

TEST(HandServo, RefusesGainsThatMakeNoSense) {
  EXPECT_EQ(check(thesis_gains()), Status::kOk);
  EXPECT_EQ(check(vergence_gains()), Status::kOk);
  for (double HandGains::*gain :
       {&HandGains::position_per_s, &HandGains::position_rate, &HandGains::orientation_per_s,
        &HandGains::orientation_rate, &HandGains::feed_forward}) {
    for (const double bad : {-0.1, 51.0, std::nan(""), HUGE_VAL}) {
      HandGains gains = thesis_gains();
      gains.*gain = bad;
      EXPECT_EQ(check(gains), Status::kBadGains) << bad;
    }
  }
  HandGains swinging = thesis_gains();
  swinging.orientation_rate = 1;
  EXPECT_EQ(check(swinging), Status::kBadGains);
}

JointVector bent() {
  JointVector q;
  q << 0.02, 0.5, 0.1, 1.6, 0.1, -0.5, 0.2;
  return q;
}

TEST(JointServo, AddsTheWayToTheDesiredAngles) {
  const SerialArm arm = pa10();
  const JointVector q = bent();
  const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
  const Twist twist{{30, -20, 10}, {0.1, 0.2, -0.3}};
  // Where the arm is as it should be, the hand moves as asked.
  const VelocityStep only = joint_velocity(arm, J, twist, q, q);
  ASSERT_EQ(only.status, Status::kOk);
  Vector6 asked;
  asked << twist.linear_mm_per_s, twist.angular_rad_per_s;
  EXPECT_LT((J * only.velocity_rad_per_s - asked).norm(), 1e-9);
  EXPECT_EQ(only.velocity_rad_per_s[0], 0);  // held
  // And K_PQ of the way; the held joint has nothing else.
  JointVector q_desired = q;
  q_desired[0] = 0;
  q_desired[3] += 0.25;
  const VelocityStep both = joint_velocity(arm, J, twist, q_desired, q, {2, {}});
  ASSERT_EQ(both.status, Status::kOk);
  const JointVector added = both.velocity_rad_per_s - only.velocity_rad_per_s;
  EXPECT_LT((added - 2 * (q_desired - q)).norm(), 1e-12);
  EXPECT_EQ(both.velocity_rad_per_s[0], -0.04);
}

TEST(JointServo, WhatIsNoNumberMovesNothing) {
  const SerialArm arm = pa10();
  const JointVector q = bent();
  const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
  const Twist twist{{30, -20, 10}, {0.1, 0.2, -0.3}};
  const auto expect_none = [](const VelocityStep& step) {
    EXPECT_EQ(step.status, Status::kBadNumber);
    EXPECT_EQ(step.velocity_rad_per_s, JointVector::Zero());
  };
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    Twist spoilt = twist;
    spoilt.linear_mm_per_s[1] = bad;
    expect_none(joint_velocity(arm, J, spoilt, q, q));
    spoilt = twist;
    spoilt.angular_rad_per_s[2] = bad;
    expect_none(joint_velocity(arm, J, spoilt, q, q));
    JointVector q_spoilt = q;
    q_spoilt[5] = bad;
    expect_none(joint_velocity(arm, J, twist, q_spoilt, q));
    expect_none(joint_velocity(arm, J, twist, q, q_spoilt));
    ArmJacobian J_spoilt = J;
    J_spoilt(1, 2) = bad;
    expect_none(joint_velocity(arm, J_spoilt, twist, q, q));
    expect_none(joint_velocity(arm, J, twist, q, q, {bad, {}}));
  }
}

// One number proves behaviour unchanged, on x86-64 and arm64.
TEST(HandServo, KeepsItsBits) {
  RandomArm random(42);
  testing::BitHash hash;
  const SerialArm arm = pa10();
  for (int i = 0; i < 1000; ++i) {
    Scene scene = any_scene(random);
    scene.relation.position_only = i % 4 == 0;
    const Twist twist = hand_twist({1.3, 0.2, 2.1, 0.3, 0.7}, scene.error(), scene.desired());
    const JointVector q = random.angles(arm);
    const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
    const VelocityStep step = joint_velocity(arm, J, twist, random.near(arm, q, 0.1), q);
    for (int k = 0; k < 3; ++k) {
      hash.add(twist.linear_mm_per_s[k]);
      hash.add(twist.angular_rad_per_s[k]);
    }
    for (int k = 0; k < kMaxJoints; ++k) hash.add(step.velocity_rad_per_s[k]);
  }
  EXPECT_EQ(hash.value(), 0xA96CD92A72D4C30FULL)
      << "0x" << std::hex << std::uppercase << hash.value() << "ULL";
}

}  // namespace
}  // namespace vergence
