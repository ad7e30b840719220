// Step lines through libgpiod, on a stand-in for it: what is requested and set, and every way it can fail.
#include "hal/gpio_step/libgpiod_lines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "hal/gpio_step/step_motors.hpp"
#include "hal/sim/sim_devices.hpp"
#include "tests/support/fake_gpiod.hpp"
#include "tests/support/step_rig.hpp"

namespace vergence::step {
namespace {

using testing::fake_gpio;
using testing::FakeGpio;
using testing::FakeGpioChip;
using testing::FakeGpioLine;
using testing::FakeGpioWrite;

constexpr std::array<const char*, kOutputLines> kOutputs = {"tilt-step", "tilt-dir",  "right-step",
                                                            "right-dir", "left-step", "left-dir"};
constexpr std::uint32_t kForward = forward_bit(0) | forward_bit(1) | forward_bit(2);

GpioName named(std::string_view text) {
  GpioName name{};
  std::copy(text.begin(), text.end(), name.begin());
  return name;
}

// Outputs and the enable line on one chip, two switches on another.
LinesConfig config_of_board() {
  LinesConfig config;
  config.outputs_chip = config.enable_chip = named("soc");
  config.inputs_chip = named("expander");
  for (std::size_t i = 0; i < kOutputs.size(); ++i) config.outputs[i].name = named(kOutputs[i]);
  config.enable.name = named("enable");
  config.inputs[0].name = named("tilt-low");
  config.inputs[5].name = named("left-high");
  return config;
}

class LibgpiodLinesTest : public ::testing::Test {
 protected:
  LibgpiodLinesTest() {
    gpio = FakeGpio();
    gpio.chips = {{"gpiochip0", "soc", {{"other"}, {"enable"}}},
                  {"gpiochip1", "expander", {{"left-high"}, {"tilt-low"}}},
                  {"gpiochip2", "bystander", {}}};
    for (const char* name : kOutputs) gpio.chips[0].lines.push_back({name});
  }
  ~LibgpiodLinesTest() override { EXPECT_EQ(gpio.open_handles, 0); }

  [[nodiscard]] std::uint32_t wires() const {
    std::uint32_t levels = 0;
    for (std::size_t i = 0; i < kOutputs.size(); ++i) {
      if (gpio.line(kOutputs[i]).level != 0) levels |= 1U << i;
    }
    return levels;
  }
  // What open() answers; nothing is left open or requested after an error.
  void expect_error(LinesErrorKind kind, const char* what, int os_error, const LinesConfig& wrong) {
    LibgpiodLines lines;
    const LinesError error = lines.open(wrong);
    EXPECT_EQ(error.kind, kind) << describe(error.kind);
    EXPECT_STREQ(error.what.data(), what);
    EXPECT_EQ(error.os_error, os_error) << std::strerror(error.os_error);
    EXPECT_EQ(gpio.open_handles, 0);
    for (const FakeGpioChip& chip : gpio.chips) {
      for (const FakeGpioLine& line : chip.lines) EXPECT_FALSE(line.is_ours) << line.name;
    }
    std::uint32_t levels = 0;
    EXPECT_FALSE(lines.set_outputs(0));
    EXPECT_FALSE(lines.set_enable(false));
    EXPECT_FALSE(lines.read_inputs(levels));
  }

  FakeGpio& gpio = fake_gpio();
  LinesConfig config = config_of_board();
};

TEST_F(LibgpiodLinesTest, RequestsTheEnableLineFirstAndAllAtRest) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  ASSERT_EQ(gpio.writes.size(), 7U);
  EXPECT_EQ(gpio.writes[0], (FakeGpioWrite{"enable", 0}));
  EXPECT_EQ(wires(), kForward);
  EXPECT_TRUE(gpio.line("tilt-low").is_ours);
  EXPECT_FALSE(gpio.line("tilt-low").is_output);
  EXPECT_FALSE(gpio.line("other").is_ours);
}

TEST_F(LibgpiodLinesTest, SetsAllOutputsInOneCall) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  for (std::uint32_t levels = 0; levels < 1U << kOutputLines; ++levels) {
    gpio.set_calls = 0;
    EXPECT_TRUE(lines.set_outputs(levels));
    EXPECT_EQ(wires(), levels);
    EXPECT_EQ(gpio.set_calls, 1);
  }
  EXPECT_TRUE(lines.set_enable(true));
  EXPECT_EQ(gpio.line("enable").level, 1);
  EXPECT_TRUE(lines.set_enable(false));
  EXPECT_EQ(gpio.line("enable").level, 0);
}

