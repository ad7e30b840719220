// Whole planes, on every instruction set this machine has, against the codes of single pixels.
#include "algo/hue_plane.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <memory>
#include <ostream>
#include <vector>

#include "algo/rm_ga.hpp"
#include "tests/differential/every_target.hpp"

namespace vergence {

// Names the cases.
static void PrintTo(const HueLimits& limits, std::ostream* out) {
  *out << "dark_below_" << limits.dark_below << "_bright_from_" << limits.bright_from << "_permille_"
       << limits.min_saturation_permille;
}

namespace {

struct Planes {
  YuvHueTable table;
  HuePlane plane;
};

std::vector<std::uint8_t> random_bytes(std::size_t count, std::uint64_t seed) {
  CounterRandom random(seed, 0);
  std::vector<std::uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
  return bytes;
}

class HuePlaneTest : public ::testing::TestWithParam<HueLimits> {};

INSTANTIATE_TEST_SUITE_P(Limits, HuePlaneTest,
                         ::testing::Values(HueLimits{}, kThesisHueLimits, HueLimits{30, 200, 400}));

TEST_P(HuePlaneTest, RgbEqualsScalarForAllColours) {
  const auto planes = std::make_unique<Planes>();
  constexpr int kWidth = 1024;
  constexpr int kHeight = 1024;
  std::vector<std::uint8_t> rgb(std::size_t{3} * kWidth * kHeight);
  for_every_target([&] {
    for (int part = 0; part < 16; ++part) {
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const int colour = part * kWidth * kHeight + i;
        for (int c = 0; c < 3; ++c)
          rgb[static_cast<std::size_t>(3 * i + c)] = static_cast<std::uint8_t>(colour >> (16 - 8 * c));
      }
      const ImageView image{rgb.data(), kWidth, kHeight, 3 * kWidth, PixelFormat::kRgb24, nullptr, 0};
      ASSERT_EQ(make_hue_plane(image, GetParam(), planes->table, planes->plane), Status::kOk);
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const std::uint8_t* p = &rgb[static_cast<std::size_t>(3 * i)];
        ASSERT_EQ(planes->plane.code[static_cast<std::size_t>(i)], hue_code_rgb(p[0], p[1], p[2], GetParam()))
            << int{p[0]} << " " << int{p[1]} << " " << int{p[2]};
      }
      ASSERT_EQ(planes->plane.code[kWidth * kHeight], kHueOutside);
    }
  });
}

// All 2^24 values in blocks of 2 x 2 pixels, four Y of one U V each, so that all three formats can hold them.
TEST_P(HuePlaneTest, YuvEqualsScalarForAllValuesInEveryFormat) {
  const auto planes = std::make_unique<Planes>();
  planes->table.build(GetParam());
  constexpr int kSize = 1024;
  constexpr int kBlocksInRow = kSize / 2;
  constexpr int kBlocks = kBlocksInRow * kBlocksInRow;
  constexpr std::size_t kPixels = std::size_t{kSize} * kSize;
  std::vector<std::uint8_t> yuyv(2 * kPixels), uyvy(2 * kPixels), luma(kPixels), chroma(kPixels / 2);
  std::vector<std::uint8_t> expected(kPixels);
  for (int part = 0; part < 16; ++part) {
    for (int block = 0; block < kBlocks; ++block) {
      const int number = part * kBlocks + block;
      const int u = number >> 14;
      const int v = (number >> 6) & 0xFF;
      for (int i = 0; i < 4; ++i) {
        const int y = 4 * (number & 63) + i;
        const int row = 2 * (block / kBlocksInRow) + i / 2;
        const int column = 2 * (block % kBlocksInRow) + i % 2;
        const auto at = static_cast<std::size_t>(row * kSize + column);
        luma[at] = yuyv[2 * at] = uyvy[2 * at + 1] = static_cast<std::uint8_t>(y);
        yuyv[2 * at + 1] = uyvy[2 * at] = static_cast<std::uint8_t>(i % 2 == 0 ? u : v);
        chroma[static_cast<std::size_t>(2 * block + i % 2)] = static_cast<std::uint8_t>(i % 2 == 0 ? u : v);
        expected[at] = planes->table.code(y, u, v);
      }
    }
    for_every_target([&] {
      for (const ImageView& image :
           {ImageView{yuyv.data(), kSize, kSize, 2 * kSize, PixelFormat::kYuyv, nullptr, 0},
            ImageView{uyvy.data(), kSize, kSize, 2 * kSize, PixelFormat::kUyvy, nullptr, 0},
            ImageView{luma.data(), kSize, kSize, kSize, PixelFormat::kNv12, chroma.data(), kSize}}) {
        ASSERT_EQ(make_hue_plane(image, GetParam(), planes->table, planes->plane), Status::kOk);
        const auto differs = std::mismatch(expected.begin(), expected.end(), planes->plane.code.begin());
        ASSERT_EQ(differs.first, expected.end()) << "format " << static_cast<int>(image.format) << ", part "
                                                 << part << ", pixel " << differs.first - expected.begin();
      }
    });
  }
}

