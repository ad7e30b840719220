// Hue tolerances that follow the light: while a target is tracked, how far each of its hues has shifted is
// learnt from pixels known to show it, slowly and within bounds, so that votes keep counting when lamps
// change.
//
// Shifts are kept by channel: a ball of a marker, or a sector of the hue circle of a photo-model.
#pragma once

#include <array>
#include <cstdint>

#include "algo/hue.hpp"
#include "algo/limits.hpp"

namespace vergence {

inline constexpr int kHueSectors = 12;  // of 30 degrees: the channels of a photo-model
inline constexpr int kLightChannels = kHueSectors > kMaxBalls ? kHueSectors : kMaxBalls;

[[nodiscard]] constexpr int hue_sector(std::uint8_t code) {
  return is_hue(code) ? code * kHueSectors / kHueSteps : 0;
}

class LightFollower {
 public:
  // No shift anywhere.
  void forget();

  // A pixel that, at the tracked pose, ought to have the hue `configured`. Pixels without hue, or so far from
  // the shifted hue that they hardly show the target, do not count.
  void observe(int channel, std::uint8_t configured, std::uint8_t seen);

  // Ends a frame. Where the target was tracked, each shift moves a small share of the way to the circular
  // mean of what was observed in this frame, and never beyond kMaxShift_deg; otherwise all shifts fade.
  void end_frame(bool tracked);

  // The hue code to expect in place of a configured one. Codes without hue stay as they are.
  [[nodiscard]] std::uint8_t expected(int channel, std::uint8_t configured) const;

  [[nodiscard]] double shift_deg(int channel) const;

  static constexpr double kMaxShift_deg = 30;

 private:
  // In 256ths of a hue step, so that slow shifts add up; whole numbers, the same everywhere.
  struct Channel {
    std::int32_t shift = 0;
    std::int32_t sum = 0;  // of this frame, in steps
    std::int32_t count = 0;
  };
  std::array<Channel, kLightChannels> channel_{};
};

}  // namespace vergence
