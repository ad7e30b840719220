// Arms from TOML: the file of the PA-10 says what the code says, and what is wrong is named.
#include "tools/io/arm_file.hpp"

#include <gtest/gtest.h>

#include <string>

#include "algo/pa10.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

using test::TempDirectory;

TEST(ArmFile, OfThePa10SaysWhatTheCodeSays) {
  const SerialArm read = read_arm(VERGENCE_ARMS "/pa10.toml");
  const SerialArm arm = pa10();
  ASSERT_EQ(read.joints, arm.joints);
  EXPECT_EQ(read.held, arm.held);
  EXPECT_EQ(read.T_W_base.R, arm.T_W_base.R);
  EXPECT_EQ(read.T_flange_hand.R, arm.T_flange_hand.R);
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    EXPECT_DOUBLE_EQ(read.dh[i].a_mm, arm.dh[i].a_mm);
    EXPECT_DOUBLE_EQ(read.dh[i].d_mm, arm.dh[i].d_mm);
    EXPECT_DOUBLE_EQ(read.dh[i].alpha_rad, arm.dh[i].alpha_rad);
    EXPECT_DOUBLE_EQ(read.limits[i].min_rad, arm.limits[i].min_rad);
    EXPECT_DOUBLE_EQ(read.limits[i].max_rad, arm.limits[i].max_rad);
    EXPECT_DOUBLE_EQ(read.limits[i].velocity_rad_per_s, arm.limits[i].velocity_rad_per_s);
    EXPECT_DOUBLE_EQ(read.limits[i].acceleration_rad_per_s2, arm.limits[i].acceleration_rad_per_s2);
    EXPECT_DOUBLE_EQ(read.limits[i].jerk_rad_per_s3, arm.limits[i].jerk_rad_per_s3);
  }
}

struct Breakage {
  const char* name;
  const char* from;
  const char* to;
  const char* field;
};

void PrintTo(const Breakage& breakage, std::ostream* out) {
  *out << breakage.name;
}

class BrokenArm : public ::testing::TestWithParam<Breakage> {};

INSTANTIATE_TEST_SUITE_P(
    ArmFile, BrokenArm,
    ::testing::Values(Breakage{"UnknownKey", "held = true", "hold = true", "hold"},
                      Breakage{"SkewedBase", "-1, 0, 0, 0,\n  0, -1", "-1, 0, 0, 0,\n  0, -1.1", "T_W_base"},
                      Breakage{"EmptyRange", "min_deg = -177", "min_deg = 178", "joint[0].max_deg"},
                      Breakage{"NoVelocity", "velocity_rad_per_s = 1\n", "", "joint[0].velocity_rad_per_s"},
                      Breakage{"ZeroJerk", "jerk_rad_per_s3 = 40", "jerk_rad_per_s3 = 0", "jerk_rad_per_s3"},
                      Breakage{"LinkIsText", "d_mm = 317", "d_mm = \"317\"", "d_mm"},
                      Breakage{"LinkIsNan", "d_mm = 317", "d_mm = nan", "d_mm"}),
    [](const auto& of) { return of.param.name; });

TEST_P(BrokenArm, IsRefusedByFileAndField) {
  const TempDirectory directory;
  const auto file = directory / "arm.toml";
  std::filesystem::copy_file(VERGENCE_ARMS "/pa10.toml", file);
  test::replace_in_file(file, GetParam().from, GetParam().to);
  try {
    (void)read_arm(file);
    FAIL() << "was read";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("arm.toml"), std::string::npos) << message;
    EXPECT_NE(message.find(GetParam().field), std::string::npos) << message;
  }
}

TEST(ArmFile, OfEightJointsIsRefused) {
  const TempDirectory directory;
  const auto file = directory / "arm.toml";
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text +=
        "[[joint]]\nmin_deg = -1\nmax_deg = 1\nvelocity_rad_per_s = 1\nacceleration_rad_per_s2 = 1\n"
        "jerk_rad_per_s3 = 1\n";
  }
  test::write_file(file, text);
  EXPECT_THROW((void)read_arm(file), InputError);
}

}  // namespace
}  // namespace vergence::tools
