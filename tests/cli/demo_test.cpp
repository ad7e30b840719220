// `vergence demo`: what it lists, what it refuses, and the folder it leaves.
#include <nlohmann/json.hpp>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"

namespace vergence::test {
namespace {

TEST(DemoCommand, ListsItsScenarios) {
  const CommandResult outcome = run_vergence("demo --list --json");
  ASSERT_EQ(outcome.status, 0);
  const auto names = nlohmann::json::parse(outcome.output);
  ASSERT_TRUE(names.is_array());
  for (const char* name : {"lateral-known", "lateral-3dof", "lateral-6dof", "fitness-light", "arc-swing",
                           "fitness-12", "track-20", "servo-position", "servo-orientation", "pool"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
}

TEST(DemoCommand, RefusesWhatItDoesNotKnow) {
  expect_refusal("demo lateral", "lateral", "--list");
  expect_refusal("demo pool --seeds 0", "--seeds", "range");
  expect_refusal("demo --seed x", "--seed");
}

TEST(DemoCommand, SaysBeforeItRunsWhereItCannotWrite) {
  const TempDirectory directory;
  write_file(directory / "file", "");
  expect_refusal("demo shove --out " + (directory / "file" / "out").string(), "file");
}

TEST(DemoCommand, LeavesLogSummaryAndReport) {
  const TempDirectory directory;
  const auto out = directory / "out";
  const CommandResult outcome = run_vergence("demo fitness-light --json --out " + out.string());
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto summary = nlohmann::json::parse(read_file(out / "summary.json"));
  EXPECT_EQ(summary, nlohmann::json::parse(outcome.output));
  EXPECT_EQ(summary.at("scenario"), "fitness-light");
  EXPECT_EQ(summary.at("seed"), 1);
  EXPECT_EQ(summary.at("signature").get<std::string>().size(), 16U);
  const auto& metric = summary.at("metrics").at("peak_at_500lx");
  EXPECT_GE(metric.at("value").get<double>(), 0.85);
  EXPECT_EQ(metric.at("met"), true);
  EXPECT_NE(read_file(out / "report.html").find(summary.at("signature").get<std::string>()),
            std::string::npos);
  EXPECT_GT(std::filesystem::file_size(out / "log.csv"), 1000U);
}

}  // namespace
}  // namespace vergence::test
