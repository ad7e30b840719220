// What can be wrong with a camera, and what to do about it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence::v4l2 {

enum class VideoFault : std::uint8_t {
  kNone,
  // The configuration itself.
  kConfig,
  // What the camera answered when it was set up.
  kOpen,
  kNotACamera,
  kNoStreaming,
  kInput,
  kNoSignal,
  kTimings,
  kPixelFormat,
  kSize,
  kInterlaced,
  kStride,
  kImageBytes,
  kInterval,
  kControlMissing,
  kControlRange,
  kControlRefused,
  kControlNotHeld,
  kBuffers,
  kBufferBytes,
  kMapping,
  // While it runs.
  kStreamOn,
  kQueue,
  kStream,
  kUnplugged,
  kStalled,
  kStampClock,
  kAnswer,
};

struct VideoError {
  VideoFault fault = VideoFault::kNone;
  int error_number = 0;    // of errno.h; 0: the driver did as it was told, but not what was asked
  std::uint32_t id = 0;    // of the control, where it is about one
  std::int64_t asked = 0;  // fourcc, px, bytes, ns or a control's units, as the field has
  std::int64_t got = 0;
};

[[nodiscard]] constexpr bool is_ok(const VideoError& error) {
  return error.fault == VideoFault::kNone;
}

// The field of the configuration or the part of the device it is about.
[[nodiscard]] const char* field(VideoFault fault);
[[nodiscard]] const char* remedy(VideoFault fault);

// Trying again does not help: the camera answers, and will not do what the configuration asks for.
[[nodiscard]] bool is_permanent(const VideoError& error);

// One line for people: field, what was asked, what came, remedy. Cut to the length of `text`, and ended by a
// zero; returns the length without it.
std::size_t write_message(const VideoError& error, std::span<char> text);

}  // namespace vergence::v4l2
