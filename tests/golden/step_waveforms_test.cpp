// Edges of scripted commands, byte for byte as in tests/golden/step_waveforms: a line an edge, with its time.
// Where a change of behaviour is meant, run this test with VERGENCE_REGENERATE_GOLDEN=1, look at what
// changed, and say why in the commit.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>

#include "tests/support/step_rig.hpp"

namespace vergence::step {
namespace {

using Rig = testing::StepRig<>;

constexpr std::array<const char*, kOutputLines + 1> kLineNames = {
    "tilt.step", "tilt.forward", "right.step", "right.forward", "left.step", "left.forward", "enable",
};

struct Script {
  const char* name;
  std::function<void(Rig&)> play;  // from enabled and settled, at 5 ms
};

std::ostream& operator<<(std::ostream& out, const Script& script) {
  return out << script.name;
}

const std::array kScripts = {
    Script{"ramp_up",
           [](Rig& rig) {
             rig.command(10'000);
             rig.run_for(12'000'000);
           }},
    Script{"reverse",
           [](Rig& rig) {
             rig.command(3'000, -1'000);
             rig.run_for(6'000'000);
             rig.command(-3'000, 1'000);
             rig.run_for(12'000'000);
           }},
    // Disabled 2 us after a step began: the enable line drops then, the pulse keeps its 5 us, none follows.
    Script{"halt_inside_a_pulse",
           [](Rig& rig) {
             rig.command(4'000);
             rig.run_for(6'000'000);
             while ((rig.lines.outputs() & step_bit(0)) == 0) {
               rig.clock.set_now_ns(rig.motors.next_deadline_ns());
               rig.run_once();
             }
             rig.clock.set_now_ns(rig.clock.now_ns() + 2'000);
             rig.motors.enable(false);
             rig.run_for(5'000'000);
           }},
    // 10 000.001 a second is a thousandth too much: that motor ramps to rest, the other goes on.
    Script{"rate_above_maximum",
           [](Rig& rig) {
             rig.command(3'000, 2'000);
             rig.run_for(6'000'000);
             rig.command(10'000.001, 2'000);
             rig.run_for(7'000'000);
           }},
    Script{"limit_switch",
           [](Rig& rig) {
             rig.command(2'000, 0, 2'000);
             rig.run_for(6'000'000);
             rig.lines.press(high_end_bit(2));
             rig.run_for(3'000'000);
           }},
    // Each call 9 us late, and each write takes 3 us: together more than half the jitter.
    Script{"late_and_slow",
           [](Rig& rig) {
             rig.late_ns = 9'000;
             rig.lines.set_duration_ns(1'000, 2'000);
             rig.command(7'000, -7'000, 3'333.333);
             rig.run_for(12'000'000);
           }},
};

std::string play(const Script& script) {
  StepMotorsConfig config = testing::config_of_step_rig();
  config.motors[2].high_end = EndAction::kFault;
  const auto rig = std::make_unique<Rig>();
  EXPECT_EQ(rig->configure(config).error, TimingError::kNone);
  EXPECT_TRUE(rig->enable());
  script.play(*rig);
  EXPECT_EQ(rig->lines.lost_edges(), 0U);
  std::ostringstream text;
  text << "# t_ns line level\n";
  for (const LineEdge& edge : rig->lines.edges()) {
    text << edge.t_ns << ' ' << kLineNames.at(static_cast<std::size_t>(edge.line)) << ' ' << edge.level
         << '\n';
  }
  return text.str();
}

class StepWaveforms : public ::testing::TestWithParam<Script> {};

INSTANTIATE_TEST_SUITE_P(Scripts, StepWaveforms, ::testing::ValuesIn(kScripts),
                         [](const auto& script) { return std::string(script.param.name); });

TEST_P(StepWaveforms, KeepTheirEdges) {
  const std::string path = std::string(VERGENCE_GOLDEN) + "/step_waveforms/" + GetParam().name + ".txt";
  const std::string waveform = play(GetParam());
  if (std::getenv("VERGENCE_REGENERATE_GOLDEN") != nullptr) {
    ASSERT_TRUE(std::ofstream(path, std::ios::binary) << waveform) << path;
    FAIL() << "written anew: " << path;
  }
  std::ifstream file(path, std::ios::binary);
  ASSERT_TRUE(file) << path;
  std::ostringstream golden;
  golden << file.rdbuf();
  EXPECT_EQ(waveform, golden.str()) << path;
}

}  // namespace
}  // namespace vergence::step