TEST_F(LibgpiodLinesTest, InvertedLinesAreTheOtherWayRound) {
  config.enable.inverted = true;
  config.outputs[0].inverted = config.outputs[3].inverted = true;
  config.inputs[5].inverted = true;
  const std::uint32_t inverted = step_bit(0) | forward_bit(1);
  {
    LibgpiodLines lines;
    ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
    EXPECT_EQ(gpio.writes[0], (FakeGpioWrite{"enable", 1}));
    EXPECT_EQ(wires(), kForward ^ inverted);
    for (const std::uint32_t levels : {0U, step_bit(0), forward_bit(1) | step_bit(2), kForward}) {
      EXPECT_TRUE(lines.set_outputs(levels));
      EXPECT_EQ(wires(), levels ^ inverted);
    }
    EXPECT_TRUE(lines.set_enable(true));
    EXPECT_EQ(gpio.line("enable").level, 0);
    std::uint32_t levels = 0;
    EXPECT_TRUE(lines.read_inputs(levels));
    EXPECT_EQ(levels, high_end_bit(2));
    gpio.line("tilt-low").level = gpio.line("left-high").level = 1;
    EXPECT_TRUE(lines.read_inputs(levels));
    EXPECT_EQ(levels, low_end_bit(0));
  }
  EXPECT_EQ(gpio.line("enable").level, 1);
}

// Inversions of one configuration are not left over in the next.
TEST_F(LibgpiodLinesTest, OpensAnew) {
  config.enable.inverted = config.outputs[0].inverted = config.inputs[0].inverted = true;
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  ASSERT_EQ(lines.open(config_of_board()).kind, LinesErrorKind::kNone);
  EXPECT_EQ(gpio.open_handles, 3);
  std::uint32_t levels = 1;
  EXPECT_TRUE(lines.read_inputs(levels));
  EXPECT_EQ(levels, 0U);
  EXPECT_EQ(wires(), kForward);
  EXPECT_EQ(gpio.line("enable").level, 0);
}

TEST_F(LibgpiodLinesTest, SwitchesMayBeAbsent) {
  config.inputs = {};
  config.inputs_chip = {};
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  EXPECT_EQ(gpio.open_handles, 2);
  std::uint32_t levels = 5;
  gpio.get_error = EIO;  // nothing is read
  EXPECT_TRUE(lines.read_inputs(levels));
  EXPECT_EQ(levels, 0U);
}

TEST_F(LibgpiodLinesTest, ClosingDropsTheEnableLineThenEndsPulsesAndReleasesAll) {
  for (const bool by_destructor : {true, false}) {
    LibgpiodLines outer;
    {
      LibgpiodLines inner;
      LibgpiodLines& lines = by_destructor ? inner : outer;
      ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
      ASSERT_TRUE(lines.set_enable(true));
      ASSERT_TRUE(lines.set_outputs(kForward | step_bit(1)));
      gpio.writes.clear();
      if (!by_destructor) lines.close();
    }
    const std::vector<FakeGpioWrite> expected = {{"enable", 0}, {"right-step", 0}};
    EXPECT_EQ(gpio.writes, expected);
    EXPECT_EQ(gpio.open_handles, 0);
    EXPECT_FALSE(gpio.line("enable").is_ours);
    EXPECT_FALSE(gpio.line("right-step").is_ours);
    EXPECT_FALSE(gpio.line("tilt-low").is_ours);
  }
}

TEST_F(LibgpiodLinesTest, CallsThatFailAnswerFalseAndGoOnAfterwards) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  std::uint32_t levels = 0;
  gpio.set_error = gpio.get_error = EIO;
  EXPECT_FALSE(lines.set_outputs(kForward | step_bit(0)));
  EXPECT_FALSE(lines.set_enable(true));
  EXPECT_FALSE(lines.read_inputs(levels));
  gpio.set_error = gpio.get_error = 0;
  EXPECT_TRUE(lines.set_outputs(kForward | step_bit(0)));
  EXPECT_TRUE(lines.set_enable(true));
  EXPECT_TRUE(lines.read_inputs(levels));
  gpio.set_error = ENODEV;  // unplugged: closing does not mind
}

