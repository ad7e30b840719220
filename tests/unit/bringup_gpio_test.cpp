// The lines of the eyes' motors: every verdict, what is read of chips in memory, and pulse trains in virtual
// time.
#include <algorithm>
#include <cstring>

#include "hal/gpio_step/memory_lines.hpp"
#include "tests/support/findings.hpp"
#include "tools/bringup/gpio_checks.hpp"
#include "tools/bringup/pulse_train.hpp"

namespace vergence::tools {
namespace {

using testing::expect_all_pass;
using testing::expect_complete;
using testing::expect_finding;

void name(step::GpioName& to, const char* text) {
  to = {};
  std::strcpy(to.data(), text);
}

// All of chip "eyes", with two switches of the tilt.
step::LinesConfig config_of_lines() {
  step::LinesConfig config;
  const std::array<const char*, step::kOutputLines> outputs = {"tilt-step", "tilt-dir",  "right-step",
                                                               "right-dir", "left-step", "left-dir"};
  for (std::size_t i = 0; i < outputs.size(); ++i) name(config.outputs[i].name, outputs[i]);
  name(config.outputs_chip, "eyes");
  name(config.enable_chip, "eyes");
  name(config.enable.name, "enable");
  name(config.inputs_chip, "eyes");
  name(config.inputs[0].name, "tilt-low");
  name(config.inputs[1].name, "tilt-high");
  config.inputs[1].inverted = true;
  return config;
}

class FakeView final : public GpioView {
 public:
  FakeView() {
    const step::LinesConfig config = config_of_lines();
    GpioChip eyes{"gpiochip0", "eyes", {}};
    for (const WantedLine& line : wanted_lines(config))
      eyes.lines.push_back({line.name, line.is_output, false, ""});
    its_chips = {eyes, {"gpiochip1", "other", {{"tilt-step", false, true, "somebody"}}}};
  }
  std::vector<GpioChip> chips(std::string& problem) override {
    problem = its_problem;
    return problem.empty() ? its_chips : std::vector<GpioChip>{};
  }
  std::optional<bool> level(const std::string& label, const std::string& line) override {
    asked.push_back(label + "." + line);
    return line == "tilt-high";
  }
  GpioLine& line(const std::string& its_name) {
    auto& lines = its_chips[0].lines;
    return *std::find_if(lines.begin(), lines.end(),
                         [&](const GpioLine& each) { return each.name == its_name; });
  }