TEST_P(HuePlaneTest, EveryFormatWidthAndStrideEqualsScalar) {
  const auto planes = std::make_unique<Planes>();
  planes->table.build(GetParam());
  for_every_target([&] {
    for (const int width : {1, 2, 3, 6, 15, 16, 17, 30, 31, 33, 62, 63, 64, 65, 66, 98, 126, 127, 322, 323}) {
      const int height = 5;
      const std::size_t stride = static_cast<std::size_t>(width) * 3 + 5;
      const auto bytes = random_bytes(stride * 16, static_cast<std::uint64_t>(width));
      const std::uint8_t* chroma = bytes.data() + stride * 8;
      for (const PixelFormat format :
           {PixelFormat::kRgb24, PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12}) {
        if (width % 2 != 0 && format != PixelFormat::kRgb24) continue;
        const ImageView image{bytes.data(), width, height, stride, format, chroma, stride};
        ASSERT_EQ(make_hue_plane(image, GetParam(), planes->table, planes->plane), Status::kOk);
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            const std::uint8_t* row = bytes.data() + stride * static_cast<std::size_t>(y);
            const std::uint8_t* uv = chroma + stride * static_cast<std::size_t>(y / 2) + (x & ~1);
            const std::uint8_t* pair = row + 2 * (x & ~1);
            std::uint8_t expected = 0;
            switch (format) {
              case PixelFormat::kRgb24:
                expected = hue_code_rgb(row[3 * x], row[3 * x + 1], row[3 * x + 2], GetParam());
                break;
              case PixelFormat::kYuyv: expected = planes->table.code(row[2 * x], pair[1], pair[3]); break;
              case PixelFormat::kUyvy: expected = planes->table.code(row[2 * x + 1], pair[0], pair[2]); break;
              case PixelFormat::kNv12: expected = planes->table.code(row[x], uv[0], uv[1]); break;
            }
            ASSERT_EQ(planes->plane.code[static_cast<std::size_t>(y * width + x)], expected)
                << static_cast<int>(format) << " at " << x << " " << y << " of width " << width;
          }
        }
        for (int i = 0; i < kHuePadding; ++i) {
          ASSERT_EQ(planes->plane.code[static_cast<std::size_t>(width * height + i)], kHueOutside) << i;
        }
      }
    }
  });
}

TEST(HuePlane, RefusesWhatIsNotAnImage) {
  const auto planes = std::make_unique<Planes>();
  const std::vector<std::uint8_t> bytes(4096);
  const ImageView rgb{bytes.data(), 5, 4, 15, PixelFormat::kRgb24, nullptr, 0};
  const ImageView yuyv{bytes.data(), 6, 4, 12, PixelFormat::kYuyv, nullptr, 0};
  const ImageView nv12{bytes.data(), 6, 5, 6, PixelFormat::kNv12, bytes.data() + 64, 6};
  const auto status = [&](ImageView image, auto&& change) {
    change(image);
    return make_hue_plane(image, {}, planes->table, planes->plane);
  };
  planes->plane.width_px = 77;
  planes->plane.code[0] = 7;
  for (const ImageView& image : {rgb, yuyv, nv12}) {
    SCOPED_TRACE(static_cast<int>(image.format));
    EXPECT_EQ(status(image, [](ImageView& i) { i.data = nullptr; }), Status::kBadImage);
    EXPECT_EQ(status(image, [](ImageView& i) { i.width_px = 0; }), Status::kBadImage);
    EXPECT_EQ(status(image, [](ImageView& i) { i.height_px = -1; }), Status::kBadImage);
    EXPECT_EQ(status(image, [](ImageView& i) { i.stride_bytes -= 1; }), Status::kBadImage);
    EXPECT_EQ(status(image, [](ImageView& i) { i.height_px = kMaxImageHeight + 1; }), Status::kBadImage);
    EXPECT_EQ(status(image,
                     [](ImageView& i) {
                       i.width_px = kMaxImageWidth + 2;
                       i.stride_bytes = i.chroma_stride_bytes = 3 * kMaxImageWidth + 6;
                     }),
              Status::kBadImage);
  }
  EXPECT_EQ(status(yuyv, [](ImageView& i) { i.width_px = 5; }), Status::kBadImage);
  EXPECT_EQ(status(nv12, [](ImageView& i) { i.width_px = 5; }), Status::kBadImage);
  EXPECT_EQ(status(nv12, [](ImageView& i) { i.chroma = nullptr; }), Status::kBadImage);
  EXPECT_EQ(status(nv12, [](ImageView& i) { i.chroma_stride_bytes = 5; }), Status::kBadImage);
  EXPECT_EQ(status(rgb, [](ImageView& i) { i.format = static_cast<PixelFormat>(9); }), Status::kBadImage);
  EXPECT_EQ(planes->plane.width_px, 77);
  EXPECT_EQ(planes->plane.code[0], 7);
  for (const ImageView& image : {rgb, yuyv, nv12}) {
    EXPECT_EQ(status(image, [](ImageView&) {}), Status::kOk);
  }
}

}  // namespace
}  // namespace vergence
