#include "tools/photo_model/find_target.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace vergence::tools {
namespace {

constexpr double kSigmas = 6;            // of noise, from which on a difference counts
constexpr double kLeastNoise = 1.0;      // levels: quantization, and cameras that smooth their noise away
constexpr double kBorderShare = 0.08;    // of the picture, taken for bare background on every side
constexpr double kDarkestShadow = 0.45;  // of the light; what is darker is a thing
constexpr double kLeastPart = 0.1;       // of the largest piece: smaller ones are not the target
constexpr int kLeastPixels = 300;

// Luma, cb, cr as floats, smoothed a little.
cv::Mat ycbcr(const RgbImage& image) {
  const cv::Mat rgb(image.height_px, image.width_px, CV_8UC3, const_cast<std::uint8_t*>(image.data.data()));
  cv::Mat floats;
  rgb.convertTo(floats, CV_32F);
  const cv::Matx33f from_rgb(0.299F, 0.587F, 0.114F, -0.1687F, -0.3313F, 0.5F, 0.5F, -0.4187F, -0.0813F);
  cv::transform(floats, floats, from_rgb);
  cv::GaussianBlur(floats, floats, {}, std::max(1.0, image.width_px / 500.0));
  return floats;
}

struct Noise {
  cv::Vec3f offset;  // of the photo over the background: light and exposure are never quite the same
  cv::Vec3f sigma;
};

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median and scaled median deviation of the differences near the border, where the target is not to be.
Noise noise_near_border(const cv::Mat& difference) {
  const int mx = std::max(2, static_cast<int>(difference.cols * kBorderShare));
  const int my = std::max(2, static_cast<int>(difference.rows * kBorderShare));
  Noise noise;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (int y = 0; y < difference.rows; ++y) {
      for (int x = 0; x < difference.cols; ++x) {
        if (x >= mx && x < difference.cols - mx && y >= my && y < difference.rows - my) continue;
        values.push_back(difference.at<cv::Vec3f>(y, x)[c]);
      }
    }
    noise.offset[c] = median(values);
    for (float& value : values) value = std::abs(value - noise.offset[c]);
    noise.sigma[c] = std::max(static_cast<float>(kLeastNoise), 1.4826F * median(values));
  }
  return noise;
}

// The background's colour, only darker: its chroma shrinks with its luma.
bool is_shadow(const cv::Vec3f& seen, const cv::Vec3f& bare, const Noise& noise) {
  const float light = seen[0] / std::max(bare[0], 1.0F);
  if (light >= 1 || light < kDarkestShadow) return false;
  double distance = 0;
  for (int c = 1; c < 3; ++c) {
    const double d = (seen[c] - light * bare[c]) / noise.sigma[c];
    distance += d * d;
  }
  return distance < kSigmas * kSigmas;
}

cv::Mat differing_pixels(const RgbImage& photo, const RgbImage& background) {
  cv::Mat seen = ycbcr(photo);
  const cv::Mat bare = ycbcr(background);
  const Noise noise = noise_near_border(seen - bare);
  cv::Mat differs(seen.size(), CV_8U);
  for (int y = 0; y < seen.rows; ++y) {
    for (int x = 0; x < seen.cols; ++x) {
      const cv::Vec3f corrected = seen.at<cv::Vec3f>(y, x) - noise.offset;
      const cv::Vec3f& expected = bare.at<cv::Vec3f>(y, x);
      double distance = 0;
      for (int c = 0; c < 3; ++c) {
        const double d = (corrected[c] - expected[c]) / noise.sigma[c];
        distance += d * d;
      }
      const bool target = distance > kSigmas * kSigmas && !is_shadow(corrected, expected, noise);
      differs.at<std::uint8_t>(y, x) = target ? 255 : 0;
    }
  }
  return differs;
}

// Gaps up to this many pixels are closed.
int closed_gap(int width_px) {
  return std::max(5, width_px / 90) | 1;
}

void clean_up(cv::Mat& mask) {
  const auto disc = [](int size) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size}); };
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, disc(3));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, disc(closed_gap(mask.cols)), {-1, -1}, 1, cv::BORDER_CONSTANT,
                   0);
  cv::erode(mask, mask, disc(3));  // the rim that smoothing added
}

}  // namespace

FoundTarget find_target(const RgbImage& photo, const RgbImage& background) {
  cv::Mat candidates = differing_pixels(photo, background);
  clean_up(candidates);

  FoundTarget found;
  found.mask = {photo.width_px, photo.height_px, std::vector<std::uint8_t>(photo.data.size() / 3, 0)};
  cv::Mat mask(photo.height_px, photo.width_px, CV_8U, found.mask.data.data());
  std::vector<std::vector<cv::Point>> pieces;
  cv::findContours(candidates, pieces, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  double largest = 0;
  for (const auto& piece : pieces) largest = std::max(largest, cv::contourArea(piece));
  if (largest < kLeastPixels) return found;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (cv::contourArea(pieces[i]) < kLeastPart * largest) continue;
    cv::drawContours(mask, pieces, static_cast<int>(i), 255, cv::FILLED);
    ++found.parts;
  }
  found.pixels = cv::countNonZero(mask);
  found.roi = bounding_rectangle(found.mask);
  const int margin = closed_gap(photo.width_px);
  found.touches_border = found.roi.x < margin || found.roi.y < margin ||
                         found.roi.x + found.roi.width > photo.width_px - margin ||
                         found.roi.y + found.roi.height > photo.height_px - margin;
  return found;
}

Rectangle bounding_rectangle(const GreyImage& mask) {
  const cv::Mat pixels(mask.height_px, mask.width_px, CV_8U, const_cast<std::uint8_t*>(mask.data.data()));
  const cv::Rect r = cv::boundingRect(pixels);
  return {r.x, r.y, r.width, r.height};
}

}  // namespace vergence::tools