  std::vector<GpioChip> its_chips;
  std::string its_problem;
  std::vector<std::string> asked;
};

std::vector<Finding> look(FakeView& view, const step::LinesConfig& config = config_of_lines()) {
  const std::vector<Finding> findings = judge(look_at_lines(view, config), config);
  expect_complete(findings);
  return findings;
}

TEST(BringupGpio, PassesLinesThatAreThereAndFree) {
  FakeView view;
  const auto findings = look(view);
  for (const WantedLine& wanted : wanted_lines(config_of_lines())) {
    expect_finding(findings, wanted.role, Outcome::kPass, wanted.name);
  }
  expect_finding(findings, "tilt switches", Outcome::kPass,
                 "low end open, high end open");  // one is inverted
  expect_finding(findings, "pan_left switches", Outcome::kSkipped);
  EXPECT_EQ(view.asked, (std::vector<std::string>{"eyes.tilt-low", "eyes.tilt-high"}));
}

TEST(BringupGpio, NamesTheChipsThereAreWhereOneIsMissing) {
  FakeView view;
  view.its_chips[0].label = "hands";
  const auto findings = look(view);
  expect_finding(findings, "tilt step", Outcome::kFail, "no such chip", "gpiochip0 [hands]");
  expect_finding(findings, "enable", Outcome::kFail, "no such chip");
  EXPECT_TRUE(view.asked.empty());
}

TEST(BringupGpio, NamesTheLineThatIsMissingBusyOrAnOutput) {
  FakeView view;
  view.line("right-dir").name = "something";
  view.line("enable").is_used = true;
  view.line("enable").consumer = "leds";
  view.line("tilt-low").is_output = true;
  view.line("tilt-dir").is_output = false;  // still to be made one
  const auto findings = look(view);
  expect_finding(findings, "pan_right direction", Outcome::kFail, "'right-dir' of chip 'eyes': no such line",
                 "gpioinfo");
  expect_finding(findings, "enable", Outcome::kFail, "used by leds", "stop the program");
  expect_finding(findings, "tilt low switch", Outcome::kFail, "is an output", "unplug");
  expect_finding(findings, "tilt direction", Outcome::kPass, "an input");
  EXPECT_EQ(view.asked, std::vector<std::string>{"eyes.tilt-high"});  // an output is not touched
}

TEST(BringupGpio, WarnsOfNamesakesAndOfBothEndsPressed) {
  FakeView view;
  view.its_chips[0].lines.push_back(view.line("tilt-step"));
  step::LinesConfig config = config_of_lines();
  config.inputs[0].inverted = true;
  config.inputs[1].inverted = false;
  const auto findings = look(view, config);
  expect_finding(findings, "tilt step", Outcome::kWarn, "", "several lines");
  expect_finding(findings, "tilt switches", Outcome::kWarn, "low end pressed, high end pressed", "inverted");
}

TEST(BringupGpio, SaysWhereThereIsNothing) {
  FakeView view;
  view.its_problem = "the chips cannot be opened: Permission denied";
  auto findings = look(view);
  expect_finding(findings, "chips", Outcome::kFail, "Permission denied", "group");
  expect_finding(findings, "tilt step", Outcome::kSkipped);
  view.its_problem.clear();
  view.its_chips.clear();
  findings = look(view);
  expect_finding(findings, "chips", Outcome::kFail, "there are none", "gpiodetect");
  view = FakeView();
  step::LinesConfig config = config_of_lines();
  name(config.enable.name, "");
  expect_finding(look(view, config), "enable", Outcome::kFail, "has no name", "[eyes]");
}

// ---- moving
// -------------------------------------------------------------------------------------------------

struct VirtualSleeper {
  sim::SimClock* clock;
  void sleep_until(std::int64_t ns) { clock->set_now_ns(std::max(ns, clock->now_ns())); }
};

// The step line of one motor, wired back.
class FakeLoopback final : public EdgeWatch {
 public:
  FakeLoopback(const step::MemoryLines& lines, int motor) : lines_(&lines), motor_(motor) {}
  void collect(std::vector<std::int64_t>& rising_ns) override {
    for (; next_ < lines_->edges().size(); ++next_) {
      const step::LineEdge& edge = lines_->edges()[next_];
      if (edge.line != 2 * motor_ || !edge.level) continue;
      if (++count_ % loses_each == 0) continue;
      rising_ns.push_back(edge.t_ns + 2'000 + (count_ % 2 == 0 ? late_ns : 0));
    }
  }
  std::size_t loses_each = 1'000'000;
  std::int64_t late_ns = 0;

 private:
  const step::MemoryLines* lines_;
  int motor_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

class Pulses : public ::testing::Test {
 protected:
  Pulses() {
    for (step::MotorConfig& motor : config.motors) {
      motor.timing.max_rate_millisteps_per_s = 4'000'000;
      motor.timing.acceleration_millisteps_per_s2 = 80'000'000;
    }
  }
  [[nodiscard]] std::array<PulseObservation, kPanTiltMotors> run(EdgeWatch* watch = nullptr) {
    PulseTrain train(lines, clock, sleeper, watch);
    return train.run(config, plan);
  }
  [[nodiscard]] std::vector<Finding> judged(const std::array<PulseObservation, kPanTiltMotors>& seen,
                                            bool has_loopback = false) const {
    const std::vector<Finding> findings = judge(seen, has_loopback, plan.steps);
    expect_complete(findings);
    return findings;
  }

  sim::SimClock clock;
  VirtualSleeper sleeper{&clock};
  std::vector<step::LineEdge> record = std::vector<step::LineEdge>(20'000);
  step::MemoryLines lines{record, clock};
  step::StepMotorsConfig config;
  PulsePlan plan;
};

TEST_F(Pulses, EachMotorGoesThereAndBackAlone) {
  const auto seen = run();
  for (const PulseObservation& motor : seen) {
    EXPECT_EQ(motor.problem, "");
    EXPECT_EQ(motor.farthest_steps, 200);
    EXPECT_EQ(motor.final_steps, 0);
    ASSERT_EQ(motor.issued_ns.size(), 400U);
    EXPECT_GE(motor.issued_ns[1] - motor.issued_ns[0], 4'900'000);  // 200 a second
  }
  EXPECT_GT(seen[1].issued_ns.front(), seen[0].issued_ns.back());
  EXPECT_GT(seen[2].issued_ns.front(), seen[1].issued_ns.back());
  EXPECT_FALSE(lines.is_enabled());
  EXPECT_EQ(lines.lost_edges(), 0U);
  // The drives are on only while there are pulses, and come on before them.
  bool is_on = false;
  int switched = 0;
  for (const step::LineEdge& edge : lines.edges()) {
    if (edge.line == step::kEnableLine) {
      is_on = edge.level;
      ++switched;
    } else if (edge.line % 2 == 0 && edge.level) {
      EXPECT_TRUE(is_on);
    }
  }
  EXPECT_EQ(switched, 6);
  const auto findings = judged(seen);
  expect_finding(findings, "tilt moved", Outcome::kPass, "400 pulses, 200 steps there, back at 0, 0 late");
  expect_finding(findings, "loop-back", Outcome::kSkipped, "", "--loopback");
}

TEST_F(Pulses, ASlowMotorIsMovedNoFasterThanItsRate) {
  config.motors[1].timing.max_rate_millisteps_per_s = 50'000;
  const auto seen = run();
  ASSERT_EQ(seen[1].issued_ns.size(), 400U);
  EXPECT_GE(seen[1].issued_ns[10] - seen[1].issued_ns[9], 19'900'000);
}

TEST_F(Pulses, ASwitchInTheWayEndsIt) {
  config.motors[0].high_end = step::EndAction::kFault;
  config.motors[2].high_end = step::EndAction::kHome;
  config.motors[2].home_steps = 5000;  // which must not become 5000 steps back
  lines.press(step::high_end_bit(0) | step::high_end_bit(2));
  const auto seen = run();
  EXPECT_NE(seen[0].problem, "");
  EXPECT_TRUE(seen[0].issued_ns.empty());
  EXPECT_NE(seen[2].problem, "");
  EXPECT_TRUE(seen[2].issued_ns.empty());
  EXPECT_EQ(seen[1].issued_ns.size(), 400U);
  EXPECT_FALSE(lines.is_enabled());
  const auto findings = judged(seen);
  expect_finding(findings, "tilt moved", Outcome::kFail);
  expect_finding(findings, "pan_right moved", Outcome::kPass);
  expect_finding(findings, "pan_left moved", Outcome::kFail);
}

TEST_F(Pulses, LinesThatCannotBeSetEndIt) {
  lines.break_outputs(true);
  const auto seen = run();
  for (const PulseObservation& motor : seen) EXPECT_EQ(motor.problem, "the lines cannot be set");
  EXPECT_FALSE(lines.is_enabled());
  expect_finding(judged(seen), "pan_left moved", Outcome::kFail, "cannot be set");
}

TEST_F(Pulses, AreCountedAndTimedOnALoopback) {
  FakeLoopback loopback(lines, 1);
  const auto findings = judged(run(&loopback), true);
  expect_finding(findings, "pan_right loop-back", Outcome::kPass, "400 of 400 pulses came back");
  EXPECT_EQ(findings.size(), 4U);  // one motor is wired
}

TEST_F(Pulses, LostOrLatePulsesOfALoopbackAreSeen) {
  FakeLoopback losing(lines, 0);
  losing.loses_each = 100;
  expect_finding(judged(run(&losing), true), "tilt loop-back", Outcome::kFail, "396 of 400", "wiring");
  lines.forget_edges();
  FakeLoopback late(lines, 0);
  late.late_ns = 600'000;
  expect_finding(judged(run(&late), true), "tilt loop-back", Outcome::kWarn, "within 600 us", "late");
}

TEST_F(Pulses, ALoopbackThatIsWiredToNothingFails) {
  FakeLoopback loopback(lines, 7);
  expect_finding(judged(run(&loopback), true), "loop-back", Outcome::kFail, "no pulse came back", "wire");
}

TEST_F(Pulses, VerdictsOfWhatDidNotComeOutRight) {
  std::array<PulseObservation, kPanTiltMotors> seen;
  seen[0] = {"", 120, 0, 0, {}, {}};
  seen[1] = {"", 203, 2, 0, {}, {}};
  seen[2] = {"a fault", 0, 0, 0, {}, {}};
  const auto findings = judged(seen);
  expect_finding(findings, "tilt moved", Outcome::kFail, "120 steps there", "switch");
  expect_finding(findings, "pan_right moved", Outcome::kWarn, "back at 2", "ramp_steps_per_s2");
  expect_finding(findings, "pan_left moved", Outcome::kFail, "a fault");
  const auto none = not_moved("it was not confirmed");
  expect_complete(none);
  expect_finding(none, "tilt moved", Outcome::kSkipped, "", "not confirmed");
}

}  // namespace
}  // namespace vergence::tools
