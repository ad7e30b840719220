// `vergence bringup` where there are no devices: a whole table, with remedies, and no exception.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"

namespace vergence::test {
namespace {

namespace fs = std::filesystem;

// An arm of two joints, eyes that turn, and cameras, none of which any machine has.
class Bringup : public ::testing::Test {
 protected:
  Bringup() {
    write_small_marker_dataset(folder.path());
    const std::string joint =
        "[[joint]]\nalpha_deg = 0\na_mm = 100\nmin_deg = -90\nmax_deg = 90\n"
        "velocity_rad_per_s = 1\nacceleration_rad_per_s2 = 4\njerk_rad_per_s3 = 40\n";
    write_file(folder / "arm.toml", "name = \"two joints\"\n" + joint + joint);
    std::string eyes;
    for (const char* const motor : {"tilt", "pan_right", "pan_left"}) {
      eyes += std::string("[eyes.") + motor + "]\nstep_line = \"" + motor + "-step\"\ndirection_line = \"" +
              motor + "-dir\"\n";
    }
    write_file(
        folder / "robot.toml",
        "rig = \"rig.toml\"\nmodel = \"model\"\nsearch = \"search.toml\"\narm = \"arm.toml\"\n"
        "[can]\ninterface = \"vergence-none\"\n"
        "[[can.axis]]\nnode = 1\ncounts_per_turn = 1000000\n[[can.axis]]\nnode = 2\ncounts_per_turn = "
        "1000000\n"
        "[cameras]\ngive_up_ms = 200\n"
        "[cameras.left]\ndevice = \"/dev/vergence-none-left\"\n"
        "[cameras.right]\ndevice = \"/dev/vergence-none-right\"\n"
        "[eyes]\nstep_chip = \"vergence-none\"\nenable_chip = \"vergence-none\"\nenable_line = \"enable\"\n"
        "steps_per_turn = 6000\nvelocity_rad_per_s = 1\nacceleration_rad_per_s2 = 10\n" +
            eyes + "[runtime]\ncommand_socket = \"" + (folder / "no/command").string() +
            "\"\nblack_box = \"" + (folder / "nor/box").string() + "\"\n");
  }
  [[nodiscard]] CommandResult run(const std::string& options = "") const {
    return run_vergence("bringup --config " + (folder / "robot.toml").string() + " --seconds 0.1 " + options +
                        " </dev/null");
  }
  [[nodiscard]] nlohmann::json findings() const {
    return nlohmann::json::parse(read_file(folder / "f.json"));
  }

  TempDirectory folder;
};

TEST_F(Bringup, WithoutDevicesFailsWithAWholeTable) {
  const CommandResult result = run("--json " + (folder / "f.json").string());
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_NE(result.output.find("not everything works"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(" failed, "), std::string::npos) << result.output;

  const nlohmann::json json = findings();
  std::set<std::string> groups;
  std::set<std::string> failed;
  std::size_t failures = 0;
  for (const nlohmann::json& finding : json["findings"]) {
    const std::string check = finding["group"].get<std::string>() + " " + finding["check"].get<std::string>();
    groups.insert(finding["group"]);
    // All of it is in the table; of many skipped alike the first and the last.
    if (finding["outcome"] != "skipped") {
      EXPECT_NE(result.output.find(finding["check"].get<std::string>()), std::string::npos) << check;
    }
    const bool passed = finding["outcome"] == "pass";
    EXPECT_EQ(passed, finding["remedy"].get<std::string>().empty()) << check;
    if (!passed) {
      EXPECT_NE(result.output.find(finding["remedy"].get<std::string>()), std::string::npos) << check;
    }
    if (finding["outcome"] != "fail") continue;
    failed.insert(check);
    ++failures;
  }
  EXPECT_EQ(groups, (std::set<std::string>{"files", "rt", "cameras", "can", "gpio"}));
  EXPECT_EQ(json["failed"], failures);
  for (const char* const check :
       {"files black box", "cameras left opens", "cameras right opens", "can interface"}) {
    EXPECT_TRUE(failed.contains(check)) << check << '\n' << result.output;
  }
}

TEST_F(Bringup, LooksOnlyAtWhatItIsAskedFor) {
  const CommandResult result = run("--only can --json " + (folder / "f.json").string());
  EXPECT_EQ(result.status, 1) << result.output;
  const nlohmann::json json = findings();
  EXPECT_FALSE(json["findings"].empty());
  for (const nlohmann::json& finding : json["findings"]) EXPECT_EQ(finding["group"], "can");
}

TEST_F(Bringup, PassesWithStatusZero) {
  fs::create_directory(folder / "no");
  fs::create_directory(folder / "nor");
  replace_in_file(folder / "robot.toml", "[can]\n", "[can]\npresent = false\n");
  replace_in_file(folder / "robot.toml", "arm = \"arm.toml\"\n", "");
  const CommandResult result = run("--only files,can");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("the configuration has no arm"), std::string::npos) << result.output;
}

TEST_F(Bringup, MovesNothingWithoutConfirmationOrWithoutLines) {
  const CommandResult unasked = run("--only gpio --move");
  EXPECT_EQ(unasked.status, 2) << unasked.output;
  EXPECT_NE(unasked.output.find("--yes"), std::string::npos) << unasked.output;
  const CommandResult confirmed = run("--only gpio --move --yes --json " + (folder / "f.json").string());
  EXPECT_EQ(confirmed.status, 1) << confirmed.output;
  int motors = 0;
  const nlohmann::json json = findings();
  for (const nlohmann::json& finding : json["findings"]) {
    if (finding["check"].get<std::string>().find(" moved") == std::string::npos) continue;
    ++motors;
    EXPECT_EQ(finding["outcome"], "skipped");
  }
  EXPECT_EQ(motors, 3);
}

TEST_F(Bringup, ABadConfigurationIsToldInTheTableWithStatusTwo) {
  fs::remove(folder / "rig.toml");
  const CommandResult result = run();
  EXPECT_EQ(result.status, 2) << result.output;
  for (const char* const word : {"rig.toml is not there", "gpio", "the configuration cannot be read"}) {
    EXPECT_NE(result.output.find(word), std::string::npos) << word << '\n' << result.output;
  }
}

TEST_F(Bringup, RefusesBadUsage) {
  expect_refusal("bringup", "--config");
  expect_refusal("bringup --config " + (folder / "none.toml").string(), "none.toml");
  const std::string good = "bringup --config " + (folder / "robot.toml").string();
  expect_refusal(good + " --only cameras,moon", "moon");
  expect_refusal(good + " --yes", "--move");
  expect_refusal(good + " --loopback LINE", "--move");
  expect_refusal(good + " --seconds 0", "--seconds");
  expect_refusal(good + " --seconds nan", "--seconds");
  expect_refusal(good + " --json " + (folder / "no/f.json").string(), "f.json");
}

}  // namespace
}  // namespace vergence::test
