// The controller's configuration: good examples are good, every mistake is told with file, line and field,
// and an image that was not made here and now is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "firmware_like/config/config_fields.hpp"
#include "firmware_like/config/config_image.hpp"
#include "firmware_like/config/crc32.hpp"
#include "tests/support/random.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/config/read_config.hpp"
#include "tools/config/show_config.hpp"
#include "tools/io/input_error.hpp"

namespace vergence {
namespace {

namespace fs = std::filesystem;
using test::TempDirectory;
using testing::Random;
using tools::default_config;
using tools::read_config;

const fs::path kExamples = VERGENCE_EXAMPLES;

// A copy of the example with eyes whose robot.toml has one thing changed.
std::unique_ptr<ControllerConfig> read_changed(const std::string& from, const std::string& to,
                                               const char* of = "pa10_vergence") {
  const TempDirectory folder;
  fs::copy(kExamples / of, folder.path(), fs::copy_options::recursive);
  test::replace_in_file(folder / "robot.toml", from, to);
  return read_config(folder.path() / "robot.toml");
}

std::string complaint_of(const std::string& from, const std::string& to, const char* of = "pa10_vergence") {
  try {
    (void)read_changed(from, to, of);
  } catch (const tools::InputError& error) {
    return error.what();
  }
  return "none";
}

std::vector<std::byte> image_of(const ControllerConfig& config) {
  std::vector<std::byte> image(kMaxImageBytes);
  const ImageResult result = write_image(config, image);
  EXPECT_EQ(result.status, ImageStatus::kOk) << result.section << '.' << result.key << ' ' << result.problem;
  image.resize(result.bytes);
  return image;
}

std::unique_ptr<ControllerConfig> example() {
  return read_config(kExamples / "pa10_vergence" / "robot.toml");
}

ImageStatus status_of(const std::vector<std::byte>& image) {
  const auto config = std::make_unique<ControllerConfig>();
  return read_image(image, *config).status;
}

// Places in the header.
constexpr std::size_t kByteOrderAt = 8;
constexpr std::size_t kVersionAt = 12;
constexpr std::size_t kSettingsAt = 16;
constexpr std::size_t kBodyCrcAt = 24;
constexpr std::size_t kHeaderCrcAt = 28;
constexpr std::size_t kHeaderBytes = 32;

void put(std::vector<std::byte>& image, std::size_t at, std::uint32_t value) {
  std::memcpy(image.data() + at, &value, sizeof value);
}

// As somebody would who knows the format.
void sign(std::vector<std::byte>& image) {
  put(image, kBodyCrcAt, crc32(std::span(image).subspan(kHeaderBytes)));
  put(image, kHeaderCrcAt, crc32(std::span(image).first(kHeaderCrcAt)));
}

TEST(Crc32, IsTheOneOfEthernet) {
  const char* const digits = "123456789";
  const auto bytes = std::as_bytes(std::span(digits, 9));
  EXPECT_EQ(crc32(bytes), 0xCBF43926U);
  EXPECT_EQ(crc32(bytes.subspan(4), crc32(bytes.first(4))), 0xCBF43926U);
}

TEST(Config, ExamplesAreGood) {
  for (const char* const name : {"pa10_fixed_eyes", "pa10_vergence", "pa10_two_buses"}) {
    SCOPED_TRACE(name);
    const auto config = read_config(kExamples / name / "robot.toml");
    EXPECT_EQ(config->robot.arm.joints, 7);
    EXPECT_EQ(status_of(image_of(*config)), ImageStatus::kOk);
  }
}

TEST(Config, ShownIsReadAsTheSame) {
  const auto config = example();
  const TempDirectory folder;
  fs::copy(kExamples / "pa10_vergence", folder.path(), fs::copy_options::recursive);
  test::write_file(
      folder / "robot.toml",
      "rig = \"rig.toml\"\nmodel = \"model\"\nsearch = \"search.toml\"\n" + tools::show_config(*config));
  const auto again = read_config(folder.path() / "robot.toml");
  EXPECT_EQ(tools::show_config(*again), tools::show_config(*config));
}

struct Mistake {
  const char* from;
  const char* to;
  const char* where;
  const char* what;
};

TEST(Config, TellsEveryMistakeWithItsLineAndField) {
  const std::vector<Mistake> mistakes = {
      {"[control]", "[control]\nposition_per_ss = 3", "control.position_per_ss", "is not a known key"},
      {"[control]", "[contrl]\n[control]", "contrl", "is not a known key"},
      {"[control]", "[control]\nposition_per_s = 51", "control.position_per_s", "is outside its range"},
      {"[control]", "[control]\nposition_per_s = \"3\"", "control.position_per_s", "is not a number"},
      {"[control]", "[control]\nposition_per_s = nan", "control.position_per_s", "not a finite number"},
      {"[control]", "[control]\nseed = 1.5", "control.seed", "is not a whole number"},
      {"[control]", "[control]\nposition_only = 1.0", "control.position_only", "neither true nor false"},
      {"[control]", "[control]\ntarget_in_hand_e = [0.9, 0.9, 0]", "control.target_in_hand_e", "cannot be"},
      {"target_in_hand_mm = [0, -90, 545]", "target_in_hand_mm = [0, -90]", "control.target_in_hand_mm",
       "has 2 numbers"},
      {"box_max_mm = [-300", "box_max_mm = [-1300", "limits.box_max_mm", "is not above box_min_mm"},
      {"format = \"YUYV\"", "format = \"MJPG\"", "cameras.format", "one of YUYV, UYVY, NV12, RGB24"},
      {"/dev/v4l/by-path/pci-0000:00:14.0-usb-0:1:1.0-video-index0", "", "cameras.left", "device is not set"},
      {"interface = \"can0\"", "interface = \"a-name-that-is-too-long\"", "can.interface",
       "at most 15 bytes"},
      {"max_deg = 45", "max_deg = -50", "eyes.tilt", "min_deg is not below max_deg"},
      {"acceleration_rad_per_s2 = 25", "acceleration_rad_per_s2 = 31\njerk_rad_per_s3 = 0.1", "eyes.tilt",
       "jerk_rad_per_s3 is too low"},
      {"steps_per_turn = 16000", "steps_per_turn = 160000", "eyes.tilt", "more than max_rate_steps_per_s"},
      {"max_rate_steps_per_s = 4000", "max_rate_steps_per_s = 9000", "eyes.tilt",
       "make the step task more punctual"},
      {"acceleration_rad_per_s2 = 25", "acceleration_rad_per_s2 = 50", "eyes.tilt",
       "more than ramp_steps_per_s2"},
      {"[eyes.tilt]", "[eyes.tilt]\nlow_end = \"home\"", "eyes.tilt", "name its line"},
      {"node = 7", "node = 6", "can.axis", ""},
      {"node = 7", "node = 128", "can.axis[6].node", "from 1 to 127"},
      {"node = 7\n", "", "can.axis[6].node", "missing"},
      {"[[can.axis]]  # W2\nnode = 7\ncounts_per_turn = 1048576\n", "", "can.axis",
       "there are 6 but the arm has 7"},
      {"rig = \"rig.toml\"", "rig = \"rig.tml\"", "rig.tml", "no such file"},
      {"[control]", "[control", "line ", "not valid TOML"},
      {"interface = \"can0\"", "interface = \"can0\"\nbitrate_bit_per_s = 500000", "can.bitrate_bit_per_s",
       "more than 80 %"},
  };
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.to);
    const std::string complaint = complaint_of(mistake.from, mistake.to);
    EXPECT_NE(complaint.find(mistake.where), std::string::npos) << complaint;
    EXPECT_NE(complaint.find(mistake.what), std::string::npos) << complaint;
    EXPECT_NE(complaint.find(".t"), std::string::npos) << complaint;  // a file's name
  }
}

