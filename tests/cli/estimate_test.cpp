// `vergence estimate` and `fitness-map` on good data sets: they find the target, say so in the promised form,
// and say the same when asked again.
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <vector>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::test {
namespace {

using Json = nlohmann::json;

std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
  return lines;
}

std::vector<Json> estimate(const TempDirectory& directory, const std::string& options) {
  const CommandResult result = run_vergence("estimate " + directory.path().string() + " --json - " + options);
  EXPECT_EQ(result.status, 0) << result.output;
  return json_lines(result.output);
}

void expect_near_truth(const Json& line, double within_mm, double within_e) {
  const Pose truth = small_pose(line["frame"]);
  const Json& pose = line["pose"];
  EXPECT_NEAR(pose["x_mm"], truth.position_mm[0], within_mm) << line;
  EXPECT_NEAR(pose["y_mm"], truth.position_mm[1], within_mm) << line;
  EXPECT_NEAR(pose["z_mm"], truth.position_mm[2], within_mm) << line;
  for (const char* e : {"e1", "e2", "e3"}) EXPECT_NEAR(pose[e], 0, within_e) << line;
}

TEST(Estimate, FindsTheCardInEveryFrame) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  const auto lines = estimate(directory, "");
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(kSmallFrames));
  for (int frame = 0; frame < kSmallFrames; ++frame) {
    const Json& line = lines[static_cast<std::size_t>(frame)];
    EXPECT_EQ(line["frame"], frame);
    EXPECT_NEAR(line["t_s"], frame / 30.0, 1e-12);
    EXPECT_EQ(line["state"], "tracking");
    EXPECT_GT(line["fitness"], 1.0);
    EXPECT_GT(line["confidence"], 0.5);
    EXPECT_LE(line["confidence"], 1.0);
    EXPECT_GT(line["generations"], 0);
    EXPECT_GT(line["evaluations"], 0);
    EXPECT_GT(line["compute_ms"], 0.0);
    expect_near_truth(line, 2.0, 0.03);
    EXPECT_LT(line["error"]["position_mm"], 3.5);
  }
}

// Searches this short often find where a card is and take it for one tilted by 0.2. Told at once, before a
// relief is learned that explains the tilt.
TEST(Estimate, RightsTheTiltThatAShortSearchFound) {
  const TempDirectory directory;
  const std::string scene = std::string(VERGENCE_SCENES) + "/card_flat.toml";
  const CommandResult rendered =
      run_vergence("render " + scene + " -o " + directory.path().string() + " --frames 3");
  ASSERT_EQ(rendered.status, 0) << rendered.output;
  int found = 0;
  int elsewhere = 0;
  for (int seed = 1; seed <= 7; ++seed) {
    for (const Json& line : estimate(directory, "--generations 200 --seed " + std::to_string(seed))) {
      if (line["state"] != "tracking") continue;
      // So short a search ends somewhere else now and then, and may believe it, but for one frame.
      if (line["error"]["position_mm"] > 15 && line["frame"] == 0) {
        ++elsewhere;
        continue;
      }
      ++found;
      EXPECT_LT(line["error"]["position_mm"], 1.5) << line;
      EXPECT_LT(line["error"]["e"], 0.01) << line;
    }
  }
  EXPECT_GE(found, 14) << "of 21";
  EXPECT_LE(elsewhere, 1) << "of 7";
}

TEST(Estimate, StatesStageAndCovarianceOfThePose) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  for (const char* stage : {"evolved", "refined", "relief"}) {
    for (const Json& line : estimate(directory, std::string("--frames 0 --set-stage ") + stage)) {
      ASSERT_EQ(line["covariance"].size(), 36U);
      double diagonal = 0;
      for (unsigned row = 0; row < 6; ++row) {
        for (unsigned column = 0; column < 6; ++column) {
          EXPECT_EQ(line["covariance"][6 * row + column], line["covariance"][6 * column + row]);
        }
        EXPECT_GE(line["covariance"][7 * row], 0.0);
        diagonal += line["covariance"][7 * row].get<double>();
      }
      // A covariance comes with refinement and not before.
      EXPECT_EQ(line["stage"] == "evolved", diagonal == 0);
      if (std::string(stage) == "evolved") {
        EXPECT_EQ(line["stage"], "evolved");
      }
      EXPECT_NE(line["stage"], std::string(stage) == "refined" ? "relief" : "");
    }
  }
}

TEST(Estimate, FindsTheMarker) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  // Votes of hue have a plateau: a ball's disc has 17 pixels' radius here.
  for (const Json& line : estimate(directory, "--cold")) expect_near_truth(line, 25.0, 0.15);
}

TEST(Estimate, SaysTheSameAgainButForTheTime) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  const auto said = [&](const std::string& options) {
    auto lines = estimate(directory, options);
    for (Json& line : lines) line.erase("compute_ms");
    return lines;
  };
  const auto once = said("--seed 5 --generations 200");
  EXPECT_EQ(once, said("--seed 5 --generations 200"));
  EXPECT_NE(once, said("--seed 6 --generations 200"));
  for (const Json& line : once) EXPECT_EQ(line["generations"], 200);
}

