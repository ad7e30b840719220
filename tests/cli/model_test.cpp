// `vergence model`: finds the target in its photo, and what it writes is a model that finds the target.
#include <algorithm>

#include "tests/cli/run_vergence.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::test {
namespace {

// A data set whose model was taken away, with its photos kept aside.
struct WithoutModel {
  WithoutModel() {
    write_small_photo_dataset(directory.path());
    std::filesystem::rename(directory / "model", directory / "photos");
  }
  [[nodiscard]] std::string arguments(const std::string& options = "") const {
    return "model " + (directory / "photos/photo.png").string() + " --background " +
           (directory / "photos/background.png").string() + " -o " + (directory / "model").string() +
           " --fx 400 " + options;
  }
  TempDirectory directory;
};

// Levels of noise a camera has, repeatable.
void add_noise(const std::filesystem::path& file, std::uint32_t seed) {
  tools::RgbImage image = tools::read_png_rgb(file);
  for (std::uint8_t& level : image.data) {
    seed = seed * 1664525U + 1013904223U;
    level = static_cast<std::uint8_t>(std::clamp(level + static_cast<int>((seed >> 24) % 9) - 4, 0, 255));
  }
  write_png(file, image);
}

TEST(Model, FindsTheCardDespiteNoise) {
  const WithoutModel data;
  add_noise(data.directory / "photos/photo.png", 1);
  add_noise(data.directory / "photos/background.png", 2);
  const CommandResult result = run_vergence(data.arguments());
  ASSERT_EQ(result.status, 0) << result.output;
  const tools::Target target = tools::read_target(data.directory / "model");
  EXPECT_NEAR(target.roi.x, 110, 2);
  EXPECT_NEAR(target.roi.y, 80, 2);
  EXPECT_NEAR(target.roi.width, 100, 3);
  EXPECT_NEAR(target.roi.height, 80, 3);
  EXPECT_EQ(target.camera.fx_px, 400);
  EXPECT_EQ(target.distance_mm, 400);
  ASSERT_TRUE(target.mask);
  EXPECT_EQ(result.output.find("warning"), std::string::npos) << result.output;  // the rim is no target
  EXPECT_EQ(tools::read_png_rgb(data.directory / "model/preview.png").width_px, 320);
  const CommandResult estimate = run_vergence("estimate " + data.directory.path().string());
  EXPECT_EQ(estimate.status, 0) << estimate.output;
  EXPECT_NE(estimate.output.find("tracked 3"), std::string::npos) << estimate.output;
}

TEST(Model, DoesNotTakeAShadowForTheTarget) {
  const WithoutModel data;
  tools::RgbImage photo = tools::read_png_rgb(data.directory / "photos/photo.png");
  for (int y = 160; y < 200; ++y) {
    for (int x = 120; x < 230; ++x) {
      for (int c = 0; c < 3; ++c) photo.at(x, y)[c] = static_cast<std::uint8_t>(photo.at(x, y)[c] * 7 / 10);
    }
  }
  write_png(data.directory / "photos/photo.png", photo);
  ASSERT_EQ(run_vergence(data.arguments()).status, 0);
  EXPECT_NEAR(tools::read_target(data.directory / "model").roi.height, 80, 3);
}

TEST(Model, TakesTheRectangleOrTheMaskGiven) {
  const WithoutModel data;
  ASSERT_EQ(run_vergence(data.arguments("--roi 100,70,120,100")).status, 0);
  EXPECT_EQ(tools::read_target(data.directory / "model").roi.x, 100);
  EXPECT_FALSE(tools::read_target(data.directory / "model").mask);
  tools::RgbImage mask(320, 240);
  for (int y = 90; y < 130; ++y) {
    for (int x = 120; x < 180; ++x) mask.at(x, y)[0] = mask.at(x, y)[1] = mask.at(x, y)[2] = 255;
  }
  const std::string file = (data.directory / "mask.png").string();
  write_png(file, mask);
  ASSERT_EQ(run_vergence(data.arguments("--mask " + file)).status, 0);
  const tools::Target target = tools::read_target(data.directory / "model");
  EXPECT_EQ(target.roi.x, 120);
  EXPECT_EQ(target.roi.width, 60);
  EXPECT_EQ(target.roi.height, 40);
}

TEST(Model, RefusesWhatMakesNoModel) {
  const WithoutModel data;
  const std::string photos = (data.directory / "photos").string();
  const std::string out = " -o " + (data.directory / "model").string();
  const std::string bare = photos + "/background.png";
  expect_refusal("model " + bare + " --background " + bare + out, "background.png", "nothing stands out",
                 "--roi");
  expect_refusal("model " + photos + "/none.png --background " + bare + out, "none.png", "no such image");
  expect_refusal(data.arguments("--roi 0,0,9999,10"), "--roi", "320 x 240");
  expect_refusal(data.arguments("--distance-mm 0"), "--distance-mm");

  tools::RgbImage small(64, 48);
  write_png(photos + "/small.png", small);
  expect_refusal("model " + photos + "/photo.png --background " + photos + "/small.png" + out, "small.png",
                 "64 x 48");

  tools::RgbImage grey(320, 240);
  grey.data.assign(grey.data.size(), 100);
  write_png(photos + "/grey.png", grey);
  expect_refusal("model " + photos + "/photo.png --background " + photos + "/grey.png" + out, "grey.png",
                 "no hue");

  // The card pushed over the edge.
  const tools::RgbImage photo = tools::read_png_rgb(photos + "/photo.png");
  tools::RgbImage shifted = tools::read_png_rgb(bare);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 200; ++x) std::copy(photo.at(x + 120, y), photo.at(x + 120, y) + 3, shifted.at(x, y));
  }
  write_png(photos + "/shifted.png", shifted);
  expect_refusal("model " + photos + "/shifted.png --background " + bare + out, "shifted.png", "edge",
                 "room");
}

}  // namespace
}  // namespace vergence::test