TEST(Config, TwoBusesAt1kHzAreTheExamples) {
  const auto config = read_config(kExamples / "pa10_two_buses" / "robot.toml");
  EXPECT_STREQ(config->can.interface_of(0), "can0");
  EXPECT_STREQ(config->can.interface_of(1), "can1");
  EXPECT_EQ(config->robot.arm_period_ns, 1'000'000);
  EXPECT_EQ(config->can.arm.sync_period_ns, 1'000'000);
  EXPECT_TRUE(config->can.arm.share_targets);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(config->can.arm.axis[i].bus, i < 4 ? 0 : 1) << i;
  EXPECT_EQ(tools::bus_loads(*config),
            (std::vector<std::string>{"bus 1, can0: 4 axes at 1000 Hz, loaded by 72.4 % at worst",
                                      "bus 2, can1: 3 axes at 1000 Hz, loaded by 58.5 % at worst"}));
  const std::string shown = tools::show_config(*config);
  for (const std::string& load : tools::bus_loads(*config)) {
    EXPECT_NE(shown.find("# " + load), std::string::npos) << load;
  }
  // In the image as in the text.
  const auto again = std::make_unique<ControllerConfig>();
  ASSERT_EQ(read_image(image_of(*config), *again).status, ImageStatus::kOk);
  EXPECT_EQ(tools::show_config(*again), shown);
  EXPECT_EQ(again->can.arm.sync_period_ns, 1'000'000);
}

