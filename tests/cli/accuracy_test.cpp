// `vergence accuracy` on data sets of the user's, and what it refuses.
#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"

namespace vergence::test {
namespace {

TEST(Accuracy, ColdLooksAreCountedByDataSet) {
  const TempDirectory directory;
  write_small_photo_dataset(directory / "card");
  write_small_marker_dataset(directory / "balls");
  const CommandResult result = run_vergence("accuracy --seeds 2 --cold " + (directory / "card").string() +
                                            " " + (directory / "balls").string() + "/");
  EXPECT_EQ(result.status, 0) << result.output;
  // Three frames, two starts; the card is flat, and found.
  EXPECT_NE(result.output.find("| card | 6 | 100 | 100.0 | 100.0 | 100 | 100 |"), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("| balls | 6 |"), std::string::npos) << result.output;
}

TEST(Accuracy, SaysWhereATargetIsTrackedThatStandsStill) {
  const TempDirectory directory;
  write_small_photo_dataset(directory / "card");
  const CommandResult result =
      run_vergence("accuracy --seeds 2 --unlearned --stay 5 --cold " + (directory / "card").string());
  EXPECT_EQ(result.status, 0) << result.output;
  // Three frames, two starts.
  for (const char* row : {"| card | 6 | 1 | 100.0 | 0.0 | 100 | 100 |", "| card | 6 | 3 | 100.0 | 0.0 |"})
    EXPECT_NE(result.output.find(row), std::string::npos) << row << '\n' << result.output;
  EXPECT_EQ(result.output.find("| card | 6 | 10 |"), std::string::npos) << result.output;
}

TEST(Accuracy, RefusesWhatItCannotMeasure) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  std::filesystem::remove(directory / "truth.csv");
  expect_refusal("accuracy --cold " + directory.path().string(), "truth.csv", "accuracy needs the truth");
  expect_refusal("accuracy --only nonsense", "nonsense");
  expect_refusal("accuracy --stay 0 --cold " + directory.path().string(), "--stay", "1");
  expect_refusal("accuracy --stay 3", "--stay", "--cold");
  expect_refusal("accuracy --only time --scenes /nowhere --work " + (directory / "work").string(),
                 "no such scene", "--scenes");
}

}  // namespace
}  // namespace vergence::test
