// Exposure, gain, white balance and focus held still, so that a colour keeps its hue.
#pragma once

#include <array>
#include <cstdint>

#include "hal/v4l2/v4l2_config.hpp"
#include "hal/v4l2/video_device.hpp"
#include "hal/v4l2/video_error.hpp"

namespace vergence::v4l2 {

class Controls {
 public:
  void configure(const std::array<ControlSetting, kControlRoles>& settings);

  // The automatics still have to find values: begin() starts them, with what is set
  // already held, and after a while lock() ends it.
  [[nodiscard]] bool needs_settling() const;
  [[nodiscard]] VideoError begin(VideoSystem& system, int handle);

  // Holds every value, those set and those found, and reads back that the driver does. What was found once
  // stays over later calls: a camera that was unplugged gets the same values again.
  [[nodiscard]] VideoError lock(VideoSystem& system, int handle);

  // The value a control is held at; nothing is held before lock() has succeeded.
  [[nodiscard]] bool is_held(ControlRole role) const;
  [[nodiscard]] std::int32_t held(ControlRole role) const;

 private:
  struct Held {
    ControlSetting setting;
    bool is_known = false;  // `value` is what to hold
    bool is_held = false;
    std::int32_t value = 0;
  };
  std::array<Held, kControlRoles> roles_{};
};

// What the driver says of a control now, whatever was set.
struct ControlReading {
  bool exists = false;
  std::int32_t value = 0;
  bool has_automatic = false;
  bool is_automatic = false;  // the camera chooses the value
  bool operator==(const ControlReading&) const = default;
};
[[nodiscard]] ControlReading read_control(VideoSystem& system, int handle, ControlRole role);

}  // namespace vergence::v4l2