// Files of one bus, as they always were, mean what they did.
TEST(Config, WithoutAWordOfASecondBusThereIsOneAt500Hz) {
  const auto config = example();
  EXPECT_EQ(config->robot.arm_period_ns, 2'000'000);
  EXPECT_EQ(config->can.arm.sync_period_ns, 2'000'000);
  EXPECT_EQ(canopen::bus_count(config->can.arm), 1);
  EXPECT_EQ(tools::bus_loads(*config),
            (std::vector<std::string>{"bus 1, can0: 7 axes at 500 Hz, loaded by 72.3 % at worst"}));
}

TEST(Config, TellsEveryMistakeWithTwoBuses) {
  const std::vector<Mistake> mistakes = {
      {"share_targets = true\n", "", "line 69: can.bitrate_bit_per_s",
       "first bus would be loaded by more than"},
      {"share_targets = true\n", "", "share_targets = true",
       "bus 1, can0: 4 axes at 1000 Hz, loaded by 83.4 %"},
      {"node = 1\nbus = 1\ncounts_per_turn = 1048576\n\n[[can.axis]]  # S2\nnode = 2\nbus = 1",
       "node = 1\nbus = 2\ncounts_per_turn = 1048576\n\n[[can.axis]]  # S2\nnode = 2\nbus = 2",
       "can.bitrate_bit_per_s",
       "second bus would be loaded by more than 80 %: take a faster one, period_ms = 2"},
      {"interface_2 = \"can1\"\n", "", "can.axis[4].bus", "is 2, but there is one bus"},
      {"interface_2 = \"can1\"", "interface_2 = \"can0\"", "line 71: can.interface_2", "the two must differ"},
      {"period_ms = 1", "period_ms = 3", "can.period_ms", "from 1 to 2"},
      {"period_ms = 1", "period_ms = 1.5", "can.period_ms", "is not a whole number"},
      {"bus = 1\n", "bus = 3\n", "can.axis[0].bus", "from 1 to 2"},
      {"node = 6\n", "node = 5\n", "can.axis", "two nodes of a bus have the same id"},
  };
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.to);
    const std::string complaint = complaint_of(mistake.from, mistake.to, "pa10_two_buses");
    EXPECT_NE(complaint.find(mistake.where), std::string::npos) << complaint;
    EXPECT_NE(complaint.find(mistake.what), std::string::npos) << complaint;
    EXPECT_NE(complaint.find("robot.toml"), std::string::npos) << complaint;
  }
  const std::string unused =
      complaint_of("interface = \"can0\"", "interface = \"can0\"\ninterface_2 = \"can1\"");
  EXPECT_NE(unused.find("can.interface_2: no axis is on it"), std::string::npos) << unused;
  // The same node on both is no mistake.
  EXPECT_EQ(complaint_of("node = 6\n", "node = 1\n", "pa10_two_buses"), "none");
}

TEST(Config, ARobotMayHaveNoArmAndNoEyes) {
  const auto no_arm = read_changed("[can]", "[can]\npresent = false");
  EXPECT_EQ(status_of(image_of(*no_arm)), ImageStatus::kOk);
  const auto no_eyes = read_changed("[eyes]", "[eyes]\npresent = false");
  EXPECT_EQ(status_of(image_of(*no_eyes)), ImageStatus::kOk);
}

TEST(Config, SharedSettingsAreForAllAndOwnOnesGoBefore) {
  const auto config = read_changed("[cameras.left]", "stall_ms = 300\n[cameras.left]\nstall_ms = 400");
  EXPECT_EQ(config->cameras.eyes[0].stall_ns, 400'000'000);
  EXPECT_EQ(config->cameras.eyes[1].stall_ns, 300'000'000);
}

TEST(Config, WritesATableOfAllSettings) {
  const std::string table = tools::describe_settings();
  for (const ConfigSection& section : config_sections()) {
    for (const ConfigField& field : section.fields) {
      EXPECT_NE(table.find(std::string("| `") + field.key + "` |"), std::string::npos) << field.key;
      EXPECT_GT(std::strlen(field.meaning), 0U) << field.key;
    }
  }
}

TEST(ConfigFields, DefaultsAreInRange) {
  const auto config = default_config();
  for (const ConfigSection& section : config_sections()) {
    if (section.list > 0) continue;  // those have none
    for (int i = 0; i < section.count(); ++i) {
      for (const ConfigField& field : section.fields) {
        if (field.kind == FieldKind::kText) continue;
        for (int element = 0; element < field.count; ++element) {
          EXPECT_TRUE(is_in_range(field, field.get(*config, {i, element})))
              << section.name << '.' << field.key;
        }
      }
    }
  }
}

