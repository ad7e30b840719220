#include "algo/light_follower.hpp"

namespace vergence {
namespace {

constexpr int kUnit = 256;            // of a hue step
constexpr int kNear = kHueSteps / 8;  // 45 degrees from the shifted hue: what still counts
constexpr int kFewest = 8;            // pixels of a frame that make a mean
constexpr int kShare = 8;             // an eighth of the way each frame: a quarter of a second
constexpr int kFading = 16;
constexpr int kMaxShift = static_cast<int>(LightFollower::kMaxShift_deg * kHueSteps / 360.0) * kUnit;

// Nearest whole number of steps; halves away from zero.
int whole_steps(std::int32_t shift) {
  return (shift + (shift < 0 ? -kUnit / 2 : kUnit / 2)) / kUnit;
}

// The way from a to b round the circle, -126..125 steps.
int signed_distance(int a, int b) {
  const int d = (b - a + 2 * kHueSteps + kHueSteps / 2) % kHueSteps;
  return d - kHueSteps / 2;
}

}  // namespace

void LightFollower::forget() {
  channel_ = {};
}

void LightFollower::observe(int channel, std::uint8_t configured, std::uint8_t seen) {
  Channel& c = channel_[static_cast<unsigned>(channel)];
  const bool both = is_hue(configured) && is_hue(seen);
  const int shift = whole_steps(c.shift);
  const int off = signed_distance(configured + shift, seen);  // from where it was expected
  const bool counts = both & (off < kNear) & (off > -kNear);
  c.sum += counts ? off + shift : 0;
  c.count += counts ? 1 : 0;
}

void LightFollower::end_frame(bool tracked) {
  for (Channel& c : channel_) {
    if (!tracked) {
      c.shift -= c.shift / kFading + (c.shift > 0 ? 1 : (c.shift < 0 ? -1 : 0));
    } else if (c.count >= kFewest) {
      const std::int32_t mean = static_cast<std::int32_t>(std::int64_t{c.sum} * kUnit / c.count);
      const std::int32_t shift = c.shift + (mean - c.shift) / kShare;
      c.shift = shift > kMaxShift ? kMaxShift : (shift < -kMaxShift ? -kMaxShift : shift);
    }
    c.sum = 0;
    c.count = 0;
  }
}

std::uint8_t LightFollower::expected(int channel, std::uint8_t configured) const {
  if (!is_hue(configured)) return configured;
  const int code = configured + whole_steps(channel_[static_cast<unsigned>(channel)].shift);
  return static_cast<std::uint8_t>((code + kHueSteps) % kHueSteps);
}

double LightFollower::shift_deg(int channel) const {
  return channel_[static_cast<unsigned>(channel)].shift * (360.0 / kHueSteps / kUnit);
}

}  // namespace vergence
