// Whole planes, on every instruction set this machine has, against the codes of single pixels.
#include "algo/hue_plane.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <memory>
#include <vector>

#include "algo/rm_ga.hpp"
#include "tests/differential/every_target.hpp"

namespace vergence {
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

TEST_P(HuePlaneTest, EveryFormatWidthAndStrideEqualsScalar) {
  const auto planes = std::make_unique<Planes>();
  planes->table.build(GetParam());
  for_every_target([&] {
    for (const int width : {2, 6, 16, 30, 62, 64, 98, 126, 322}) {
      const int height = 6;
      const std::size_t stride = static_cast<std::size_t>(width) * 3 + 5;
      const auto bytes = random_bytes(stride * 16, static_cast<std::uint64_t>(width));
      const std::uint8_t* chroma = bytes.data() + stride * 8;
      for (const PixelFormat format :
           {PixelFormat::kRgb24, PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12}) {
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
      }
    }
  });
}

TEST(HuePlane, RefusesWhatIsNotAnImage) {
  const auto planes = std::make_unique<Planes>();
  const std::vector<std::uint8_t> bytes(4096);
  const auto status = [&](ImageView image) {
    return make_hue_plane(image, {}, planes->table, planes->plane);
  };
  EXPECT_EQ(status({}), Status::kBadImage);
  EXPECT_EQ(status({bytes.data(), 0, 4, 12, PixelFormat::kRgb24, nullptr, 0}), Status::kBadImage);
  EXPECT_EQ(status({bytes.data(), kMaxImageWidth + 1, 1, 12, PixelFormat::kRgb24, nullptr, 0}),
            Status::kBadImage);
  EXPECT_EQ(status({bytes.data(), 5, 4, 12, PixelFormat::kYuyv, nullptr, 0}), Status::kBadImage);
  EXPECT_EQ(status({bytes.data(), 4, 4, 12, PixelFormat::kNv12, nullptr, 0}), Status::kBadImage);
}

}  // namespace
}  // namespace vergence
