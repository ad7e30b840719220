// The eyes' motors as their task sees them: enabling, settling, faults, and who drops the enable line when.
#include "hal/gpio_step/step_motors.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>

#include "tests/support/step_rig.hpp"

namespace vergence::step {
namespace {

using testing::config_of_step_rig;
using testing::StepRig;

template <StepLines Lines = MemoryLines>
std::unique_ptr<StepRig<Lines>> make_rig(const StepMotorsConfig& config = config_of_step_rig()) {
  auto rig = std::make_unique<StepRig<Lines>>();
  EXPECT_EQ(rig->configure(config).error, TimingError::kNone);
  EXPECT_TRUE(rig->lines_work);
  rig->lines.forget_edges();
  return rig;
}

StepMotorsConfig config_with_switches() {
  StepMotorsConfig config = config_of_step_rig();
  for (MotorConfig& motor : config.motors) {
    motor.low_end = EndAction::kHome;
    motor.high_end = EndAction::kFault;
  }
  return config;
}

TEST(StepMotorsTest, BeginsDisabledWithLinesAtRest) {
  const auto rig = make_rig();
  EXPECT_FALSE(rig->feedback.stamp_ns > 0);
  rig->command(1000);
  rig->run_for(10'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  EXPECT_FALSE(rig->lines.is_enabled());
  EXPECT_EQ(rig->lines.outputs(), forward_bit(0) | forward_bit(1) | forward_bit(2));
  EXPECT_EQ(rig->pulses(), 0);
}

TEST(StepMotorsTest, TurnsAtTheCommandedRates) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  EXPECT_TRUE(rig->lines.is_enabled());
  rig->command(4000, -2000, 0.5);
  rig->run_for(1'000'000'000);
  EXPECT_NEAR(static_cast<double>(rig->steps(0)), 4000, 20);
  EXPECT_NEAR(static_cast<double>(rig->steps(1)), -2000, 10);
  EXPECT_EQ(rig->steps(2), 0);
  rig->command(0, 0, 0.5);
  rig->run_for(2'000'000'000);
  EXPECT_EQ(rig->steps(2), 1);
  EXPECT_EQ(rig->pulses(0), rig->steps(0));
  EXPECT_EQ(rig->pulses(1), -rig->steps(1));
  EXPECT_EQ(rig->lines.lost_edges(), 0U);
  EXPECT_EQ(rig->report().late_events, 0U);
  EXPECT_EQ(rig->report().line_failures, 0U);
}

TEST(StepMotorsTest, FeedsBackAtLeastOnceAPoll) {
  const auto rig = make_rig();
  std::int64_t stamp_ns = -1;
  for (int i = 0; i < 50; ++i) {
    rig->run_for(1'000'000);
    EXPECT_GT(rig->feedback.stamp_ns, stamp_ns);
    EXPECT_GE(rig->feedback.stamp_ns, rig->clock.now_ns() - 1'000'000);
    stamp_ns = rig->feedback.stamp_ns;
  }
}

TEST(StepMotorsTest, WaitsForTheDrivesToSettle) {
  StepMotorsConfig config = config_of_step_rig();
  config.settle_ns = 30'000'000;
  const auto rig = make_rig(config);
  rig->run_for(3'000'000);
  rig->motors.enable(true);
  rig->command(5000, -5000, 5000);
  rig->run_for(60'000'000);
  const auto edges = rig->lines.edges();
  ASSERT_GT(edges.size(), 10U);
  ASSERT_EQ(edges[0].line, kEnableLine);
  EXPECT_TRUE(edges[0].level);
  EXPECT_GE(edges[1].t_ns, edges[0].t_ns + config.settle_ns);
  EXPECT_LE(edges[1].t_ns, edges[0].t_ns + config.settle_ns + 2'000'000);
}

TEST(StepMotorsTest, DisablingDropsTheEnableLineBeforeItReturnsAndLetsThePulseEnd) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  while ((rig->lines.outputs() & step_bit(0)) == 0) {
    rig->clock.set_now_ns(rig->motors.next_deadline_ns());
    rig->run_once();
  }
  const std::int64_t pulses = rig->pulses();
  rig->motors.enable(false);
  EXPECT_FALSE(rig->lines.is_enabled());  // although the step task has not run
  rig->command(5000);
  rig->run_for(50'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  EXPECT_EQ(rig->pulses(), pulses);
  EXPECT_EQ(rig->steps(), pulses);
  const auto edges = rig->lines.edges();
  ASSERT_GE(edges.size(), 3U);
  const LineEdge rise = edges[edges.size() - 3];
  const LineEdge fall = edges[edges.size() - 1];
  EXPECT_EQ(edges[edges.size() - 2].line, kEnableLine);
  EXPECT_EQ(fall, (LineEdge{rise.t_ns + 5'000, 0, false}));
}

TEST(StepMotorsTest, OffAndOnBetweenTwoRunsIsSeenAsADrop) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  rig->lines.forget_edges();
  rig->motors.enable(false);
  rig->motors.enable(true);
  EXPECT_FALSE(rig->lines.is_enabled());
  const std::int64_t steps = rig->steps();
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);
  EXPECT_TRUE(rig->lines.is_enabled());
  // Rates from before the drop are over.
  EXPECT_LE(rig->steps() - steps, 6);
  rig->lines.forget_edges();
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->lines.edges().size(), 0U);
  rig->command(5000);
  rig->run_for(20'000'000);
  EXPECT_GT(rig->pulses(), 50);
}

// Given between two runs of the step task together with enable(): it must not get lost.
TEST(StepMotorsTest, ACommandRightAfterEnablingHolds) {
  const auto rig = make_rig();
  rig->run_for(5'000'000);
  rig->motors.enable(true);
  rig->command(5000);
  rig->run_for(50'000'000);
  EXPECT_GT(rig->steps(), 100);
}

TEST(StepMotorsTest, ACommandFromBeforeEnablingDoesNotCount) {
  const auto rig = make_rig();
  rig->command(5000);
  rig->motors.enable(true);
  rig->run_for(50'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);
  EXPECT_EQ(rig->steps(), 0);
}

// Lines that call back, so that the eyes' task comes in between whatever the step task does.
class InterruptedLines : public MemoryLines {
 public:
  using MemoryLines::MemoryLines;
  [[nodiscard]] bool set_enable(bool on) {
    if (before_enable) before_enable(on);
    const bool set = MemoryLines::set_enable(on);
    if (after_enable) after_enable(on);
    return set;
  }
  [[nodiscard]] bool read_inputs(std::uint32_t& levels) {
    if (on_read) on_read();
    return MemoryLines::read_inputs(levels);
  }
  std::function<void(bool)> before_enable;
  std::function<void(bool)> after_enable;
  std::function<void()> on_read;
};

// The step task is about to raise the line, or has just done so, when the eyes' task drops it.
TEST(StepMotorsTest, ADropIsNeverUndone) {
  for (const bool before : {true, false}) {
    const auto rig = make_rig<InterruptedLines>();
    int raised = 0;
    const auto drop = [&](bool on) {
      if (!on) return;
      ++raised;
      rig->motors.enable(false);
    };
    (before ? rig->lines.before_enable : rig->lines.after_enable) = drop;
    rig->motors.enable(true);
    rig->run_once();
    EXPECT_EQ(raised, 1);
    EXPECT_FALSE(rig->lines.is_enabled());
    rig->run_for(10'000'000);
    EXPECT_EQ(raised, 1);
    EXPECT_FALSE(rig->lines.is_enabled());
    EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  }
}

// A command under a wish that the step task has not seen yet, taken in the same run.
TEST(StepMotorsTest, ACommandThatComesWhileTheStepTaskRunsIsNotLost) {
  const auto rig = make_rig<InterruptedLines>();
  rig->run_for(5'000'000);
  rig->lines.on_read = [&] {
    rig->motors.enable(true);
    rig->command(5000);
    rig->lines.on_read = nullptr;
  };
  rig->run_for(50'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);
  EXPECT_GT(rig->steps(), 100);
}

TEST(StepMotorsTest, RefusedCommandsAreCountedOnceEachAndStopTheMotor) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000, 5000);
  rig->run_for(20'000'000);
  std::uint64_t refused = 0;
  for (const double rate : {10'000.01, -10'001.0, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(), -1e300}) {
    rig->command(rate, 5000);
    rig->run_for(20'000'000);
    EXPECT_EQ(rig->report().refused_commands, ++refused) << rate;
  }
  const std::int64_t steps = rig->steps(0);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->steps(0), steps);
  EXPECT_GT(rig->steps(1), 500);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);
  rig->command(10'000, -10'000);  // the maximum itself is none
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->report().refused_commands, refused);
}

TEST(StepMotorsTest, HomesAndFaultsAtTheSwitches) {
  const auto rig = make_rig(config_with_switches());
  ASSERT_TRUE(rig->enable());
  rig->command(-1000, 1000);
  rig->run_for(20'000'000);
  rig->lines.press(low_end_bit(0));
  rig->run_for(20'000'000);
  EXPECT_TRUE(rig->report().homed[0]);
  EXPECT_FALSE(rig->report().homed[1]);
  EXPECT_EQ(rig->steps(0), 0);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);