TEST(Estimate, TakesTheChosenFramesOnly) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  const auto numbers = [&](const std::string& range) {
    std::vector<int> frames;
    for (const Json& line : estimate(directory, "--generations 5 --frames " + range))
      frames.push_back(line["frame"]);
    return frames;
  };
  EXPECT_EQ(numbers("1:2"), (std::vector<int>{1}));
  EXPECT_EQ(numbers("1:"), (std::vector<int>{1, 2}));
  EXPECT_EQ(numbers(":2"), (std::vector<int>{0, 1}));
  EXPECT_EQ(numbers("2"), (std::vector<int>{2}));
}

TEST(Estimate, ATimeBudgetIsKeptToAndUsed) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  for (const Json& line : estimate(directory, "--cold --budget-ms 60")) {
    // At most half of it is set aside for refinement, however slow the machine.
    EXPECT_GE(line["compute_ms"], 30.0);
    EXPECT_GT(line["generations"], 20);
  }
}

TEST(Estimate, PrintsATableAndDrawsEveryFrame) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  const CommandResult result =
      run_vergence("estimate " + directory.path().string() + " --json " + (directory / "out.jsonl").string() +
                   " --overlay " + (directory / "over/lay").string());
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("err_mm"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("frames      3, tracked 3 (100.0 %)"), std::string::npos) << result.output;
  EXPECT_EQ(json_lines(read_file(directory / "out.jsonl")).size(), static_cast<std::size_t>(kSmallFrames));
  EXPECT_EQ(tools::read_png_rgb(directory / "over/lay/000002.png").width_px, 640);
}

TEST(Estimate, WarnsOfTruthWithoutImages) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  write_file(directory / "truth.csv", read_file(directory / "truth.csv") + "77,0,0,500,0,0,0\n");
  const CommandResult result = run_vergence("estimate " + directory.path().string() + " --generations 1");
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.output.find("warning"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("77"), std::string::npos) << result.output;
}

TEST(FitnessMap, PeaksAtTheTruth) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  const std::string csv = (directory / "map.csv").string();
  const CommandResult result = run_vergence("fitness-map " + directory.path().string() +
                                            " --frame 1 --axes x,y --step 2 --range x=-10:40 --csv " + csv);
  EXPECT_EQ(result.status, 0) << result.output;
  std::istringstream rows(read_file(csv));
  std::string header;
  std::getline(rows, header);
  EXPECT_EQ(header, "x_mm,y_mm,fitness");
  double best[3] = {0, 0, -9};
  int count = 0;
  for (std::string row; std::getline(rows, row); ++count) {
    double x = 0;
    double y = 0;
    double fitness = 0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf", &x, &y, &fitness), 3) << row;
    if (fitness > best[2]) {
      best[0] = x;
      best[1] = y;
      best[2] = fitness;
    }
  }
  EXPECT_EQ(count, 26 * 101);
  EXPECT_NEAR(best[0], small_pose(1).position_mm[0], 3);
  EXPECT_NEAR(best[1], small_pose(1).position_mm[1], 3);
}

TEST(FitnessMap, DrawsAPicture) {
  if (std::system("command -v gnuplot >/dev/null") != 0) GTEST_SKIP() << "gnuplot is not installed";
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  const CommandResult result =
      run_vergence("fitness-map " + directory.path().string() +
                   " --frame 0 --axes x,e2 --step 20,0.02 --png " + (directory / "map.png").string());
  EXPECT_EQ(result.status, 0) << result.output;
  const tools::RgbImage picture = tools::read_png_rgb(directory / "map.png");
  const std::set<std::uint8_t> levels(picture.data.begin(), picture.data.end());
  EXPECT_GT(levels.size(), 100U) << "the picture shows nothing";
}

TEST(FitnessMap, NeedsGnuplotForPicturesAndSaysSo) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  const std::string arguments = "fitness-map " + directory.path().string() +
                                " --frame 0 --axes x,z --step 20 --png " + (directory / "map.png").string();
  const CommandResult result = run_vergence(arguments, "PATH=/nowhere");
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_NE(result.output.find("gnuplot"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("apt install"), std::string::npos) << result.output;
}

TEST(Help, IsThereForEveryCommand) {
  for (const char* command : {"", "estimate", "fitness-map", "model", "render", "bench", "accuracy"}) {
    const CommandResult result = run_vergence(std::string(command) + " --help");
    EXPECT_EQ(result.status, 0) << command;
    EXPECT_NE(result.output.find("Usage: vergence"), std::string::npos) << result.output;
  }
  EXPECT_EQ(run_vergence("--version").output.rfind("vergence ", 0), 0U);
}

}  // namespace
}  // namespace vergence::test
