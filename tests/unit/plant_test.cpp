// The parts of the simulated world against what can be worked out on paper: a lag's response, the count of
// pulses, when pictures come.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "algo/pa10.hpp"
#include "tools/plant/arm_servo.hpp"
#include "tools/plant/camera_timing.hpp"
#include "tools/plant/decay.hpp"
#include "tools/plant/state_history.hpp"
#include "tools/plant/stepper.hpp"

namespace vergence::plant {
namespace {

constexpr std::int64_t kMs = 1'000'000;

// Enabled at once, free of a watchdog, strong enough that no limit binds.
ArmServoOptions strong() {
  ArmServoOptions options;
  options.enable_delay_ns = 0;
  options.watchdog_periods = 0;
  for (JointDrive& drive : options.drive) drive.acceleration_rad_per_s2 = 1e4;
  return options;
}

ArmServo enabled(const ArmServoOptions& options) {
  ArmServo servo(options);
  servo.request(ArmRequest::kEnable);
  return servo;
}

JointArray all(double value) {
  JointArray joints{};
  joints.fill(value);
  return joints;
}

TEST(PlantDecay, IsTheExponential) {
  EXPECT_EQ(decay(0), 1);
  for (const double x : {1e-9, 0.01, 0.2, 0.25, 0.26, 1.0, 3.7, 20.0, 100.0, 600.0}) {
    EXPECT_NEAR(decay(x) / std::exp(-x), 1, 1e-12) << x;
  }
  EXPECT_EQ(decay(1e300), 0);
}

TEST(PlantArmServo, AnswersAStepAsAFirstOrderLag) {
  ArmServo servo = enabled(strong());
  servo.command(all(0.8));
  const double tau = 0.020;
  for (int ms = 1; ms <= 100; ++ms) {
    servo.advance(kMs);
    const double t = ms * 1e-3;
    EXPECT_NEAR(servo.true_velocity_rad_per_s()[3], 0.8 * (1 - std::exp(-t / tau)), 1e-12);
    EXPECT_NEAR(servo.true_position_rad()[3], 0.8 * (t - tau * (1 - std::exp(-t / tau))), 1e-12);
  }
}

TEST(PlantArmServo, AnswersABigStepByItsAccelerationFirst) {
  ArmServoOptions options = strong();
  options.drive[0].acceleration_rad_per_s2 = 10;
  ArmServo servo = enabled(options);
  servo.command(all(1));
  // The loop asks for less than 10 rad/s2 from 0.8 rad/s on.
  servo.advance(50 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[0], 0.5, 1e-12);
  servo.advance(30 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[0], 0.8, 1e-12);
  servo.advance(20 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[0], 1 - 0.2 * std::exp(-1.0), 1e-12);
}

TEST(PlantArmServo, DoesNotDependOnTheStep) {
  for (const double acceleration : {1e4, 10.0}) {
    ArmServoOptions options = strong();
    options.enable_delay_ns = 3 * kMs + 700;
    options.watchdog_periods = 30;  // bites within the run, and between steps
    options.command_period_ns = 2 * kMs + 3;
    for (JointDrive& drive : options.drive) drive.acceleration_rad_per_s2 = acceleration;
    ArmServo coarse = enabled(options);
    ArmServo fine = enabled(options);
    const auto both = [&](std::int64_t ms) {
      coarse.advance(ms * kMs);
      for (std::int64_t i = 0; i < ms * 10; ++i) fine.advance(kMs / 10);
    };
    both(7);
    for (const double velocity : {1.5, -0.7, 0.3}) {
      coarse.command(all(velocity));
      fine.command(all(velocity));
      both(40);
    }
    coarse.shove(all(0.9));
    fine.shove(all(0.9));
    coarse.set_load(all(3));
    fine.set_load(all(3));
    both(10);
    EXPECT_NE(coarse.true_velocity_rad_per_s()[2], 0);
    EXPECT_NEAR(coarse.true_velocity_rad_per_s()[2], fine.true_velocity_rad_per_s()[2], 1e-11);
    both(90);
    EXPECT_EQ(coarse.feedback(0).state, ArmState::kQuickStop);
    EXPECT_EQ(fine.feedback(0).state, ArmState::kQuickStop);
    EXPECT_NEAR(coarse.true_position_rad()[2], fine.true_position_rad()[2], 1e-11);
  }
}

TEST(PlantArmServo, StopsAtTheHardStopAndSaysSo) {
  ArmServoOptions options = strong();
  options.drive[1].max_rad = 0.1;
  ArmServo servo = enabled(options);
  servo.command({0.5, 0.5, 0, 0, 0, 0, 0});
  servo.advance(150 * kMs);
  EXPECT_EQ(servo.ends_hit(), 0U);
  servo.advance(250 * kMs);
  EXPECT_EQ(servo.true_position_rad()[1], 0.1);
  EXPECT_EQ(servo.true_velocity_rad_per_s()[1], 0);
  EXPECT_EQ(servo.ends_hit(), 2U);
  EXPECT_GT(servo.true_position_rad()[0], 0.15);
  servo.command({0, -0.5, 0, 0, 0, 0, 0});
  servo.advance(100 * kMs);
  EXPECT_LT(servo.true_position_rad()[1], 0.07);
}

TEST(PlantArmServo, EnablesAfterItsDelayAndHolds) {
  ArmServoOptions options = strong();
  options.enable_delay_ns = 5 * kMs;
  ArmServo servo(options);
  servo.command(all(1));
  servo.advance(kMs);
  EXPECT_EQ(servo.feedback(0).state, ArmState::kDisabled);
  servo.request(ArmRequest::kEnable);
  servo.command(all(1));
  servo.advance(4 * kMs);
  EXPECT_EQ(servo.feedback(0).state, ArmState::kEnabling);
  servo.advance(kMs);
  EXPECT_EQ(servo.feedback(0).state, ArmState::kEnabled);
  servo.advance(50 * kMs);
  EXPECT_EQ(servo.true_position_rad(), JointArray{});  // commands before it was enabled do not count
}

TEST(PlantArmServo, BrakesAtItsQuickStopDeceleration) {
  ArmServoOptions options = strong();
  for (JointDrive& drive : options.drive) drive.quick_stop_rad_per_s2 = 8;
  ArmServo servo = enabled(options);
  servo.command(all(1));
  servo.advance(800 * kMs);
  const double v = servo.true_velocity_rad_per_s()[0];
  const double q = servo.true_position_rad()[0];
  servo.request(ArmRequest::kQuickStop);
  servo.command(all(1));  // no longer heard
  servo.advance(100 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[0], v - 0.8, 1e-12);
  servo.advance(100 * kMs);
  EXPECT_EQ(servo.true_velocity_rad_per_s()[0], 0);
  EXPECT_NEAR(servo.true_position_rad()[0] - q, v * v / 16, 1e-12);
  servo.request(ArmRequest::kEnable);
  EXPECT_EQ(servo.feedback(0).state, ArmState::kEnabled);
  servo.advance(100 * kMs);
  EXPECT_EQ(servo.true_velocity_rad_per_s()[0], 0);  // what was commanded before is forgotten
}

TEST(PlantArmServo, WatchdogStopsAnArmThatHearsNothing) {
  ArmServoOptions options = strong();
  options.watchdog_periods = 10;
  ArmServo servo = enabled(options);
  for (int period = 0; period < 40; ++period) {
    servo.command(all(1));
    servo.advance(2 * kMs);
  }
  servo.advance(18 * kMs - 1);  // the last command was 2 ms ago
  EXPECT_EQ(servo.feedback(0).state, ArmState::kEnabled);
  servo.advance(1);
  EXPECT_EQ(servo.feedback(0).state, ArmState::kQuickStop);
  servo.advance(100 * kMs);
  EXPECT_EQ(servo.true_velocity_rad_per_s()[0], 0);
}

TEST(PlantArmServo, LoopTakesAShoveBack) {
  ArmServo servo = enabled(strong());
  servo.command(all(0.2));
  servo.advance(500 * kMs);
  servo.shove(all(0.5));
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[4], 0.7, 1e-9);
  servo.advance(20 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[4], 0.2 + 0.5 * std::exp(-1.0), 1e-9);
  servo.set_load(all(5));
  servo.advance(500 * kMs);
  EXPECT_NEAR(servo.true_velocity_rad_per_s()[4], 0.2 + 5 * 0.020, 1e-9);
}

TEST(PlantArmServo, ReportsAFaultUntilItIsReset) {
  ArmServo servo = enabled(strong());
  servo.command(all(1));
  servo.advance(50 * kMs);
  servo.inject_fault(0x2310);
  servo.request(ArmRequest::kEnable);
  servo.request(ArmRequest::kDisable);
  servo.advance(200 * kMs);
  EXPECT_EQ(servo.feedback(7).state, ArmState::kFault);
  EXPECT_EQ(servo.feedback(7).fault, 0x2310U);
  EXPECT_EQ(servo.feedback(7).stamp_ns, 7);
  EXPECT_EQ(servo.true_velocity_rad_per_s()[0], 0);
  servo.request(ArmRequest::kResetFault);
  EXPECT_EQ(servo.feedback(7).state, ArmState::kDisabled);
  EXPECT_EQ(servo.feedback(7).fault, 0U);
}

TEST(PlantArmServo, DrivesOfAnArmOutdoItsLimits) {
  const SerialArm arm = pa10();
  const ArmServoOptions options = servo_of(arm);
  EXPECT_EQ(options.joints, arm.joints);
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    EXPECT_LT(options.drive[i].min_rad, arm.limits[i].min_rad);
    EXPECT_GT(options.drive[i].max_rad, arm.limits[i].max_rad);
    EXPECT_GT(options.drive[i].velocity_rad_per_s, arm.limits[i].velocity_rad_per_s);
    EXPECT_GT(options.drive[i].acceleration_rad_per_s2, arm.limits[i].acceleration_rad_per_s2);
  }
}