  rig->lines.press(low_end_bit(0) | high_end_bit(1));
  rig->run_for(2'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kEndReached);
  EXPECT_EQ(rig->report().fault.motor, 1);
  EXPECT_FALSE(rig->lines.is_enabled());

  // It stays a fault until somebody disables; then it can move away.
  rig->motors.enable(true);
  rig->command(1000, -1000);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  rig->motors.enable(false);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kNone);
  ASSERT_TRUE(rig->enable());
  const std::int64_t steps = rig->steps(1);
  rig->command(1000, -1000);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kEnabled);
  EXPECT_LT(rig->steps(1), steps);
}

TEST(StepMotorsTest, StepsLostAreAFaultAtHome) {
  const auto rig = make_rig(config_with_switches());
  ASSERT_TRUE(rig->enable());
  rig->command(-1000);
  rig->run_for(20'000'000);
  rig->lines.press(low_end_bit(0));
  rig->run_for(5'000'000);
  rig->command(1000);
  rig->lines.press(0);
  rig->run_for(300'000'000);
  rig->command(-1000);
  rig->run_for(100'000'000);
  rig->lines.press(low_end_bit(0));
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kHomeMoved);
  EXPECT_EQ(rig->report().fault.motor, 0);
  EXPECT_FALSE(rig->report().homed[0]);
  EXPECT_FALSE(rig->lines.is_enabled());
}

