// Whatever is commanded, drives and motors of the simulated world keep what they promise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.hpp"
#include "tools/plant/arm_servo.hpp"
#include "tools/plant/stepper.hpp"

namespace vergence::plant {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(PlantArmServoProperty, KeepsItsLimitsWhateverIsCommanded) {
  testing::Random random(1);
  int at_velocity_limit = 0;
  int at_acceleration_limit = 0;
  int at_end = 0;
  double worst_count = 0;
  for (int arm = 0; arm < 40; ++arm) {
    ArmServoOptions options;
    options.enable_delay_ns = 0;
    for (JointDrive& drive : options.drive) {
      drive.min_rad = random.between(-2, -0.05);
      drive.max_rad = random.between(0.05, 2);
      drive.velocity_rad_per_s = random.between(0.1, 4);
      drive.acceleration_rad_per_s2 = random.about(10, 3);
      drive.quick_stop_rad_per_s2 = drive.acceleration_rad_per_s2 / 2;
      drive.time_constant_s = random.about(0.02, 2);
      drive.counts_per_rad = random.about(10'000, 3);
    }
    ArmServo servo(options);
    for (int step = 0; step < 1500; ++step) {
      if (random.below(40) == 0) {
        servo.request(random.below(6) == 0 ? ArmRequest::kQuickStop : ArmRequest::kEnable);
      }
      JointArray command{};
      for (double& joint : command) joint = random.between(-6, 6);
      if (random.below(20) == 0) servo.command(command);
      const JointArray before = servo.true_velocity_rad_per_s();
      const unsigned ends_before = servo.ends_hit();
      servo.advance(kMs);
      const ArmFeedback feedback = servo.feedback(0);
      for (std::size_t i = 0; i < kMaxJoints; ++i) {
        const JointDrive& drive = options.drive[i];
        const double v = servo.true_velocity_rad_per_s()[i];
        const double q = servo.true_position_rad()[i];
        ASSERT_LE(std::abs(v), drive.velocity_rad_per_s * (1 + 1e-12));
        ASSERT_GE(q, drive.min_rad);
        ASSERT_LE(q, drive.max_rad);
        const bool is_at_end = q == drive.min_rad || q == drive.max_rad;
        ASSERT_TRUE(!is_at_end || (servo.ends_hit() >> i & 1U) != 0);
        // A hard stop takes any speed at once; nothing else does.
        const double change = std::abs(v - before[i]);
        ASSERT_TRUE(is_at_end || change <= drive.acceleration_rad_per_s2 * 1e-3 * (1 + 1e-9));
        at_acceleration_limit += change > 0.99e-3 * drive.acceleration_rad_per_s2 ? 1 : 0;
        at_velocity_limit += std::abs(v) > 0.99 * drive.velocity_rad_per_s ? 1 : 0;
        at_end += servo.ends_hit() != ends_before ? 1 : 0;
        worst_count = std::max(worst_count, std::abs(feedback.position_rad[i] - q) * drive.counts_per_rad);
      }
    }
  }
  EXPECT_LE(worst_count, 0.5 + 1e-6);
  EXPECT_GT(worst_count, 0.49);
  EXPECT_GT(at_velocity_limit, 100);
  EXPECT_GT(at_acceleration_limit, 100);
  EXPECT_GT(at_end, 10);
}

TEST(PlantStepperProperty, IssuesTheIntegralOfItsRate) {
  testing::Random random(2);
  for (int run = 0; run < 50; ++run) {
    Stepper motor(StepperOptions{});
    double integral = 0;
    for (int step = 0; step < 2000; ++step) {
      const double rate = random.below(4) == 0 ? 0 : random.between(-50e3, 50e3);
      const double dt_s = random.between(0, 2e-3);
      motor.advance(rate, dt_s);
      integral += rate * dt_s;
      ASSERT_LE(std::abs(static_cast<double>(motor.issued_steps()) - integral), 0.5 + 1e-6);
    }
  }
}

// Accelerations to four fifths of the least of the curve, rates up to pull-out.
TEST(PlantStepperProperty, RotorKeepsUpWithAnyMotionUnderTheCurve) {
  testing::Random random(3);
  const StepperOptions options;
  double top_rate = 0;
  for (int run = 0; run < 20; ++run) {
    Stepper motor(options);
    double rate = 0;
    double change = 0;
    for (int step = 0; step < 3000; ++step) {
      if (random.below(300) == 0) change = random.between(-40, 40);
      rate = std::clamp(rate + change, -30e3, 30e3);
      top_rate = std::max(top_rate, std::abs(rate));
      motor.advance(rate, 1e-3);
      // It lags a little while it changes speed.
      ASSERT_NEAR(motor.true_rad() * options.steps_per_rad, static_cast<double>(motor.issued_steps()), 1);
    }
    EXPECT_EQ(motor.lost_steps(), 0);
  }
  EXPECT_EQ(top_rate, 30e3);
}

}  // namespace
}  // namespace vergence::plant
