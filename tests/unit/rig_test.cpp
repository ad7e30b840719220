// The rig's parts that need no kernel of its own: what the trace says, when pictures are due, pictures as
// cameras give them, motors by pulses, and scenarios.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <vector>

#include "tools/io/input_error.hpp"
#include "tools/rig/fault_judge.hpp"
#include "tools/rig/picture_schedule.hpp"
#include "tools/rig/rig_scenario.hpp"
#include "tools/rig/rig_world.hpp"
#include "tools/rig/sway.hpp"
#include "tools/rig/trace_reader.hpp"
#include "tools/rig/yuyv.hpp"

namespace vergence::rig {
namespace {

TEST(RigTrace, TakesLevelsThatWereSet) {
  const auto edge =
      parse_edge("       vergenced-81      [000] d..1.    12.000586: gpio_value: 501 set 1", 499);
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->stamp_ns, 12'000'586'000);
  EXPECT_EQ(edge->line, 2);
  EXPECT_TRUE(edge->level);
  // A task may be named as it likes.
  const auto other = parse_edge(" a: b 1.5-7 [000] ..... 3.999999: gpio_value: 499 set 0", 499);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->stamp_ns, 3'999'999'000);
  EXPECT_FALSE(other->level);
}

TEST(RigTrace, LeavesTheRestOut) {
  EXPECT_FALSE(parse_edge("x-1 [000] ..... 3.999999: gpio_value: 501 get 1", 499));
  EXPECT_FALSE(parse_edge("x-1 [000] ..... 3.999999: gpio_value: 498 set 1", 499));  // of another chip
  EXPECT_FALSE(parse_edge("x-1 [000] ..... 3.999999: gpio_direction: 501 out (0)", 499));
  EXPECT_FALSE(parse_edge("x-1 [000] ..... 3.99: gpio_value: 501 set 1", 499));  // no microseconds
  EXPECT_FALSE(parse_edge("CPU:0 [LOST 12 EVENTS]", 499));
  EXPECT_FALSE(parse_edge("", 499));
}

TEST(RigTrace, TakesWhenPicturesWereTaken) {
  const auto capture = parse_capture(
      "v-84 [000] .....    11.330001: v4l2_dqbuf: minor = 2, index = 1, type = VIDEO_CAPTURE, bytesused = "
      "460800, "
      "flags = TIMESTAMP_MONOTONIC, field = NONE, timestamp = 11330000000, timecode = { type = 0x0 }, "
      "sequence = 17");
  ASSERT_TRUE(capture);
  EXPECT_EQ(capture->minor, 2);
  EXPECT_EQ(capture->stamp_ns, 11'330'000'000);
  EXPECT_FALSE(parse_capture("v-84 [000] ..... 11.330001: v4l2_dqbuf: minor = 2, index = 1"));
  EXPECT_FALSE(parse_capture("v-84 [000] ..... 11.330001: v4l2_qbuf: minor = 2, timestamp = 1"));
}

TEST(RigTrace, FindsAChipByItsLabel) {
  const char* const chips =
      "gpiochip1: GPIOs 480-498, parent: platform/gpio-sim.1, vergence-rig-2, can sleep:\n gpio-480 (a)\n"
      "gpiochip0: GPIOs 499-511, parent: platform/gpio-sim.0, vergence-rig, can sleep:\n gpio-499 (b)\n";
  EXPECT_EQ(first_number_of(chips, "vergence-rig"), 499);
  EXPECT_EQ(first_number_of(chips, "vergence-rig-2"), 480);
  EXPECT_FALSE(first_number_of(chips, "vergence"));
  EXPECT_FALSE(first_number_of("", "vergence-rig"));
}

// Captures in these gaps, over and over: where pictures are made, before each.
std::vector<std::int64_t> leads_ms(const std::vector<std::int64_t>& gaps_ms, int captures) {
  PictureSchedule schedule(33'000'000);
  std::int64_t next_ms = 1000;
  std::int64_t shown_ms = 0;
  std::vector<std::int64_t> leads;
  for (std::int64_t t_ms = 900; static_cast<int>(leads.size()) < captures; ++t_ms) {
    if (t_ms == next_ms) {
      leads.push_back(t_ms - shown_ms);
      schedule.captured(t_ms * 1'000'000);
      next_ms += gaps_ms[leads.size() % gaps_ms.size()];
    }
    if (schedule.is_due(t_ms * 1'000'000)) shown_ms = t_ms;
  }
  return leads;
}

TEST(RigPictures, ComeInTimeOnceTheRhythmIsKnown) {
  for (const std::vector<std::int64_t>& gaps :
       {std::vector<std::int64_t>{20, 30}, {10, 20, 20}, {17}, {16, 17, 17}}) {
    const std::vector<std::int64_t> leads = leads_ms(gaps, 60);
    for (std::size_t i = 10; i < leads.size(); ++i) {
      EXPECT_EQ(leads[i], PictureSchedule::kLead_ns / 1'000'000) << gaps.size() << " gaps, capture " << i;
    }
  }
}

TEST(RigPictures, GoOnWithoutACamera) {
  PictureSchedule schedule(33'000'000);
  int pictures = 0;
  for (std::int64_t t_ms = 100; t_ms < 1100; ++t_ms) pictures += schedule.is_due(t_ms * 1'000'000) ? 1 : 0;
  EXPECT_NEAR(pictures, 30, 1);
}

TEST(RigPictures, HaveTheColoursOfBt601) {
  tools::RgbImage image(6, 1);
  const std::uint8_t pixels[] = {255, 255, 255, 255, 255, 255, 255, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 0};
  std::copy(std::begin(pixels), std::end(pixels), image.data.begin());
  std::vector<std::uint8_t> yuyv;
  to_yuyv(image, yuyv);
  const std::uint8_t wanted[] = {235, 128, 235, 128, 82, 90, 82, 240, 41, 184, 16, 119};
  ASSERT_EQ(yuyv.size(), std::size(wanted));
  for (std::size_t i = 0; i < yuyv.size(); ++i) EXPECT_NEAR(yuyv[i], wanted[i], 1) << i;
}

constexpr int kEnable = 6;

TEST(RigMotors, CountPulsesOnceTheyAreEnabled) {
  EyeMotors motors({2546, 2546, -2546});
  std::int64_t t_ns = 1'000'000'000;
  const auto set = [&](int line, bool level) { motors.take({t_ns += 5'000, line, level}); };
  const auto pulses = [&](int motor, int count) {
    for (int i = 0; i < count; ++i) {
      set(2 * motor, true);
      set(2 * motor, false);
      t_ns += 500'000;
      motors.advance(t_ns);
    }
  };
  pulses(0, 10);
  EXPECT_EQ(motors.issued_steps(0), 0);
  set(kEnable, true);
  set(1, true);
  pulses(0, 300);
  set(1, false);
  t_ns += 50'000'000;
  motors.advance(t_ns);
  pulses(0, 100);
  set(5, true);
  pulses(2, 50);
  t_ns += 100'000'000;
  motors.advance(t_ns);
  motors.advance(t_ns += 50'000'000);
  EXPECT_EQ(motors.issued_steps(0), 200);
  EXPECT_EQ(motors.issued_steps(2), 50);
  EXPECT_EQ(motors.lost_steps(0), 0);
  EXPECT_NEAR(motors.angles().tilt_rad, 200 / 2546.0, 1e-6);
  EXPECT_NEAR(motors.angles().pan_left_rad, -50 / 2546.0, 1e-6);
  EXPECT_EQ(motors.times().high_ns, 5'000);
}

TEST(RigScenarios, AreAllReadable) {
  int scenarios = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(VERGENCE_RIG) / "scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const RigScenario scenario = read_scenario(entry.path());
    EXPECT_TRUE(std::filesystem::exists(scenario.scene)) << entry.path();
    ++scenarios;
  }
  EXPECT_GE(scenarios, 3);
}

TEST(RigScenarios, RefuseWhatNobodyKnows) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "rig_scenario.toml";
  const auto read = [&](const std::string& more) {
    std::ofstream(file) << "title = 't'\ndescription = 'd'\nscene = 's'\nduration_s = 1\n" << more;
    return read_scenario(file);
  };
  EXPECT_NO_THROW((void)read(""));
  EXPECT_EQ(read("[[fault]]\nkind = 'bus-off'\nat_s = 2\n[[fault]]\nkind = 'wrong-node'\nat_s = 1\n")
                .faults[0]
                .kind,
            FaultKind::kWrongNode);
  EXPECT_THROW((void)read("[[fault]]\nkind = 'bus-of'\nat_s = 2\n"), tools::InputError);
  EXPECT_THROW((void)read("[[fault]]\nkind = 'bus-off'\n"), tools::InputError);
  EXPECT_THROW((void)read("[[fault]]\nkind = 'bus-off'\nat_s = 1\nexpect = 'halt'\n"), tools::InputError);
  EXPECT_THROW((void)read("[[fault]]\nkind = 'bus-off'\nat_s = 1\njoint = 8\n"), tools::InputError);
  EXPECT_THROW((void)read("speed = 1\n"), tools::InputError);
  EXPECT_THROW((void)read("start = 'aside'\n"), tools::InputError);
  EXPECT_THROW((void)read("[[sway]]\njoint = 0\namplitude_rad = 0.1\nomega_rad_s = 1\n"), tools::InputError);
  // Over before it can be seen.
  EXPECT_THROW((void)read("[[fault]]\nkind = 'target-absent'\nat_s = 1\nfor_s = 0.2\nexpect = 'rest'\n"),
               tools::InputError);
}

TEST(RigSway, AddsUpAndHasItsVelocity) {
  const std::vector<Sway> sways = {{3, 0.1, 2}, {5, 1, 1}, {3, 0.05, 7}};
  EXPECT_EQ(swayed(sways, 2, 0.4, 1.3).position_rad, 0.4);
  EXPECT_EQ(swayed(sways, 2, 0.4, 1.3).velocity_rad_per_s, 0);
  EXPECT_EQ(swayed(sways, 3, 0.4, 0).position_rad, 0.4);
  constexpr double kStep_s = 1e-6;
  for (double t_s = 0; t_s < 3; t_s += 0.1) {
    const plant::JointState at = swayed(sways, 3, 0.4, t_s);
    EXPECT_NEAR(at.position_rad, 0.4 + 0.1 * std::sin(2 * t_s) + 0.05 * std::sin(7 * t_s), 1e-12);
    const double later_rad = swayed(sways, 3, 0.4, t_s + kStep_s).position_rad;
    EXPECT_NEAR(at.velocity_rad_per_s, (later_rad - at.position_rad) / kStep_s, 1e-5);
  }
}

// A target that is gone from 2 to 4 s, in a run of 6 s; the hand is to rest within 0.5 s and to go on
// within 1.
struct Absence {
  double still_s = 2.3;    // from then on the tool rests
  double moves_s = 4.4;    // from then on it moves again
  double search_s = 2.2;   // from then on the controller searches
  double tracks_to_s = 2;  // until then it saw the target
  double off_s = 9;        // from then on the drives are off
};

// Names of what was missed, without the fault's.
std::vector<std::string> missed(const Absence& course) {
  FaultEvent fault;
  fault.kind = FaultKind::kTargetAbsent;
  fault.name = "target-absent";
  fault.at_s = 2;
  fault.for_s = 2;
  fault.expect = Expectation::kRest;
  fault.within_s = 0.5;
  RigScenario scenario;
  scenario.duration_s = 6;
  scenario.faults = {fault};
  FaultJudge judge(scenario);
  for (int ms = 0; ms <= 6000; ++ms) {
    const double t_s = ms * 1e-3;
    const bool searches = t_s >= course.search_s && t_s < 4.2;
    const bool rests = t_s >= course.still_s && t_s < course.moves_s;
    judge.watch(
        {t_s, rests ? 0.0 : 80.0, t_s < course.off_s, searches, t_s < course.tracks_to_s || t_s > 4.1});
  }
  std::vector<std::string> names;
  for (const tools::Metric& metric : judge.metrics()) {
    if (!metric.met()) names.push_back(metric.name.substr(std::string("1_target-absent_").size()));
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(RigFaults, ARestIsOneWhileItLasts) {
  EXPECT_EQ(missed({}), Names{});
  EXPECT_EQ(missed({.still_s = 2.6}), (Names{"still_ms", "then_mm_per_s"}));
  EXPECT_EQ(missed({.moves_s = 3.9}), (Names{"then_mm_per_s"}));
  EXPECT_EQ(missed({.moves_s = 5.2}), (Names{"again_ms"}));
  EXPECT_EQ(missed({.search_s = 3}), (Names{"searching"}));
  EXPECT_EQ(missed({.tracks_to_s = 3}), (Names{"searching"}));
  EXPECT_EQ(missed({.off_s = 3}), (Names{"stops"}));
  EXPECT_EQ(missed({.still_s = 1}), (Names{"from_mm_per_s"}));
}

}  // namespace
}  // namespace vergence::rig