TEST(StepMotorsTest, InputsThatCannotBeReadAreAFault) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  rig->lines.break_inputs(true);
  rig->run_for(1'100'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kInputsUnreadable);
  EXPECT_FALSE(rig->lines.is_enabled());
  const std::int64_t pulses = rig->pulses();
  // Disabling does not help while they are broken; nor are the drives ever on meanwhile.
  rig->lines.forget_edges();
  for (int i = 0; i < 3; ++i) {
    rig->motors.enable(i % 2 != 0);
    rig->run_for(5'000'000);
    EXPECT_EQ(rig->state(), PanTiltState::kFault);
    EXPECT_EQ(rig->report().fault.fault, StepFault::kInputsUnreadable);
  }
  for (const LineEdge& edge : rig->lines.edges()) EXPECT_FALSE(edge.level);
  EXPECT_EQ(rig->steps(), pulses);
  // Mended, and nobody wants them on: the fault is over by itself.
  rig->lines.break_inputs(false);
  rig->run_for(2'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  EXPECT_GE(rig->report().line_failures, 5U);
}

// However recently they were polled: what the switches say must be known first.
TEST(StepMotorsTest, DrivesAreNotSwitchedOnWithoutInputs) {
  const auto rig = make_rig();
  rig->run_for(2'500'000);
  rig->lines.break_inputs(true);
  rig->motors.enable(true);
  rig->run_once();
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->lines.edges().size(), 0U);
}

TEST(StepMotorsTest, AFaultOfDrivesThatAreOnStaysThoughItsCauseIsGone) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->lines.break_inputs(true);
  rig->run_for(2'000'000);
  rig->lines.break_inputs(false);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_FALSE(rig->lines.is_enabled());
}

TEST(StepMotorsTest, OutputsThatFailAreAFaultAndTriedAgain) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  while ((rig->lines.outputs() & step_bit(0)) == 0) {
    rig->clock.set_now_ns(rig->motors.next_deadline_ns());
    rig->run_once();
  }
  rig->lines.break_outputs(true);
  rig->run_for(10'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kOutputsFailed);
  EXPECT_FALSE(rig->lines.is_enabled());
  EXPECT_NE(rig->lines.outputs() & step_bit(0), 0U);  // stuck
  const std::uint64_t runs = rig->runs;
  rig->run_for(10'000'000);
  EXPECT_LE(rig->runs - runs, 11U);  // once a poll, no busy loop
  // The drives are not switched on again while the lines are stuck.
  rig->motors.enable(false);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kOutputsFailed);
  rig->lines.forget_edges();
  rig->motors.enable(true);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->lines.edges().size(), 0U);
  rig->motors.enable(false);
  rig->lines.break_outputs(false);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->lines.outputs() & step_bit(0), 0U);
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  EXPECT_GT(rig->pulses(), 50);
}