TEST(PlantArmServo, RefusesOptionsThatMakeNoSense) {
  ArmServoOptions options;
  options.drive[2].time_constant_s = 0;
  EXPECT_THROW(ArmServo{options}, std::invalid_argument);
  options = {};
  options.start_rad[6] = 4;
  EXPECT_THROW(ArmServo{options}, std::invalid_argument);
  options = {};
  options.joints = kMaxJoints + 1;
  EXPECT_THROW(ArmServo{options}, std::invalid_argument);
}

// Ramps up to a rate and down again; answers the most steps that were lost on the way.
double lost_by_ramp(double top_steps_per_s, double acceleration_steps_per_s2) {
  const StepperOptions options;
  Stepper motor(options);
  double most = 0;
  const auto run = [&](double rate) {
    motor.advance(rate, 1e-3);
    most = std::max(most, std::abs(motor.lost_steps()));
  };
  const double change = acceleration_steps_per_s2 * 1e-3;
  double rate = 0;
  while (rate < top_steps_per_s) run(rate = std::min(top_steps_per_s, rate + change));
  for (int ms = 0; ms < 300; ++ms) run(rate);
  while (rate > 0) run(rate = std::max(0.0, rate - change));
  for (int ms = 0; ms < 300; ++ms) run(0);
  const double off = static_cast<double>(motor.issued_steps()) - motor.true_rad() * options.steps_per_rad;
  EXPECT_NEAR(off, motor.lost_steps(), 1e-6);
  EXPECT_EQ(std::remainder(motor.lost_steps(), options.steps_per_cycle), 0);
  return most;
}

