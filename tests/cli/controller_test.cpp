// The commands around `vergenced`, and what it says itself where it cannot run.
#include <unistd.h>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"

namespace vergence::test {
namespace {

const std::string kExample = VERGENCE_EXAMPLES "/pa10_vergence/robot.toml";

CommandResult run_daemon(const std::string& arguments) {
  return run_command(std::string(VERGENCED) + " " + arguments);
}

void expect_failure(const std::string& arguments, const std::string& word) {
  const CommandResult result = run_vergence(arguments);
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_NE(result.output.find(word), std::string::npos) << result.output;
}

TEST(ConfigCommand, BuildsChecksAndShows) {
  const TempDirectory directory;
  const std::string image = (directory / "robot.vcfg").string();
  const CommandResult built = run_vergence("config build " + kExample + " -o " + image);
  ASSERT_EQ(built.status, 0) << built.output;
  EXPECT_EQ(run_vergence("config check " + image).status, 0);
  EXPECT_EQ(run_vergence("config check " + kExample).status, 0);
  const CommandResult of_image = run_vergence("config show " + image);
  EXPECT_EQ(of_image.status, 0);
  EXPECT_EQ(of_image.output, run_vergence("config show " + kExample).output);
  EXPECT_NE(of_image.output.find("position_per_s"), std::string::npos);
  std::string broken = read_file(image);
  broken[1000] = static_cast<char>(broken[1000] ^ 1);
  write_file(image, broken);
  expect_refusal("config check " + image, "robot.vcfg", "check sum");
  expect_refusal("config check " + (directory / "none.toml").string(), "none.toml", "no such file");
  expect_refusal("config build " + kExample + " -o " + (directory / "no/such/robot.vcfg").string(),
                 "no/such");
}

TEST(ConfigCommand, PrintsTheLoadOfEachBus) {
  const TempDirectory directory;
  const std::string image = (directory / "robot.vcfg").string();
  const std::string example = VERGENCE_EXAMPLES "/pa10_two_buses/robot.toml";
  ASSERT_EQ(run_vergence("config build " + example + " -o " + image).status, 0);
  for (const std::string& arguments : {"config check " + example, "config check " + image,
                                       "config show " + example, "config show " + image}) {
    const CommandResult result = run_vergence(arguments);
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find("bus 1, can0: 4 axes at 1000 Hz, loaded by 72.4 %"), std::string::npos)
        << result.output;
    EXPECT_NE(result.output.find("bus 2, can1: 3 axes at 1000 Hz, loaded by 58.5 %"), std::string::npos)
        << result.output;
  }
}

TEST(ControllerCommands, SayWhenNobodyIsThere) {
  const TempDirectory directory;
  expect_failure("ctl arm --socket " + (directory / "none").string(), "does vergenced run");
  expect_failure("watch --once --telemetry /vergence-none-" + std::to_string(::getpid()),
                 "does vergenced run");
  expect_refusal("ctl dance", "dance");
  write_file(directory / "box", "not one");
  expect_refusal("black-box " + (directory / "box").string() + " -o " + (directory / "out").string(), "box");
}

TEST(Daemon, RefusesWhatItCannotUse) {
  const TempDirectory directory;
  EXPECT_EQ(run_daemon("").status, 2);
  EXPECT_EQ(run_daemon("--config " + (directory / "none").string()).status, 2);
  write_file(directory / "text", "rig = 1\n");
  const CommandResult text = run_daemon("--config " + (directory / "text").string());
  EXPECT_EQ(text.status, 2);
  EXPECT_NE(text.output.find("vergence config build"), std::string::npos) << text.output;
  EXPECT_EQ(run_daemon("--help").status, 0);
}

TEST(Daemon, JudgesConfigurationAndMachineAndOpensNothing) {
  const TempDirectory directory;
  const std::string image = (directory / "robot.vcfg").string();
  ASSERT_EQ(run_vergence("config build " + kExample + " -o " + image).status, 0);
  EXPECT_EQ(run_daemon("--check --realtime=ignore --config " + image).status, 0);
  // None of the example's devices is here.
  const CommandResult run = run_daemon("--realtime=ignore --config " + image);
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.output.find("can0"), std::string::npos) << run.output;
}

TEST(ReplayCommand, ReproducesASignature) {
  const TempDirectory directory;
  const auto out = directory / "out";
  ASSERT_EQ(run_vergence("demo fitness-light --out " + out.string()).status, 0);
  const std::string again = " -o " + (directory / "again").string();
  const CommandResult replayed = run_vergence("replay " + (out / "summary.json").string() + again);
  EXPECT_EQ(replayed.status, 0) << replayed.output;
  EXPECT_NE(replayed.output.find("signature "), std::string::npos);
  const std::string summary = read_file(out / "summary.json");
  const std::size_t at = summary.find("\"signature\"") + 13;
  std::string other = summary;
  other[at + 3] = other[at + 3] == '0' ? '1' : '0';
  write_file(out / "summary.json", other);
  expect_failure("replay " + (out / "summary.json").string() + again, "another version");
  write_file(out / "summary.json", "{\"scenario\": \"none\", \"seed\": 1, \"signature\": \"0\"}");
  expect_refusal("replay " + (out / "summary.json").string() + again, "scenario");
  write_file(out / "summary.json", "nothing");
  expect_refusal("replay " + (out / "summary.json").string() + again, "JSON");
}

}  // namespace
}  // namespace vergence::test