TEST_F(LibgpiodLinesTest, NamesWhatHasNoName) {
  for (std::size_t i = 0; i < kOutputs.size(); ++i) {
    LinesConfig nameless = config;
    nameless.outputs[i].name = {};
    expect_error(LinesErrorKind::kNotNamed, "", 0, nameless);
  }
  config.enable.name = {};
  expect_error(LinesErrorKind::kNotNamed, "", 0, config);
  for (GpioName LinesConfig::*chip :
       {&LinesConfig::outputs_chip, &LinesConfig::enable_chip, &LinesConfig::inputs_chip}) {
    LinesConfig nameless = config_of_board();
    nameless.*chip = {};
    expect_error(LinesErrorKind::kNotNamed, "", 0, nameless);
  }
}

TEST_F(LibgpiodLinesTest, NamesWhatIsNotThere) {
  for (GpioName LinesConfig::*chip :
       {&LinesConfig::outputs_chip, &LinesConfig::enable_chip, &LinesConfig::inputs_chip}) {
    LinesConfig wrong = config;
    wrong.*chip = named("nowhere");
    expect_error(LinesErrorKind::kChipNotFound, "nowhere", ENOENT, wrong);
  }
  for (const auto& name : {&config.outputs[4].name, &config.enable.name, &config.inputs[5].name}) {
    const GpioName before = *name;
    *name = named("nothing");
    expect_error(LinesErrorKind::kLineNotFound, "nothing", ENOENT, config);
    *name = before;
  }
}

TEST_F(LibgpiodLinesTest, NamesALineWithTwoPurposes) {
  LinesConfig twice = config;
  twice.outputs[5].name = twice.outputs[2].name;
  expect_error(LinesErrorKind::kNamedTwice, "right-step", 0, twice);
  twice = config;
  twice.outputs[5].name = twice.enable.name;
  expect_error(LinesErrorKind::kNamedTwice, "enable", 0, twice);
  twice = config;
  twice.inputs[1].name = twice.inputs[0].name;
  expect_error(LinesErrorKind::kNamedTwice, "tilt-low", 0, twice);
  // The same name on another chip is another line.
  gpio.chips[1].lines.push_back({"enable"});
  twice = config;
  twice.inputs[1].name = twice.enable.name;
  LibgpiodLines lines;
  EXPECT_EQ(lines.open(twice).kind, LinesErrorKind::kNone);
}

TEST_F(LibgpiodLinesTest, NamesTheLineThatSomebodyElseUses) {
  for (const char* name : {"tilt-step", "left-dir", "enable", "tilt-low", "left-high"}) {
    gpio.line(name).is_others = true;
    expect_error(LinesErrorKind::kLineBusy, name, EBUSY, config);
    EXPECT_EQ(gpio.line("enable").level, 0);
    gpio.line(name).is_others = false;
  }
}

TEST_F(LibgpiodLinesTest, TellsWhereThePermissionIsMissing) {
  for (const int os_error : {EACCES, EPERM}) {
    const auto expect_no_permission = [&](int& fault, const char* what) {
      fault = os_error;
      expect_error(LinesErrorKind::kNoPermission, what, os_error, config);
      fault = 0;
    };
    expect_no_permission(gpio.list_error, "soc");
    expect_no_permission(gpio.find_error, "enable");
    expect_no_permission(gpio.enable_request_error, "enable");
    expect_no_permission(gpio.output_request_error, "soc");
    expect_no_permission(gpio.input_request_error, "expander");
  }
}

TEST_F(LibgpiodLinesTest, PassesOtherErrorsOn) {
  for (const int os_error : {EIO, ENODEV, EINVAL}) {
    const auto expect_other = [&](int& fault, LinesErrorKind kind, const char* what) {
      fault = os_error;
      expect_error(kind, what, os_error, config);
      fault = 0;
    };
    expect_other(gpio.list_error, LinesErrorKind::kChipNotFound, "soc");
    expect_other(gpio.find_error, LinesErrorKind::kLineNotFound, "enable");
    expect_other(gpio.enable_request_error, LinesErrorKind::kRequestFailed, "enable");
    expect_other(gpio.output_request_error, LinesErrorKind::kRequestFailed, "soc");
    expect_other(gpio.input_request_error, LinesErrorKind::kRequestFailed, "expander");
  }
}

