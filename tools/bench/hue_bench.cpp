#include "tools/bench/hue_bench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "algo/hue_plane.hpp"
#include "algo/rm_ga.hpp"

namespace vergence::tools {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
constexpr double kPixels = 2.0 * kWidth_px * kHeight_px;  // of a stereo pair

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
}

struct Frame {
  // Not {}: that would be a matrix of these three numbers.
  cv::Mat rgb = cv::Mat(kHeight_px, kWidth_px, CV_8UC3);
  cv::Mat yuyv = cv::Mat(kHeight_px, kWidth_px, CV_8UC2);

  [[nodiscard]] ImageView view(PixelFormat format) const {
    const cv::Mat& image = format == PixelFormat::kRgb24 ? rgb : yuyv;
    return {image.data, kWidth_px, kHeight_px, image.step, format, nullptr, 0};
  }
};
using StereoPair = std::array<Frame, 2>;

// Water that darkens downwards, with discs of many colours, shaded, under a sensor's noise.
cv::Vec3d scene_colour(double x, double y) {
  constexpr int kCell_px = 80;
  const int column = static_cast<int>(x) / kCell_px;
  const int row = static_cast<int>(y) / kCell_px;
  const double dx = x - (column + 0.5) * kCell_px;
  const double dy = y - (row + 0.5) * kCell_px;
  const double inside = 1 - (dx * dx + dy * dy) / (32.0 * 32.0);
  if (inside < 0) return {30 + 0.03 * x, 110 - 0.08 * y, 150 - 0.1 * y + 10 * std::sin(0.05 * x + 0.08 * y)};
  const double angle = 0.9 * (column + 8 * row);
  const double shade = 60 + 120 * std::sqrt(inside);
  const auto channel = [&](double phase) { return shade * (0.55 + 0.45 * std::cos(angle - phase)); };
  return {channel(0), channel(2.0944), channel(4.1888)};
}

void fill_yuyv(Frame& frame) {
  for (int y = 0; y < kHeight_px; ++y) {
    for (int x = 0; x < kWidth_px; ++x) {
      const cv::Vec3d rgb = frame.rgb.at<cv::Vec3b>(y, x);
      const double luma = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
      const double chroma = x % 2 == 0 ? (rgb[2] - luma) / 1.772 : (rgb[0] - luma) / 1.402;
      frame.yuyv.at<cv::Vec2b>(y, x) = {byte(16 + luma * 219 / 255), byte(128 + chroma * 224 / 255)};
    }
  }
}

StereoPair make_scene() {
  StereoPair pair;
  CounterRandom random(11, 0);
  for (std::size_t eye = 0; eye < 2; ++eye) {
    for (int y = 0; y < kHeight_px; ++y) {
      for (int x = 0; x < kWidth_px; ++x) {
        const cv::Vec3d colour = scene_colour(x + 24.0 * static_cast<double>(eye), y);
        auto& pixel = pair[eye].rgb.at<cv::Vec3b>(y, x);
        for (int c = 0; c < 3; ++c)
          pixel[c] = byte(colour[c] + static_cast<double>(random.next() >> 61) - 3.5);
      }
    }
    fill_yuyv(pair[eye]);
  }
  return pair;
}

StereoPair make_noise() {
  StereoPair pair;
  CounterRandom random(12, 0);
  for (Frame& frame : pair) {
    for (cv::Mat* image : {&frame.rgb, &frame.yuyv}) {
      std::generate(image->data, image->data + image->total() * image->elemSize(),
                    [&] { return static_cast<std::uint8_t>(random.next() >> 56); });
    }
  }
  return pair;
}

struct Buffers {
  YuvHueTable table;
  HuePlane plane[2];
};

HueBenchTimes measure(const StereoPair& pair, const HueLimits& limits, Buffers& buffers, int turns) {
  const auto ours = [&](PixelFormat format) {
    for (std::size_t eye = 0; eye < 2; ++eye)
      (void)make_hue_plane(pair[eye].view(format), limits, buffers.table, buffers.plane[eye]);
  };
  cv::Mat rgb[2];
  cv::Mat hsv[2];
  const auto opencv_yuyv = [&] {
    for (std::size_t eye = 0; eye < 2; ++eye) {
      cv::cvtColor(pair[eye].yuyv, rgb[eye], cv::COLOR_YUV2RGB_YUYV);
      cv::cvtColor(rgb[eye], hsv[eye], cv::COLOR_RGB2HSV_FULL);
    }
  };
  const auto opencv_rgb = [&] {
    for (std::size_t eye = 0; eye < 2; ++eye) cv::cvtColor(pair[eye].rgb, hsv[eye], cv::COLOR_RGB2HSV_FULL);
  };
  const auto a_pixel = [](PairOfTimes times) {
    return PairOfTimes{times.ours_ns / kPixels, times.theirs_ns / kPixels, times.ratio};
  };
  const auto ours_yuyv = [&] { ours(PixelFormat::kYuyv); };
  const auto ours_rgb = [&] { ours(PixelFormat::kRgb24); };
  return {a_pixel(measure_in_turn(turns, ours_yuyv, opencv_yuyv)),
          a_pixel(measure_in_turn(turns, ours_yuyv, opencv_rgb)),
          a_pixel(measure_in_turn(turns, ours_rgb, opencv_rgb))};
}

}  // namespace

HueBenchResult run_hue_bench(int turns) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const HueLimits limits;
  const auto buffers = std::make_unique<Buffers>();
  buffers->table.build(limits);
  HueBenchResult result;
  result.scene = measure(make_scene(), limits, *buffers, turns);
  result.noise = measure(make_noise(), limits, *buffers, turns);
  const auto worse = [&](PairOfTimes HueBenchTimes::*times) {
    return std::max((result.scene.*times).ratio, (result.noise.*times).ratio);
  };
  result.hue_time_ratio_vs_opencv = worse(&HueBenchTimes::yuyv);
  result.rgb_hue_time_ratio_vs_opencv = worse(&HueBenchTimes::rgb);
  result.yuyv_time_ratio_vs_hsv_alone = worse(&HueBenchTimes::yuyv_against_rgb_hsv);
  cv::setNumThreads(threads);
  return result;
}

}  // namespace vergence::tools
