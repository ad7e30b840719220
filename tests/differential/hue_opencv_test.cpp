// Our hue against OpenCV's RGB2HSV_FULL, over every RGB colour and every YUV value inside the cube of RGB.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algo/hue_plane.hpp"

namespace vergence {
namespace {

constexpr int kSize = 1024;  // 16 images of 2^20 pixels hold all 2^24 values
constexpr std::size_t kPixels = std::size_t{kSize} * kSize;

// OpenCV codes 360 deg in 256 steps. It rounds to the nearest, after a division by a table of 12 fractional
// bits: each entry is off by at most 2^-13, times a numerator of at most 5 * 255. Its code is a byte, so what
// rounds to 256 is given as 255, which is off by up to a whole step.
constexpr double kOpenCvStep_deg = 360.0 / 256;
constexpr double kOpenCvTable_deg = 5 * 255 / 8192.0 * kOpenCvStep_deg;
constexpr double kOurs_deg = 180.0 / kHueSteps;
constexpr double kTolerance_deg = kOurs_deg + 0.5 * kOpenCvStep_deg + kOpenCvTable_deg;
constexpr double kToleranceAt255_deg = kOurs_deg + kOpenCvStep_deg + kOpenCvTable_deg;

double apart_deg(std::uint8_t ours, std::uint8_t of_opencv) {
  const double d = std::abs(hue_degrees(ours) - of_opencv * kOpenCvStep_deg);
  return std::min(d, 360 - d);
}

double tolerance_deg(std::uint8_t of_opencv) {
  return of_opencv == 255 ? kToleranceAt255_deg : kTolerance_deg;
}

TEST(HueAgainstOpenCv, RgbAgreesForAllColours) {
  const auto plane = std::make_unique<HuePlane>();
  const auto table = std::make_unique<YuvHueTable>();  // not used for RGB
  cv::Mat rgb(kSize, kSize, CV_8UC3);
  cv::Mat hsv;
  double worst_deg = 0;
  for (int part = 0; part < 16; ++part) {
    for (std::size_t i = 0; i < kPixels; ++i) {
      const auto colour = static_cast<unsigned>(part) << 20 | static_cast<unsigned>(i);
      for (unsigned c = 0; c < 3; ++c)
        rgb.data[3 * i + c] = static_cast<std::uint8_t>(colour >> (16 - 8 * c));
    }
    const ImageView image{rgb.data, kSize, kSize, rgb.step, PixelFormat::kRgb24, nullptr, 0};
    ASSERT_EQ(make_hue_plane(image, kThesisHueLimits, *table, *plane), Status::kOk);
    cv::cvtColor(rgb, hsv, cv::COLOR_RGB2HSV_FULL);
    for (std::size_t i = 0; i < kPixels; ++i) {
      const std::uint8_t* p = &rgb.data[3 * i];
      const bool grey = p[0] == p[1] && p[1] == p[2];
      ASSERT_EQ(plane->code[i] == kHueUndefined, grey) << int{p[0]} << " " << int{p[1]} << " " << int{p[2]};
      if (grey) continue;
      const double apart = apart_deg(plane->code[i], hsv.data[3 * i]);
      ASSERT_LE(apart, tolerance_deg(hsv.data[3 * i])) << int{p[0]} << " " << int{p[1]} << " " << int{p[2]};
      worst_deg = std::max(worst_deg, apart);
    }
  }
  EXPECT_GT(worst_deg, 1.0);  // two codings that round differently do differ
}

// By way of OpenCV's own RGB, which is off by less than 1 a channel (rounding, and 1.164 for 255/219): as
// each of them moves the hue by at most 60 deg / chroma on the way, 1 moves it by at most 120 / (C - 2).
TEST(HueAgainstOpenCv, YuyvAgreesWhereRgbDoesNotClip) {
  const auto plane = std::make_unique<HuePlane>();
  const auto table = std::make_unique<YuvHueTable>();
  table->build(kThesisHueLimits);
  cv::Mat yuyv(kSize, kSize, CV_8UC2);
  cv::Mat rgb;
  cv::Mat hsv;
  long compared = 0;
  for (int part = 0; part < 16; ++part) {
    for (std::size_t i = 0; i < kPixels; ++i) {
      const auto value = static_cast<unsigned>(part) << 20 | static_cast<unsigned>(i);
      yuyv.data[2 * i] = static_cast<std::uint8_t>(value);
      yuyv.data[2 * i + 1] = static_cast<std::uint8_t>(i % 2 == 0 ? value >> 16 : value >> 8);
    }
    const ImageView image{yuyv.data, kSize, kSize, yuyv.step, PixelFormat::kYuyv, nullptr, 0};
    ASSERT_EQ(make_hue_plane(image, kThesisHueLimits, *table, *plane), Status::kOk);
    cv::cvtColor(yuyv, rgb, cv::COLOR_YUV2RGB_YUYV);
    cv::cvtColor(rgb, hsv, cv::COLOR_RGB2HSV_FULL);
    for (std::size_t i = 0; i < kPixels; ++i) {
      const std::uint8_t* p = &rgb.data[3 * i];
      const int V = std::max({p[0], p[1], p[2]});
      const int v = std::min({p[0], p[1], p[2]});
      if (v < 1 || V > 254 || V - v < 3) continue;
      ASSERT_TRUE(is_hue(plane->code[i]));
      const double tolerance = tolerance_deg(hsv.data[3 * i]) + 120.0 / (V - v - 2);
      ASSERT_LE(apart_deg(plane->code[i], hsv.data[3 * i]), tolerance)
          << int{yuyv.data[2 * i]} << " of pixel " << i << " of part " << part;
      ++compared;
    }
  }
  EXPECT_GT(compared, 2'500'000);
}

}  // namespace
}  // namespace vergence