// Two boards of a kind. Labels do not tell them apart; the chip's name does.
TEST_F(LibgpiodLinesTest, TwoChipsWithOneLabelAreToldApartByName) {
  gpio.chips[2] = {"gpiochip2", "expander", {{"tilt-low"}}};
  expect_error(LinesErrorKind::kChipUnclear, "expander", 0, config);
  config.inputs[5].name = {};
  config.inputs_chip = named("gpiochip2");
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  EXPECT_TRUE(gpio.chips[2].lines[0].is_ours);
  EXPECT_FALSE(gpio.line("tilt-low").is_ours);
  EXPECT_EQ(gpio.open_handles, 3);
}

// Where another chip may not be opened, labels cannot be read; a chip's name still finds it.
TEST_F(LibgpiodLinesTest, AChipsNameNeedsNoPermissionForTheOthers) {
  gpio.list_error = EACCES;
  config.outputs_chip = config.enable_chip = named("gpiochip0");
  config.inputs_chip = named("gpiochip1");
  {
    LibgpiodLines lines;
    EXPECT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  }
  gpio.list_error = 0;
  gpio.open_error = EACCES;
  expect_error(LinesErrorKind::kNoPermission, "gpiochip0", EACCES, config);
}

TEST_F(LibgpiodLinesTest, EveryErrorHasWordsOfItsOwn) {
  std::vector<std::string> words;
  for (int i = 0; i <= static_cast<int>(LinesErrorKind::kRequestFailed); ++i) {
    words.emplace_back(describe(static_cast<LinesErrorKind>(i)));
    EXPECT_EQ(words.back().find("unknown"), std::string::npos);
  }
  std::sort(words.begin(), words.end());
  EXPECT_EQ(std::unique(words.begin(), words.end()), words.end());
}

// All of it together: pulses arrive at the wires, and a chip that goes away is a fault.
TEST_F(LibgpiodLinesTest, MotorsTurnOnThem) {
  LibgpiodLines lines;
  ASSERT_EQ(lines.open(config).kind, LinesErrorKind::kNone);
  sim::SimClock clock;
  StepMotors<LibgpiodLines, sim::SimClock> motors(lines, clock);
  bool lines_work = false;
  StepMotorsConfig motor_config = testing::config_of_step_rig();
  motor_config.motors[0].low_end = EndAction::kHome;
  ASSERT_EQ(motors.configure(motor_config, lines_work).error, TimingError::kNone);
  ASSERT_TRUE(lines_work);
  PanTiltFeedback feedback;
  const auto run_for = [&](std::int64_t ns) {
    for (const std::int64_t end_ns = clock.now_ns() + ns; motors.next_deadline_ns() < end_ns;) {
      clock.set_now_ns(std::max(clock.now_ns(), motors.next_deadline_ns()));
      motors.run_edges(clock.now_ns());
      (void)motors.read(feedback);
    }
  };
  motors.enable(true);
  motors.command({-3000, 3000, 0});
  run_for(30'000'000);
  EXPECT_EQ(gpio.line("enable").level, 1);
  EXPECT_EQ(gpio.line("tilt-dir").level, 0);
  motors.command({-3000, 0, 0});
  run_for(10'000'000);
  const auto rises = [&](const char* name) {
    return std::count(gpio.writes.begin(), gpio.writes.end(), FakeGpioWrite{name, 1});
  };
  EXPECT_EQ(rises("right-step"), feedback.steps[1]);
  EXPECT_GT(feedback.steps[1], 50);
  gpio.line("tilt-low").level = 1;
  run_for(5'000'000);
  EXPECT_TRUE(motors.report().homed[0]);
  motors.command({-3000, 3000, 0});
  run_for(5'000'000);
  gpio.set_error = ENODEV;
  run_for(5'000'000);
  EXPECT_EQ(feedback.state, PanTiltState::kFault);
  EXPECT_EQ(motors.report().fault.fault, StepFault::kEnableFailed);
  gpio.set_error = 0;
  run_for(5'000'000);
  EXPECT_EQ(gpio.line("enable").level, 0);
  EXPECT_EQ(gpio.line("right-step").level, 0);
}

}  // namespace
}  // namespace vergence::step