// Whatever may be set comes back as it was.
TEST(ConfigImage, KeepsEverySetting) {
  Random random(11);
  const auto config = example();
  for (int trial = 0; trial < 50; ++trial) {
    for (const ConfigSection& section : config_sections()) {
      const auto& fields = section.fields;
      const ConfigField& field =
          fields[static_cast<std::size_t>(random.below(static_cast<int>(fields.size())))];
      if (field.kind == FieldKind::kText) continue;
      const Place place{random.below(section.count()), random.below(field.count)};
      double written = random.between(field.low, field.high);
      if (field.kind != FieldKind::kNumber) written = std::floor(written);
      if (std::string_view(field.key) != "target_in_hand_e") field.set(*config, place, written * field.scale);
    }
    const std::vector<std::byte> image = image_of(*config);
    const auto again = std::make_unique<ControllerConfig>();
    const ImageResult result = read_image(image, *again);
    // Settings drawn at random seldom go together; that is found after all were read.
    ASSERT_TRUE(result.status == ImageStatus::kOk || result.status == ImageStatus::kBadValue);
    EXPECT_EQ(image_of(*again), image);
  }
}

TEST(ConfigImage, IsTheSameForTheSameConfiguration) {
  EXPECT_EQ(image_of(*example()), image_of(*example()));
}

TEST(ConfigImage, RefusesWhateverWasCutOrChanged) {
  const std::vector<std::byte> image = image_of(*example());
  ASSERT_EQ(status_of(image), ImageStatus::kOk);
  Random random(3);
  for (std::size_t size = 0; size < image.size(); size += size < 64 ? 1 : 997) {
    EXPECT_NE(status_of({image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size)}),
              ImageStatus::kOk);
  }
  std::vector<std::byte> longer = image;
  longer.push_back(std::byte{0});
  EXPECT_EQ(status_of(longer), ImageStatus::kWrongSize);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<std::byte> changed = image;
    const std::size_t at = trial < 32
                               ? static_cast<std::size_t>(trial)
                               : static_cast<std::size_t>(random.below(static_cast<int>(image.size())));
    changed[at] ^= static_cast<std::byte>(1 << random.below(8));
    EXPECT_NE(status_of(changed), ImageStatus::kOk) << at;
  }
}

TEST(ConfigImage, SaysWhatItIsNot) {
  const std::vector<std::byte> image = image_of(*example());
  const auto forged = [&](std::size_t at, std::uint32_t value) {
    std::vector<std::byte> changed = image;
    put(changed, at, value);
    sign(changed);
    return status_of(changed);
  };
  EXPECT_EQ(forged(0, 0), ImageStatus::kNotAnImage);
  EXPECT_EQ(forged(kByteOrderAt, 0x04030201), ImageStatus::kWrongByteOrder);
  EXPECT_EQ(forged(kVersionAt, kImageVersion - 1), ImageStatus::kOtherVersion);
  EXPECT_EQ(forged(kVersionAt, kImageVersion + 1), ImageStatus::kOtherVersion);
  EXPECT_EQ(forged(kSettingsAt, 12345), ImageStatus::kOtherSettings);
  EXPECT_EQ(status_of({}), ImageStatus::kTruncated);
}

// With a right check sum, whatever the bytes are: refused, or as good as any configuration; never a crash.
TEST(ConfigImage, JudgesEveryValueAgain) {
  const std::vector<std::byte> image = image_of(*example());
  std::vector<std::byte> changed = image;
  const double beyond = 51;  // control.position_per_s comes first, after the number of axes
  std::memcpy(changed.data() + kHeaderBytes + sizeof(int), &beyond, sizeof beyond);
  sign(changed);
  const auto config = std::make_unique<ControllerConfig>();
  const ImageResult result = read_image(changed, *config);
  EXPECT_EQ(result.status, ImageStatus::kBadValue);
  EXPECT_STREQ(result.section, "control");
  EXPECT_STREQ(result.key, "position_per_s");
  Random random(5);
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    changed = image;
    for (int k = 0; k < 4; ++k) {
      const int at = random.below(static_cast<int>(image.size() - kHeaderBytes));
      changed[kHeaderBytes + static_cast<std::size_t>(at)] = static_cast<std::byte>(random.below(256));
    }
    sign(changed);
    const ImageResult judged = read_image(changed, *config);
    refused += judged.status == ImageStatus::kBadValue ? 1 : 0;
    // Another number of axes, or another kind of target, is another length.
    ASSERT_TRUE(judged.status == ImageStatus::kOk || judged.status == ImageStatus::kBadValue ||
                judged.status == ImageStatus::kWrongSize);
  }
  EXPECT_GT(refused, 0);
}

TEST(ConfigImage, NeedsItsRoom) {
  const auto config = example();
  std::vector<std::byte> room(1000);
  EXPECT_EQ(write_image(*config, room).status, ImageStatus::kTooSmall);
  EXPECT_EQ(write_image(*config, std::span(room).first(10)).status, ImageStatus::kTooSmall);
}

}  // namespace
}  // namespace vergence
