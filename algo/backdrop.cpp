#include "algo/backdrop.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace vergence {
namespace {

constexpr int kLevel = 3;  // of the pyramids that is looked at
constexpr unsigned kChannels = 3;
using Channels = std::array<int, kChannels>;

// Like the median: within so many levels of luma, and of chroma (root of the sum of squares).
constexpr int kLikeLuma = 40;
constexpr int kLikeChroma = 16;
constexpr double kPlainShare = 0.6;

// Chroma over luma: the same background below, another one above.
constexpr double kSame = 0.15;
constexpr double kOther = 0.3;
constexpr double kDarkest = 16;  // added to luma: what is nearly black has no colour to speak of

Channels channels_of(ColourPixel pixel) {
  return {static_cast<int>(pixel & 255U), static_cast<int>((pixel >> 8U) & 255U),
          static_cast<int>((pixel >> 16U) & 255U)};
}

template <typename F>
void for_each_pixel(const ColourPyramid& left, const ColourPyramid& right, F&& f) {
  for (const ColourPyramid* pyramid : {&left, &right}) {
    const ColourLevel level = level_of(*pyramid, kLevel);
    for (int i = 0; i < level.width_px * level.height_px; ++i) f(channels_of(level.pixel[i]));
  }
}

std::uint8_t to_byte(int value) {
  return static_cast<std::uint8_t>(value < 0 ? 0 : value > 255 ? 255 : value);
}

YCbCr full_range(const Channels& c) {
  const auto scaled = [](int value, int range) {
    return (value * 255 + (value < 0 ? -range : range) / 2) / range;
  };
  return {to_byte(scaled(c[0] - 16, 219)), to_byte(128 + scaled(c[1] - 128, 224)),
          to_byte(128 + scaled(c[2] - 128, 224))};
}

}  // namespace

void sum_up_backdrop(int points, PhotoBackdrop& backdrop) {
  constexpr unsigned kComparedLevel = 2;
  constexpr std::uint8_t kLeastShare = 64;
  constexpr double kPlain = 12;  // deviation of chroma
  const PointColours& colour = backdrop.colour[kComparedLevel];
  double count = 0;
  double luma = 0;
  double cb = 0;
  double cr = 0;
  double squares = 0;
  for (unsigned i = 0; i < static_cast<unsigned>(points); ++i) {
    if (backdrop.share[kComparedLevel][i] < kLeastShare) continue;
    const int b = colour.cb[i];
    const int r = colour.cr[i];
    count += 1;
    luma += colour.luma[i];
    cb += b;
    cr += r;
    squares += b * b + r * r;
  }
  if (count == 0) return;
  const auto byte = [&](double sum) { return static_cast<std::uint8_t>(sum / count + 0.5); };
  backdrop.mean = {byte(luma), byte(cb), byte(cr)};
  backdrop.plain = squares / count - (cb * cb + cr * cr) / (count * count) < kPlain * kPlain;
}

Backdrop find_backdrop(const ColourPyramid& left, const ColourPyramid& right, bool limited_range) {
  std::array<std::array<int, 256>, kChannels> histogram{};
  int pixels = 0;
  for_each_pixel(left, right, [&](const Channels& pixel) {
    for (unsigned c = 0; c < kChannels; ++c) ++histogram[c][static_cast<unsigned>(pixel[c])];
    ++pixels;
  });
  Channels median{};
  for (unsigned c = 0; c < kChannels; ++c) {
    int below = 0;
    for (unsigned value = 0; value < 256; ++value) {
      below += histogram[c][value];
      if (2 * below <= pixels) median[c] = static_cast<int>(value) + 1;
    }
  }
  int like = 0;
  for_each_pixel(left, right, [&](const Channels& pixel) {
    const int cb = pixel[1] - median[1];
    const int cr = pixel[2] - median[2];
    const bool same =
        std::abs(pixel[0] - median[0]) <= kLikeLuma && cb * cb + cr * cr <= kLikeChroma * kLikeChroma;
    like += same ? 1 : 0;
  });
  return {
      limited_range ? full_range(median) : YCbCr{to_byte(median[0]), to_byte(median[1]), to_byte(median[2])},
      like >= kPlainShare * pixels};
}

int backdrop_change(const PhotoBackdrop& of_photo, const Backdrop& of_images) {
  if (!of_photo.plain) return 256;
  const auto tint = [](int chroma, int luma) { return (chroma - 128) / (luma + kDarkest); };
  const YCbCr& a = of_photo.mean;
  const YCbCr& b = of_images.colour;
  const double cb = tint(a.cb, a.luma) - tint(b.cb, b.luma);
  const double cr = tint(a.cr, a.luma) - tint(b.cr, b.luma);
  const double share = (std::sqrt(cb * cb + cr * cr) - kSame) / (kOther - kSame);
  return share <= 0 ? 0 : share >= 1 ? 256 : static_cast<int>(256 * share);
}

void put_before(const Backdrop& backdrop, int change,
                const std::array<PointColours, kColourLevels>& as_photographed, PhotoModel& model) {
  constexpr int kWhole = 255 * 256;
  for (unsigned level = 0; level < kColourLevels; ++level) {
    const PointColours& from = as_photographed[level];
    const PointColours& behind = model.backdrop.colour[level];
    PointColours& to = model.colour[level];
    for (unsigned i = 0; i < static_cast<unsigned>(model.inner); ++i) {
      const int share = change * model.backdrop.share[level][i];
      const auto composed = [share](int colour, int photos, int seen) {
        const int moved = share * (seen - photos);
        return to_byte(colour + (moved + (moved < 0 ? -kWhole : kWhole) / 2) / kWhole);
      };
      to.luma[i] = composed(from.luma[i], behind.luma[i], backdrop.colour.luma);
      to.cb[i] = composed(from.cb[i], behind.cb[i], backdrop.colour.cb);
      to.cr[i] = composed(from.cr[i], behind.cr[i], backdrop.colour.cr);
    }
  }
}

void leave_rim_out(bool left_out, PhotoModel& model) {
  constexpr float kFar_mm = 1e6F;  // beyond any eye
  for (unsigned i = 0; i < static_cast<unsigned>(model.inner); ++i) {
    model.left_out_mm[i] = left_out && model.weight[i] == 0 ? kFar_mm : 0;
  }
}

}  // namespace vergence