TEST(StepMotorsTest, AnEnableLineThatCannotBeDroppedIsToldAndTriedAgain) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->lines.break_enable(true);
  rig->motors.enable(false);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kEnableFailed);
  EXPECT_TRUE(rig->lines.is_enabled());
  rig->lines.break_enable(false);
  rig->run_for(2'000'000);
  EXPECT_FALSE(rig->lines.is_enabled());
  EXPECT_EQ(rig->state(), PanTiltState::kDisabled);
}

// Worse than the fault because of which they were to be switched off.
TEST(StepMotorsTest, DrivesThatStayOnInAFaultAreToldInsteadOfIt) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->lines.break_enable(true);
  rig->lines.break_inputs(true);
  rig->run_for(5'000'000);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kEnableFailed);
  EXPECT_TRUE(rig->lines.is_enabled());
  rig->lines.break_enable(false);
  rig->run_for(2'000'000);
  EXPECT_FALSE(rig->lines.is_enabled());
  EXPECT_EQ(rig->state(), PanTiltState::kFault);  // the drives are wanted on: until somebody disables
}

TEST(StepMotorsTest, AnEnableLineThatCannotBeRaisedIsAFault) {
  const auto rig = make_rig();
  rig->run_for(2'000'000);
  rig->lines.break_enable(true);
  rig->motors.enable(true);
  rig->command(5000);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->state(), PanTiltState::kFault);
  EXPECT_EQ(rig->report().fault.fault, StepFault::kEnableFailed);
  EXPECT_EQ(rig->pulses(), 0);
}

TEST(StepMotorsTest, ConfigurationTellsWhereLinesDoNotWork) {
  for (const bool enable_works : {true, false}) {
    for (const bool outputs_work : {true, false}) {
      const auto rig = std::make_unique<StepRig<>>();
      rig->lines.break_enable(!enable_works);
      rig->lines.break_outputs(!outputs_work);
      EXPECT_EQ(rig->configure(config_of_step_rig()).error, TimingError::kNone);
      EXPECT_EQ(rig->lines_work, enable_works && outputs_work);
    }
  }
}

TEST(StepMotorsTest, RefusesPollsAndSettlingThatCannotBe) {
  const auto error_of = [](auto change) {
    StepMotorsConfig config = config_of_step_rig();
    change(config);
    const auto rig = std::make_unique<StepRig<>>();
    return rig->configure(config).error;
  };
  EXPECT_EQ(error_of([](StepMotorsConfig&) {}), TimingError::kNone);
  EXPECT_EQ(error_of([](StepMotorsConfig& c) { c.poll_ns = 9'999; }), TimingError::kBadPoll);
  EXPECT_EQ(error_of([](StepMotorsConfig& c) { c.poll_ns = 100'000'001; }), TimingError::kBadPoll);
  EXPECT_EQ(error_of([](StepMotorsConfig& c) { c.settle_ns = -1; }), TimingError::kBadPoll);
  EXPECT_EQ(error_of([](StepMotorsConfig& c) { c.settle_ns = 10'000'000'001; }), TimingError::kBadPoll);
  EXPECT_EQ(error_of([](StepMotorsConfig& c) { c.motors[1].timing.ramp_ns = 0; }), TimingError::kBadRamp);
}

TEST(StepMotorsTest, LatenessIsCountedAndDelaysTheMotion) {
  const auto rig = make_rig();
  ASSERT_TRUE(rig->enable());
  rig->command(5000);
  rig->run_for(20'000'000);
  EXPECT_EQ(rig->report().late_events, 0U);
  rig->clock.set_now_ns(rig->motors.next_deadline_ns() + 7'020'000);  // 20 us of it are allowed
  rig->run_once();
  rig->run_for(2'000'000);
  EXPECT_EQ(rig->report().late_events, 1U);
  EXPECT_GT(rig->report().delay_ns, 6'800'000);  // the deadline may have been a poll's, before the edge's
  EXPECT_LE(rig->report().delay_ns, 7'000'000);
}

TEST(StepMotorsTest, RatesAreRoundedToThousandths) {
  EXPECT_EQ(to_millisteps_per_s(0), 0);
  EXPECT_EQ(to_millisteps_per_s(1.2346), 1235);
  EXPECT_EQ(to_millisteps_per_s(-1.2346), -1235);
  EXPECT_EQ(to_millisteps_per_s(std::numeric_limits<double>::quiet_NaN()), kNever_ns);
  EXPECT_EQ(to_millisteps_per_s(-1e12), kNever_ns);
  EXPECT_EQ(to_millisteps_per_s(9e11), 900'000'000'000'000);
}

}  // namespace
}  // namespace vergence::step
