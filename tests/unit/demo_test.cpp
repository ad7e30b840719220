// The closed loop on the simulated robot: the same seed is the same run to the bit, and what reports are made
// of is counted right. (The experiments at full length: `vergence demo --all`.)
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "tests/support/small_dataset.hpp"
#include "tools/demo/closed_loop.hpp"
#include "tools/demo/measures.hpp"

namespace vergence::demo {
namespace {

using test::TempDirectory;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

LoopSetup swaying_marker(bool pose_given) {
  LoopSetup setup;
  setup.name = "swaying";
  setup.scene =
      "[image]\nwidth = 320\nheight = 240\n"
      "[rig]\nkind = \"eyes\"\nfx = 400\n"
      "[target]\nkind = \"marker\"\n"
      "[motion]\nkind = \"sine\"\npose = [0, -100, 545, 0, 0, 0]\namplitude = [60, 0, 0, 0, 0, 0]\n"
      "omega_rad_s = 1.256\n"
      "[background]\nkind = \"plain\"\nhue_deg = 45\nsaturation = 0.12\nvalue = 0.60\n";
  setup.duration_s = 3;
  setup.T_W_S = lateral_start();
  setup.pose_given = pose_given;
  setup.adjust_robot = [](RobotConfig& robot) { robot.relation.T_Ed_M.t_mm = {0, -100, 545}; };
  return setup;
}

tools::LogTable run(const LoopSetup& setup, std::uint64_t seed, const std::filesystem::path& out) {
  RunOptions options;
  options.seed = seed;
  options.out = out;
  ClosedLoop loop(setup, options);
  loop.run();
  return loop.take_log();
}

TEST(Demo, ScenariosHaveNamesOfTheirOwnAndAreFoundByThem) {
  std::set<std::string> names;
  for (const Scenario& scenario : scenarios()) {
    EXPECT_TRUE(names.insert(scenario.name).second);
    EXPECT_EQ(find_scenario(scenario.name), &scenario);
    EXPECT_NE(std::string(scenario.description).find('.'), std::string::npos);
  }
  EXPECT_GE(names.size(), 14U);
  EXPECT_EQ(find_scenario("lateral"), nullptr);
}

// What controller, arm, motors and cameras did in three seconds, in one number.
TEST(Demo, AGivenPoseKeepsItsBits) {
  const TempDirectory directory;
  const tools::LogTable log = run(swaying_marker(true), 1, directory.path());
  EXPECT_EQ(log.signature(), "015a096696521cc8");
  const Window settled{2, 3};
  EXPECT_LT(largest(distances_mm(log, "wanted", "hand", settled)), 5);
  EXPECT_LT(largest(distances_mm(log, "target", "gaze", settled)), 3);
}

TEST(Demo, TheSameSeedIsTheSameRunAndAnotherIsNot) {
  const TempDirectory directory;
  LoopSetup setup = swaying_marker(false);
  setup.duration_s = 1;
  const tools::LogTable first = run(setup, 1, directory.path());
  EXPECT_EQ(first.signature(), run(setup, 1, directory.path()).signature());
  EXPECT_NE(first.signature(), run(setup, 2, directory.path()).signature());
}

TEST(Demo, TheWallClockChangesNothingButTheTimeItTakes) {
  const TempDirectory directory;
  LoopSetup setup = swaying_marker(true);
  setup.duration_s = 0.4;
  const std::string signature = run(setup, 1, directory.path()).signature();
  RunOptions options;
  options.out = directory.path();
  options.wall_clock = true;
  const auto begun = std::chrono::steady_clock::now();
  ClosedLoop loop(setup, options);
  loop.run();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  EXPECT_GE(took.count(), 0.399);  // it never runs ahead; how far behind is the machine's affair
  EXPECT_EQ(loop.log().signature(), signature);
}

TEST(Demo, TheMarkerIsSeenAndFollowedThroughPictures) {
  const TempDirectory directory;
  const tools::LogTable log = run(swaying_marker(false), 1, directory.path());
  EXPECT_EQ(first_lock(log).frames_before, 0);
  const SeenErrors seen = seen_errors(log, {});
  EXPECT_EQ(seen.tracked, seen.frames);
  EXPECT_GE(seen.frames, 85);
  EXPECT_LT(seen.largest_mm, 3);
  EXPECT_LT(largest(distances_mm(log, "wanted", "hand", {2.5, 3})), 8);
}

tools::LogTable little_log() {
  tools::LogTable log({"t_s", "a_x_mm", "a_y_mm", "a_z_mm", "a_e1", "a_e2", "a_e3", "b_x_mm", "b_y_mm",
                       "b_z_mm", "b_e1", "b_e2", "b_e3", "frame_stamp_s", "state", "seen_x_mm"});
  log.append({0, 0, 0, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0.1, 0.0, 0, kNaN});
  log.append({1, 1, 1, 1, 0, 0, 0, 1, 1, 1, 0, 0, 0, kNaN, kNaN, kNaN});
  log.append({2, kNaN, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.9, 1, 7});
  return log;
}

TEST(Measures, CountWhatHasAValue) {
  const tools::LogTable log = little_log();
  EXPECT_EQ(distances_mm(log, "a", "b", {}), (std::vector<double>{5, 0}));
  EXPECT_EQ(distances_mm(log, "a", "b", {0.5, 5}), (std::vector<double>{0}));
  EXPECT_EQ(difference(log, "a_x_mm", "b_x_mm", {}), (std::vector<double>{-3, 0}));
  EXPECT_NEAR(turns_e(log, "a", "b", {0, 0}).at(0), 0.1, 1e-12);
  EXPECT_NEAR(rms({3, 4}), std::sqrt(12.5), 1e-12);
  EXPECT_EQ(largest({-3, 2}), 3);
  EXPECT_TRUE(std::isnan(rms({})));
  EXPECT_TRUE(std::isnan(largest({})));
  EXPECT_EQ(first_lock(log).frames_before, 1);
  EXPECT_EQ(first_lock(log).t_s, 1.9);
  EXPECT_EQ(points(log, "seen_x_mm", "").x, (std::vector<double>{1.9}));
}

}  // namespace
}  // namespace vergence::demo
