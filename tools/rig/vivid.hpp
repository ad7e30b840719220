// One of the kernel's test cameras (vivid), looped: what is shown on its display is what its camera sees. Set
// up for 640x480 at 60 Hz, YUYV; its faults are controls of its own.
#pragma once

#include <linux/videodev2.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "tools/rig/file_handle.hpp"

namespace vergence::rig {

inline constexpr int kWidth_px = 640;
inline constexpr int kHeight_px = 480;
inline constexpr std::size_t kFrameBytes = std::size_t{2} * kWidth_px * kHeight_px;

class Vivid {
 public:
  // Throws RigError where a device is not there, or not of vivid.
  Vivid(const char* camera, const char* display);
  ~Vivid();
  Vivid(const Vivid&) = delete;
  Vivid& operator=(const Vivid&) = delete;

  // Shows a picture of kFrameBytes until the next one; from the display's next period on. False where the
  // last ones are not shown yet, or the device is unplugged.
  [[nodiscard]] bool show(std::span<const std::uint8_t> yuyv);

  // Faults. The device is back when all have closed it, and we after the others.
  void unplug();
  void plug_in();
  [[nodiscard]] bool is_unplugged() const { return unplugged_; }
  void set_dropped_percent(int percent);
  void flag_next_frame();  // as broken

 private:
  void open();
  void set_up_camera();
  void set_up_display();
  void queue(std::uint32_t index);
  template <typename IsIt>
  [[nodiscard]] bool find_control(IsIt&& is_it, v4l2_queryctrl& query);
  void set_control(std::string_view name, int value);
  void loop_display();
  void close();

  // Of two that are queued the display lets go of the first; the second stays, and is written to while it is
  // shown. So a picture is seen at once, and not a period or two later.
  static constexpr std::size_t kBuffers = 2;

  const char* camera_path_;
  const char* display_path_;
  FileHandle camera_;  // for the controls alone
  FileHandle display_;
  std::array<std::span<std::uint8_t>, kBuffers> memory_{};
  bool unplugged_ = false;
};

}  // namespace vergence::rig