TEST(PlantStepper, LosesNothingUnderItsTorqueCurve) {
  EXPECT_EQ(lost_by_ramp(3000, 240e3), 0);
  EXPECT_EQ(lost_by_ramp(15e3, 140e3), 0);
  EXPECT_EQ(lost_by_ramp(29e3, 48e3), 0);
  // At once, from standstill: it lags by v^2 / 2a, which is less than half a cycle at 3600 steps/s.
  EXPECT_EQ(lost_by_ramp(3600, 1e9), 0);
}

TEST(PlantStepper, LosesWholeCyclesAboveIt) {
  EXPECT_GE(lost_by_ramp(29e3, 300e3), 64);
  EXPECT_GE(lost_by_ramp(29e3, 1e9), 64);
  EXPECT_GE(lost_by_ramp(4200, 1e9), 64);
  EXPECT_GE(lost_by_ramp(31e3, 40e3), 64);  // beyond pull-out
}

TEST(PlantStepper, StallsAboveThePullOutRate) {
  const StepperOptions options;
  Stepper motor(options);
  for (int ms = 0; ms < 500; ++ms) motor.advance(40e3, 1e-3);
  EXPECT_EQ(motor.issued_steps(), 20'000);
  EXPECT_NEAR(motor.true_rad() * options.steps_per_rad, 0, 1.0);
}

TEST(PlantStepper, ShortOverloadIsCaughtUp) {
  const StepperOptions options;
  Stepper motor(options);
  motor.advance(3000, 1e-3);
  EXPECT_GT(static_cast<double>(motor.issued_steps()) / options.steps_per_rad, motor.true_rad());
  for (int ms = 0; ms < 200; ++ms) motor.advance(0, 1e-3);
  EXPECT_EQ(motor.issued_steps(), 3);
  EXPECT_EQ(motor.true_rad(), 3 / options.steps_per_rad);
}

TEST(PlantPanTilt, TurnsTheEyesByWhatIsIssued) {
  PanTiltOptions options;
  options.motor[1].steps_per_rad = -2000;
  options.start = {0.1, 0.2, -0.3};
  PanTiltPlant eyes(options);
  EXPECT_EQ(eyes.feedback(5).stamp_ns, 5);
  EXPECT_EQ(eyes.feedback(5).steps[1], -400);
  eyes.command({1000, 1000, 1000});
  eyes.advance(kMs);
  EXPECT_EQ(eyes.feedback(0).steps[1], -400);  // not enabled
  eyes.enable(true);
  eyes.command({1000, -1000, std::numeric_limits<double>::quiet_NaN()});
  for (int ms = 0; ms < 500; ++ms) eyes.advance(kMs);
  eyes.command({0, 0, 0});
  for (int ms = 0; ms < 200; ++ms) eyes.advance(kMs);
  EXPECT_EQ(eyes.feedback(0).steps[1], -900);
  EXPECT_NEAR(eyes.true_angles().pan_right_rad, 0.45, 1e-12);
  EXPECT_NEAR(eyes.true_angles().tilt_rad, 0.1 + 500 * 2 * std::numbers::pi / 16000, 2e-4);
  EXPECT_NEAR(eyes.true_angles().pan_left_rad, -0.3, 2e-4);
  eyes.inject_fault();
  eyes.enable(true);
  EXPECT_EQ(eyes.feedback(0).state, PanTiltState::kFault);
  eyes.enable(false);
  eyes.enable(true);
  EXPECT_EQ(eyes.feedback(0).state, PanTiltState::kEnabled);
}

TEST(PlantCameraTiming, StampsAndDeliveriesAreExact) {
  CameraTimingOptions options;
  options.exposure_ns = 5 * kMs + 1;
  options.first_stamp_ns = 3 * kMs;
  const CameraTiming timing(options);
  const PairTiming first = timing.pair(0);
  EXPECT_EQ(first.stamp_ns, 3'000'000);
  EXPECT_EQ(first.exposure_begin_ns, 500'000);
  EXPECT_EQ(first.exposure_end_ns, 5'500'001);
  EXPECT_EQ(first.delivery_ns, 12'000'000);
  EXPECT_EQ(timing.pair(1).stamp_ns, 36'333'333);
  EXPECT_EQ(timing.pair(2).stamp_ns, 69'666'667);
  // No drift: an hour later it is still the thirtieth part of a second.
  EXPECT_EQ(timing.pair(108'000).stamp_ns, 3'600'003'000'000);
  EXPECT_EQ(timing.pair(108'000).delivery_ns, 3'600'012'000'000);
}

TEST(PlantCameraTiming, LosesPairsButNotTheirNumbers) {
  CameraTimingOptions options;
  options.fps = 100;
  options.lost_spans_ns = {{100 * kMs, 130 * kMs}};
  const CameraTiming spans(options);
  for (std::uint64_t i = 0; i < 30; ++i) {
    EXPECT_EQ(spans.pair(i).sequence, i);
    EXPECT_EQ(spans.pair(i).is_lost, i >= 10 && i < 13) << i;
  }
  options.lost_spans_ns.clear();
  options.lost_share = 0.2;
  const CameraTiming random(options);
  options.seed = 2;
  const CameraTiming other(options);
  int lost = 0;
  int differ = 0;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    lost += random.pair(i).is_lost ? 1 : 0;
    differ += random.pair(i).is_lost != other.pair(i).is_lost ? 1 : 0;
  }
  EXPECT_NEAR(lost, 2000, 160);  // four standard deviations
  EXPECT_GT(differ, 2000);
}

TEST(PlantCameraTiming, RefusesPicturesBeforeTheirExposureEnds) {
  CameraTimingOptions options;
  options.exposure_ns = 20 * kMs;
  EXPECT_THROW(CameraTiming{options}, std::invalid_argument);
}

TEST(PlantStateHistory, IsExactAtSamplesAndStraightBetween) {
  StateHistory history(kMs, 4);
  const auto state = [](double t_ms) {
    const double half = 0.01 * t_ms;
    return HeadState{{rotation_from_quaternion_vector({0, std::sin(half), 0}), {10 * t_ms, 0, -t_ms}},
                     {0.1 * t_ms, 0, 1}};
  };
  for (int i = 0; i < 6; ++i) history.push(state(i));
  EXPECT_EQ(history.at(3 * kMs).T_W_H.t_mm, state(3).T_W_H.t_mm);
  EXPECT_EQ(history.at(3 * kMs).T_W_H.R, state(3).T_W_H.R);
  const HeadState between = history.at(4 * kMs + kMs / 4);
  EXPECT_NEAR((between.T_W_H.t_mm - state(4.25).T_W_H.t_mm).norm(), 0, 1e-12);
  EXPECT_NEAR((between.T_W_H.R - state(4.25).T_W_H.R).norm(), 0, 1e-6);
  EXPECT_NEAR(between.eyes.tilt_rad, 0.425, 1e-12);
  EXPECT_THROW((void)history.at(2 * kMs - 1), std::out_of_range);
  EXPECT_NO_THROW((void)history.at(2 * kMs));
  EXPECT_NO_THROW((void)history.at(5 * kMs));
  EXPECT_THROW((void)history.at(5 * kMs + 1), std::out_of_range);
}

}  // namespace
}  // namespace vergence::plant
