// What the controller reads and writes: every verdict on it, and that looking finds what is there.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "firmware_like/daemon/black_box.hpp"
#include "tests/support/findings.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/bringup/file_checks.hpp"
#include "tools/bringup/look_at_files.hpp"

namespace vergence::tools {
namespace {

using testing::expect_all_pass;
using testing::expect_complete;
using testing::expect_finding;
using Controller = FileObservation::Controller;

FileObservation sound_files() {
  FileObservation seen;
  seen.config = "robot.toml";
  seen.parts = {{"rig", "rig.toml", true}, {"model", "model/model.toml", true}};
  seen.image_bytes = 1000;
  seen.box_folder = {"/var/lib/vergence", true, true};
  seen.box_free_bytes = std::uint64_t{1} << 40;
  seen.socket_folder = {"/run/vergence", true, true};
  return seen;
}

TEST(BringupFiles, PassWhereAllIsThere) {
  const auto findings = judge(sound_files());
  expect_complete(findings);
  expect_all_pass(findings);
}

TEST(BringupFiles, AnImageHoldsItsParts) {
  FileObservation seen = sound_files();
  seen.is_image = true;
  seen.parts.clear();
  const auto findings = judge(seen);
  expect_all_pass(findings);
  expect_finding(findings, "rig, model, search, arm", Outcome::kPass, "in the image");
}

TEST(BringupFiles, AnUnreadableConfigurationFailsAndTheRestIsSkipped) {
  FileObservation seen = sound_files();
  seen.config_problem = "robot.toml: rig: missing";
  const auto findings = judge(seen);
  expect_complete(findings);
  expect_finding(findings, "configuration", Outcome::kFail, "rig: missing", "config check");
  for (const char* const check : {"image", "black box", "command socket", "vergenced"}) {
    expect_finding(findings, check, Outcome::kSkipped);
  }
}

TEST(BringupFiles, SayWhatIsMissing) {
  FileObservation seen = sound_files();
  seen.parts[1].exists = false;
  seen.image_problem = "can.axis: out of its range";
  seen.socket_folder.exists = false;
  const auto findings = judge(seen);
  expect_complete(findings);
  expect_finding(findings, "rig", Outcome::kPass);
  expect_finding(findings, "model", Outcome::kFail, "model/model.toml is not there", "copy it");
  expect_finding(findings, "image", Outcome::kFail, "can.axis", "config build");
  expect_finding(findings, "command socket", Outcome::kWarn, "/run/vergence", "sudo install -d");
}

TEST(BringupFiles, TheBlackBoxNeedsAFolderRoomAndAName) {
  FileObservation seen = sound_files();
  seen.box_folder.exists = false;
  expect_finding(judge(seen), "black box", Outcome::kFail, "is not there", "sudo install -d");
  seen.box_folder = {"/var/lib/vergence", true, false};
  expect_finding(judge(seen), "black box", Outcome::kWarn, "not ours to write", "ls -ld");
  seen.box_folder.is_writable = true;
  seen.box_free_bytes = kBoxFileBytes - 1;
  expect_finding(judge(seen), "black box", Outcome::kFail, "MiB free", "make room");
  seen.box_free_bytes = kBoxFileBytes;
  expect_finding(judge(seen), "black box", Outcome::kPass);
  seen.boxes = BlackBoxFile::kMostFiles;
  expect_finding(judge(seen), "black box", Outcome::kFail, "8 of 8", "move the old boxes");
}

TEST(BringupFiles, ARunningControllerHoldsTheDevices) {
  FileObservation seen = sound_files();
  seen.controller = Controller::kRuns;
  expect_finding(judge(seen), "vergenced", Outcome::kFail, "runs", "systemctl stop");
  seen.controller = Controller::kUnknown;
  expect_finding(judge(seen), "vergenced", Outcome::kWarn, "", "group");
}

// A configuration of a marker without arm and eyes, whose folders are in the same place.
class LookAtFiles : public ::testing::Test {
 protected:
  LookAtFiles() {
    test::write_small_marker_dataset(folder.path());
    write_config(folder.path() / "socket", folder.path() / "box");
  }
  void write_config(const std::filesystem::path& socket, const std::filesystem::path& box) const {
    test::write_file(folder / "robot.toml",
                     "rig = \"rig.toml\"\nmodel = \"model\"\nsearch = \"search.toml\"\n"
                     "[can]\npresent = false\n[eyes]\npresent = false\n"
                     "[cameras]\ndevice = \"/dev/none\"\n[runtime]\ncommand_socket = \"" +
                         socket.string() + "\"\nblack_box = \"" + box.string() + "\"\n");
  }
  [[nodiscard]] ConfigLook look() const { return look_at_files(folder / "robot.toml"); }

  test::TempDirectory folder;
};

TEST_F(LookAtFiles, FindsASoundOneSound) {
  const ConfigLook found = look();
  ASSERT_NE(found.config, nullptr) << found.seen.config_problem;
  EXPECT_FALSE(found.config->robot.has_arm);
  ASSERT_EQ(found.seen.parts.size(), 3U);
  EXPECT_GT(found.seen.image_bytes, 1000U);
  EXPECT_EQ(found.seen.boxes, 0);
  expect_all_pass(judge(found.seen));
}

TEST_F(LookAtFiles, CountsBoxes) {
  for (int i = 1; i <= 8; ++i) test::write_file(folder / ("box." + std::to_string(i)), "");
  expect_finding(judge(look().seen), "black box", Outcome::kFail, "8 of 8");
}

TEST_F(LookAtFiles, NamesTheFileThatIsMissing) {
  std::filesystem::remove(folder / "search.toml");
  const ConfigLook found = look();
  EXPECT_EQ(found.config, nullptr);
  const auto findings = judge(found.seen);
  expect_complete(findings);
  expect_finding(findings, "search", Outcome::kFail, "is not there");
  expect_finding(findings, "rig", Outcome::kPass);
}

TEST_F(LookAtFiles, ConfigurationThatIsNotThere) {
  const ConfigLook found = look_at_files(folder / "none.toml");
  EXPECT_EQ(found.config, nullptr);
  expect_finding(judge(found.seen), "configuration", Outcome::kFail, "none.toml");
}

TEST_F(LookAtFiles, SeesFoldersThatAreNotThere) {
  write_config(folder / "no/socket", folder / "nor/box");
  const auto findings = judge(look().seen);
  expect_finding(findings, "black box", Outcome::kFail, "nor is not there");
  expect_finding(findings, "command socket", Outcome::kWarn, "no is not there");
}

TEST_F(LookAtFiles, SeesAControllerThatListens) {
  EXPECT_EQ(look().seen.controller, Controller::kStopped);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = (folder / "socket").string();
  std::copy(path.begin(), path.end(), address.sun_path);
  const int listening = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(look().seen.controller, Controller::kStopped);  // its socket is there, and nobody listens
  ASSERT_EQ(::listen(listening, 1), 0);
  EXPECT_EQ(look().seen.controller, Controller::kRuns);
  ::close(listening);
}

}  // namespace
}  // namespace vergence::tools
