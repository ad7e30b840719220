// The silhouette of a photo's target: of a mask, of a photo of the bare background, or of the plain
// surroundings alone; always with a rim; and none where nothing tells.
#include "tools/io/silhouette.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "tests/support/small_dataset.hpp"
#include "tools/io/dataset.hpp"

namespace vergence::tools {
namespace {

constexpr Rectangle kRoi{90, 60, 140, 110};

bool in_oval(int x, int y) {
  const double u = (x - 160) / 55.0;
  const double v = (y - 115) / 40.0;
  return u * u + v * v < 1;
}

// Repeatable noise of +-3 levels.
int noise(int x, int y, int c) {
  const std::uint32_t n = (static_cast<std::uint32_t>(x) * 73856093U) ^
                          (static_cast<std::uint32_t>(y) * 19349663U) ^
                          (static_cast<std::uint32_t>(c) * 83492791U);
  return static_cast<int>((n * 2654435761U) >> 29U) - 3;
}

// A blue wall, brighter towards the right and below; and an oval of many colours before it.
RgbImage photo(bool with_target, double things = 0) {
  RgbImage image(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double lit = 0.8 + 0.3 * x / 320 + 0.2 * y / 240;
      const std::uint8_t target[3] = {static_cast<std::uint8_t>(120 + 100 * ((x / 8) % 2)),
                                      static_cast<std::uint8_t>(60 + 60 * ((y / 8) % 3)), 50};
      const bool on_target = with_target && in_oval(x, y);
      const bool on_thing = things > 0 && (x / 40 + y / 40) % 2 == 0 && !on_target;
      const double wall[3] = {on_thing ? 60 + 120 * things : 60, 100, on_thing ? 150 - 90 * things : 150};
      for (int c = 0; c < 3; ++c) {
        const double level = on_target ? target[c] : lit * wall[c];
        image.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(level + noise(x, y, c), 0.0, 255.0));
      }
    }
  }
  return image;
}

constexpr double kWallHue_deg = 213;

// Pixels that are wrongly in or out, over those of the oval.
double wrong_share(const GreyImage& silhouette) {
  int wrong = 0;
  int all = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const bool is = silhouette.data[static_cast<std::size_t>(y * 320 + x)] != 0;
      wrong += is != in_oval(x, y) ? 1 : 0;
      all += in_oval(x, y) ? 1 : 0;
    }
  }
  return static_cast<double>(wrong) / all;
}

TEST(Silhouette, IsWhatDiffersFromTheBareBackground) {
  const auto silhouette = silhouette_before(photo(false), photo(true), kRoi);
  ASSERT_TRUE(silhouette);
  EXPECT_LT(wrong_share(silhouette->target), 0.05);
}

TEST(Silhouette, IsWhatDiffersFromPlainSurroundings) {
  const auto silhouette = silhouette_before_plain(kWallHue_deg, photo(true), kRoi);
  ASSERT_TRUE(silhouette);
  EXPECT_LT(wrong_share(silhouette->target), 0.05);
}

TEST(Silhouette, IsNotKnownBeforeSurroundingsThatAreNotPlainOrOfAnotherHue) {
  EXPECT_FALSE(silhouette_before_plain(kWallHue_deg, photo(true, 1), kRoi));
  EXPECT_FALSE(silhouette_before_plain(kWallHue_deg, photo(true, 0.3), kRoi));
  EXPECT_FALSE(silhouette_before_plain(kWallHue_deg + 60, photo(true), kRoi));
  EXPECT_FALSE(silhouette_before_plain(kWallHue_deg, photo(true), {2, 2, 316, 236}));  // nothing around it
  EXPECT_FALSE(silhouette_before_plain(kWallHue_deg, photo(false), kRoi));             // nothing there
  EXPECT_FALSE(silhouette_before(photo(true), photo(true), kRoi));
  EXPECT_FALSE(silhouette_before(RgbImage(64, 48), photo(true), kRoi));
}

TEST(Silhouette, HasARimWithinTheRectangle) {
  GreyImage mask{320, 240, std::vector<std::uint8_t>(320 * 240, 0)};
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      mask.data[static_cast<std::size_t>(y * 320 + x)] = in_oval(x, y) || x < 20 ? 1 : 0;
    }
  }
  const Silhouette silhouette = with_rim(mask, kRoi);
  EXPECT_EQ(wrong_share(silhouette.target), 0);  // what is beside the rectangle is gone
  const int rim_px = static_cast<int>(0.12 * 0.5 * (kRoi.width + kRoi.height));
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const bool in_roi = x >= kRoi.x && x < kRoi.x + kRoi.width && y >= kRoi.y && y < kRoi.y + kRoi.height;
      bool near = false;
      for (int v = -rim_px; v <= rim_px && !near; ++v) {
        for (int u = -rim_px; u <= rim_px && !near; ++u) {
          near = u * u + v * v <= rim_px * rim_px && in_oval(x + u, y + v);
        }
      }
      ASSERT_EQ(silhouette.with_rim.data[static_cast<std::size_t>(y * 320 + x)] != 0, near && in_roi)
          << x << ' ' << y;
    }
  }
}

// The same model, whichever way the silhouette is known.
TEST(Silhouette, OfADatasetComesFromMaskBackgroundOrSurroundings) {
  const test::TempDirectory directory;
  test::write_small_photo_dataset(directory.path());
  const auto model = directory / "model";
  write_png(model / "photo.png", photo(true));
  write_png(model / "background.png", photo(false));
  RgbImage mask(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) std::fill_n(mask.at(x, y), 3, in_oval(x, y) ? 255 : 0);
  }
  write_png(model / "mask.png", mask);
  test::replace_in_file(model / "model.toml", "roi = [110, 80, 100, 80]", "roi = [90, 60, 140, 110]");
  const auto points_of_target = [&] {
    const Target target = read_target(model);
    EXPECT_TRUE(target.silhouette);
    const auto photo_model = std::make_unique<PhotoModel>();
    EXPECT_EQ(build_photo_model(target.source(), {}, {}, *photo_model), Status::kOk);
    EXPECT_TRUE(photo_model->masked);
    int count = 0;
    for (int i = 0; i < photo_model->inner; ++i) count += photo_model->weight[static_cast<unsigned>(i)];
    EXPECT_LT(count, photo_model->inner - 100);  // the rim
    return static_cast<double>(count) / photo_model->inner;
  };
  const double by_background = points_of_target();
  test::replace_in_file(model / "model.toml", "background = \"background.png\"",
                        "background_hue_deg = 213.0");
  EXPECT_NEAR(points_of_target(), by_background, 0.03);
  test::replace_in_file(model / "model.toml", "[photo]\n", "[photo]\nmask = \"mask.png\"\n");
  EXPECT_NEAR(points_of_target(), by_background, 0.03);
  // The thesis takes what the mask marks, or the rectangle, as it is.
  const Target target = read_target(model);
  EXPECT_EQ(target.source(TargetArea::kRectangle).mask, target.mask->data.data());
  EXPECT_EQ(target.source(TargetArea::kRectangle).target, nullptr);
}

}  // namespace
}  // namespace vergence::tools
