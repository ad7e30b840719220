// Three motors and their switches: what stops, what is home, what is a fault, and what is refused.
#include "hal/gpio_step/motor_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/step_rig.hpp"

namespace vergence::step {
namespace {

// Without lines: every level is there at once.
class Bench {
 public:
  explicit Bench(
      const std::array<MotorConfig, kPanTiltMotors>& config = testing::config_of_step_rig().motors) {
    EXPECT_EQ(set.configure(config, 0).error, TimingError::kNone);
  }
  // Polled each 100 us, like the step task does; until something is wrong.
  void run_for(std::int64_t ns) {
    for (const std::int64_t end_ns = now_ns + ns; now_ns < end_ns && fault.fault == StepFault::kNone;) {
      refused = set.command(now_ns, rates, inputs, fault);
      const std::int64_t poll_ns = now_ns + 100'000;
      for (; set.next_event_ns() < poll_ns; set.written(now_ns)) {
        now_ns = std::max(now_ns, set.next_event_ns());
        outputs = set.advance(now_ns);
      }
      now_ns = poll_ns;
    }
  }
  [[nodiscard]] std::int64_t steps(int motor) const { return set.motor(motor).position_steps(); }

  MotorSet set;
  MotorRates rates{};
  std::uint32_t inputs = 0;
  std::uint32_t outputs = 0;
  MotorFault fault;
  int refused = 0;
  std::int64_t now_ns = 0;
};

std::array<MotorConfig, kPanTiltMotors> with_ends(EndAction low, EndAction high) {
  auto config = testing::config_of_step_rig().motors;
  for (MotorConfig& motor : config) {
    motor.low_end = low;
    motor.high_end = high;
    motor.home_steps = -100;
    motor.home_tolerance_steps = 10;
  }
  return config;
}

TEST(MotorSetTest, MotorsTurnIndependently) {
  Bench bench;
  bench.rates = {5'000'000, -2'000'000, 0};
  bench.run_for(100'000'000);
  EXPECT_NEAR(static_cast<double>(bench.steps(0)), 487, 2);  // 0.1 s less half the ramp of 5 ms
  EXPECT_NEAR(static_cast<double>(bench.steps(1)), -198, 2);
  EXPECT_EQ(bench.steps(2), 0);
  EXPECT_EQ(bench.outputs & ~(step_bit(0) | step_bit(1)), forward_bit(0) | forward_bit(2));
  EXPECT_EQ(bench.set.outputs(), bench.outputs);
}

TEST(MotorSetTest, RefusedRatesAreCountedAndRampToRest) {
  Bench bench;
  bench.rates = {5'000'000, 5'000'000, 5'000'000};
  bench.run_for(20'000'000);
  bench.rates = {10'000'001, -10'000'001, 5'000'000};
  bench.run_for(100'000);
  EXPECT_EQ(bench.refused, 2);
  EXPECT_GT(bench.set.motor(0).rate_millisteps_per_s(), 0);  // not at once
  bench.run_for(20'000'000);
  EXPECT_EQ(bench.refused, 2);
  EXPECT_EQ(bench.set.motor(0).rate_millisteps_per_s(), 0);
  EXPECT_EQ(bench.set.motor(1).rate_millisteps_per_s(), 0);
  EXPECT_EQ(bench.set.motor(2).rate_millisteps_per_s(), 5'000'000);
}

// What is no rate leads nowhere, not even into a switch.
TEST(MotorSetTest, ARefusedRateIsNoMoveTowardsASwitch) {
  Bench bench(with_ends(EndAction::kFault, EndAction::kFault));
  bench.inputs = high_end_bit(0) | low_end_bit(1);
  bench.rates = {kNever_ns, -kNever_ns - 1, 0};
  bench.run_for(1'000'000);
  EXPECT_EQ(bench.refused, 2);
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
}

TEST(MotorSetTest, ALimitSwitchIsAFaultForMotionTowardsItOnly) {
  for (int motor = 0; motor < kPanTiltMotors; ++motor) {
    for (const std::int64_t direction : {-1, 1}) {
      const std::uint32_t bit = direction > 0 ? high_end_bit(motor) : low_end_bit(motor);
      const auto i = static_cast<std::size_t>(motor);
      Bench bench(with_ends(EndAction::kFault, EndAction::kFault));
      bench.inputs = bit;
      bench.rates[i] = -direction * 5'000'000;
      bench.run_for(10'000'000);
      EXPECT_EQ(bench.fault.fault, StepFault::kNone);
      EXPECT_EQ(bench.steps(motor) * -direction > 0, true);

      bench.inputs = 0;
      bench.rates[i] = direction * 5'000'000;
      bench.run_for(30'000'000);
      EXPECT_EQ(bench.fault.fault, StepFault::kNone);
      const std::int64_t before = bench.steps(motor);
      bench.inputs = bit;
      bench.run_for(10'000'000);
      EXPECT_EQ(bench.fault.fault, StepFault::kEndReached);
      EXPECT_EQ(bench.fault.motor, motor);
      EXPECT_EQ(bench.set.motor(motor).rate_millisteps_per_s(), 0);  // at once
      EXPECT_LE(std::abs(bench.steps(motor) - before), 1);
    }
  }
}

// Although the command is the other way by now: it still runs into it.
TEST(MotorSetTest, AMotorThatStillBrakesTowardsALimitSwitchIsAFault) {
  Bench bench(with_ends(EndAction::kNone, EndAction::kFault));
  bench.rates = {10'000'000, 0, 0};
  bench.run_for(20'000'000);
  bench.rates = {-10'000'000, 0, 0};
  bench.run_for(1'000'000);
  ASSERT_GT(bench.set.motor(0).rate_millisteps_per_s(), 0);
  bench.inputs = high_end_bit(0);
  bench.run_for(100'000);
  EXPECT_EQ(bench.fault.fault, StepFault::kEndReached);
}

TEST(MotorSetTest, SwitchesWithoutAnActionAreIgnored) {
  Bench bench;
  bench.inputs = ~0U;
  bench.rates = {5'000'000, -5'000'000, 5'000'000};
  bench.run_for(10'000'000);
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
  EXPECT_GT(bench.steps(0), 20);
  EXPECT_FALSE(bench.set.is_homed(0));
}

TEST(MotorSetTest, AHomeSwitchStopsTheMotorAndSetsItsPosition) {
  Bench bench(with_ends(EndAction::kHome, EndAction::kFault));
  bench.rates = {-1'000'000, -1'000'000, 0};
  bench.run_for(50'000'000);
  bench.inputs = low_end_bit(0);
  bench.run_for(10'000'000);
  EXPECT_TRUE(bench.set.is_homed(0));
  EXPECT_FALSE(bench.set.is_homed(1));
  EXPECT_EQ(bench.steps(0), -100);
  EXPECT_EQ(bench.set.motor(0).rate_millisteps_per_s(), 0);
  EXPECT_EQ(bench.set.motor(1).rate_millisteps_per_s(), -1'000'000);
  EXPECT_EQ(bench.refused, 0);
  bench.rates = {1'000'000, 0, 0};  // away is allowed
  bench.run_for(10'000'000);
  EXPECT_GT(bench.steps(0), -95);
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
}

class HomedTest : public ::testing::Test {
 protected:
  HomedTest() {
    bench.rates = {-1'000'000, 0, 0};
    bench.run_for(10'000'000);
    bench.inputs = low_end_bit(0);
    bench.run_for(1'000'000);
    EXPECT_TRUE(bench.set.is_homed(0));
    bench.rates = {1'000'000, 0, 0};
    bench.run_for(20'000'000);  // inside the switch's travel still
    bench.inputs = 0;
    bench.run_for(80'000'000);
    EXPECT_NEAR(static_cast<double>(bench.steps(0)), 0, 2);
  }
  // Towards the switch, which is pressed once the motor is there.
  void approach(std::int64_t switch_steps) {
    bench.rates = {-1'000'000, 0, 0};
    for (int i = 0; i < 3000 && bench.fault.fault == StepFault::kNone; ++i) {
      if (bench.steps(0) <= switch_steps) bench.inputs = low_end_bit(0);
      bench.run_for(100'000);
    }
  }
  Bench bench{with_ends(EndAction::kHome, EndAction::kNone)};
};

TEST_F(HomedTest, HomeWithinItsToleranceIsNoFaultAndKeepsThePosition) {
  approach(-92);
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
  EXPECT_EQ(bench.steps(0), -92);
  EXPECT_EQ(bench.set.motor(0).rate_millisteps_per_s(), 0);
}

TEST_F(HomedTest, HomeTooEarlyIsAFaultAndMustBeFoundAnew) {
  approach(-80);
  EXPECT_EQ(bench.fault.fault, StepFault::kHomeMoved);
  EXPECT_EQ(bench.fault.motor, 0);
  EXPECT_FALSE(bench.set.is_homed(0));
  EXPECT_EQ(bench.steps(0), -80);
  EXPECT_EQ(bench.set.motor(0).rate_millisteps_per_s(), 0);
  bench.fault = {};
  bench.run_for(1'000'000);  // the switch is pressed still
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
  EXPECT_TRUE(bench.set.is_homed(0));
  EXPECT_EQ(bench.steps(0), -100);
}

TEST_F(HomedTest, RunningPastHomeIsAFault) {
  approach(-1000);
  EXPECT_EQ(bench.fault.fault, StepFault::kHomeMoved);
  EXPECT_EQ(bench.steps(0), -111);
}

// A switch has travel: back and forth inside it is not a home in another place.
TEST_F(HomedTest, MovingInsideThePressedSwitchIsNoFault) {
  approach(-100);
  bench.rates = {1'000'000, 0, 0};
  bench.run_for(40'000'000);
  EXPECT_GT(bench.steps(0), -70);
  bench.rates = {-1'000'000, 0, 0};
  bench.run_for(10'000'000);
  EXPECT_EQ(bench.fault.fault, StepFault::kNone);
  EXPECT_EQ(bench.set.motor(0).rate_millisteps_per_s(), 0);
}

TEST(MotorSetTest, TheFirstOfTwoFaultsIsTold) {
  Bench bench(with_ends(EndAction::kFault, EndAction::kFault));
  bench.rates = {0, 5'000'000, 5'000'000};
  bench.inputs = high_end_bit(1) | high_end_bit(2);
  bench.run_for(1'000'000);
  EXPECT_EQ(bench.fault.motor, 1);
}

TEST(MotorSetTest, RefusesConfigurationsThatCannotBe) {
  const auto error_of = [](auto change) {
    auto config = testing::config_of_step_rig().motors;
    change(config[2]);
    MotorSet set;
    return set.configure(config, 0);
  };
  EXPECT_EQ(error_of([](MotorConfig&) {}).error, TimingError::kNone);
  const MotorError two_homes =
      error_of([](MotorConfig& motor) { motor.low_end = motor.high_end = EndAction::kHome; });
  EXPECT_EQ(two_homes.error, TimingError::kBadHome);
  EXPECT_EQ(two_homes.motor, 2);
  EXPECT_EQ(error_of([](MotorConfig& motor) { motor.home_tolerance_steps = -1; }).error,
            TimingError::kBadHome);
  const MotorError timing = error_of([](MotorConfig& motor) { motor.timing.steplen_ns = 1; });
  EXPECT_EQ(timing.error, TimingError::kBadPulse);
  EXPECT_EQ(timing.motor, 2);
}

TEST(MotorSetTest, EveryFaultAndErrorHasWordsOfItsOwn) {
  std::vector<std::string> words;
  for (int i = 0; i <= static_cast<int>(StepFault::kEnableFailed); ++i) {
    words.emplace_back(describe(static_cast<StepFault>(i)));
  }
  for (int i = 1; i <= static_cast<int>(TimingError::kBadHome); ++i) {
    words.emplace_back(describe(static_cast<TimingError>(i)));
  }
  std::sort(words.begin(), words.end());
  EXPECT_EQ(std::unique(words.begin(), words.end()), words.end());
  for (const std::string& text : words) EXPECT_EQ(text.find("unknown"), std::string::npos);
}

}  // namespace
}  // namespace vergence::step
