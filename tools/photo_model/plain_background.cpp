#include "tools/photo_model/plain_background.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "algo/colour.hpp"
#include "algo/hue.hpp"

namespace vergence::tools {
namespace {

constexpr int kMargin_px = 2;         // around the rectangle: it may be tight
constexpr int kStep_px = 2;           // of the pixels that are looked at
constexpr double kLeastShare = 0.15;  // of the photo, around the rectangle
constexpr double kPlainLuma = 8;      // standard deviations from the smooth colour, levels
constexpr double kPlainChroma = 4;
constexpr double kSameHue_deg = 30;
constexpr int kTerms = 6;

using Terms = std::array<double, kTerms>;

Terms terms_at(const RgbImage& photo, int x, int y) {
  const double u = 2.0 * x / photo.width_px - 1;
  const double v = 2.0 * y / photo.height_px - 1;
  return {1, u, v, u * u, u * v, v * v};
}

double value_at(const cv::Mat& coefficients, const Terms& terms, int channel) {
  double sum = 0;
  for (int k = 0; k < kTerms; ++k)
    sum += coefficients.at<double>(k, channel) * terms[static_cast<unsigned>(k)];
  return sum;
}

std::uint8_t to_level(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

std::optional<RgbImage> plain_background(const RgbImage& photo, const Rectangle& target, double hue_deg) {
  const cv::Mat levels(photo.height_px, photo.width_px, CV_8UC3,
                       const_cast<std::uint8_t*>(photo.data.data()));
  cv::Mat smooth;
  cv::GaussianBlur(levels, smooth, {}, 1.2);  // sensors' noise is no texture

  const auto around = [&](int x, int y) {
    return x < target.x - kMargin_px || x >= target.x + target.width + kMargin_px ||
           y < target.y - kMargin_px || y >= target.y + target.height + kMargin_px;
  };
  const auto for_each_around = [&](const auto& f) {
    for (int y = 0; y < photo.height_px; y += kStep_px) {
      for (int x = 0; x < photo.width_px; x += kStep_px) {
        if (around(x, y)) f(x, y);
      }
    }
  };
  cv::Mat A = cv::Mat::zeros(kTerms, kTerms, CV_64F);
  cv::Mat b = cv::Mat::zeros(kTerms, 3, CV_64F);
  int count = 0;
  for_each_around([&](int x, int y) {
    const Terms terms = terms_at(photo, x, y);
    const cv::Vec3b& pixel = smooth.at<cv::Vec3b>(y, x);
    for (int k = 0; k < kTerms; ++k) {
      const double term = terms[static_cast<unsigned>(k)];
      for (int l = 0; l < kTerms; ++l) A.at<double>(k, l) += term * terms[static_cast<unsigned>(l)];
      for (int c = 0; c < 3; ++c) b.at<double>(k, c) += term * pixel[c];
    }
    ++count;
  });
  if (count * kStep_px * kStep_px < kLeastShare * photo.width_px * photo.height_px) return std::nullopt;
  cv::Mat coefficients;
  if (!cv::solve(A, b, coefficients, cv::DECOMP_CHOLESKY)) return std::nullopt;

  RgbImage background(photo.width_px, photo.height_px);
  for (int y = 0; y < photo.height_px; ++y) {
    for (int x = 0; x < photo.width_px; ++x) {
      const Terms terms = terms_at(photo, x, y);
      for (int c = 0; c < 3; ++c) background.at(x, y)[c] = to_level(value_at(coefficients, terms, c));
    }
  }

  std::array<double, 3> squares{};  // of luma, cb, cr
  int of_hue = 0;
  int with_hue = 0;
  for_each_around([&](int x, int y) {
    const cv::Vec3b& seen = smooth.at<cv::Vec3b>(y, x);
    const std::uint8_t* bare = background.at(x, y);
    const YCbCr a = ycbcr_from_rgb(seen[0], seen[1], seen[2]);
    const YCbCr e = ycbcr_from_rgb(bare[0], bare[1], bare[2]);
    const std::array<int, 3> difference{a.luma - e.luma, a.cb - e.cb, a.cr - e.cr};
    for (unsigned c = 0; c < 3; ++c) squares[c] += difference[c] * difference[c];
    const std::uint8_t hue = hue_code_rgb(bare[0], bare[1], bare[2], HueLimits{});
    if (!is_hue(hue)) return;
    ++with_hue;
    if (hue_distance(hue, hue_code_from_degrees(hue_deg)) <= hue_tolerance_steps(kSameHue_deg)) ++of_hue;
  });
  const auto deviation = [&](unsigned c) { return std::sqrt(squares[c] / count); };
  if (deviation(0) > kPlainLuma || deviation(1) > kPlainChroma || deviation(2) > kPlainChroma) {
    return std::nullopt;
  }
  // A background that is grey has no hue to agree or to disagree.
  if (2 * with_hue > count && 2 * of_hue < with_hue) return std::nullopt;
  return background;
}

}  // namespace vergence::tools
