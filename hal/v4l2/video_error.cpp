#include "hal/v4l2/video_error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>

#include "hal/v4l2/pixel_formats.hpp"

namespace vergence::v4l2 {
namespace {

struct Words {
  VideoFault fault;
  const char* field;
  const char* remedy;
};

constexpr std::array kWords = {
    Words{VideoFault::kNone, "none", "nothing to do"},
    Words{VideoFault::kConfig, "configuration", "see the ranges in v4l2_config.hpp"},
    Words{VideoFault::kOpen, "path",
          "plug the camera in, check the path and the permission to read and write it"},
    Words{VideoFault::kNotACamera, "path", "choose the device node that captures video"},
    Words{VideoFault::kNoStreaming, "path", "choose a device whose driver streams"},
    Words{VideoFault::kInput, "input", "choose an input that the device lists"},
    Words{VideoFault::kNoSignal, "input", "switch the source on and check its cable"},
    Words{VideoFault::kTimings, "dv_timings", "set the source to a mode the receiver takes"},
    Words{VideoFault::kPixelFormat, "fourcc",
          "choose YUYV, UYVY, NV12, NM12 or RGB3 as the camera offers it"},
    Words{VideoFault::kSize, "width_px, height_px", "choose a size the camera offers, at most 1280 x 1024"},
    Words{VideoFault::kInterlaced, "field order", "choose a progressive mode of the source"},
    Words{VideoFault::kStride, "bytes of a row", "the driver is at fault; choose another format or size"},
    Words{VideoFault::kImageBytes, "bytes of an image",
          "the driver is at fault; choose another format or size"},
    Words{VideoFault::kInterval, "interval",
          "choose a frame interval the camera offers at this size, or 0/0"},
    Words{VideoFault::kControlMissing, "control", "the camera lacks it: leave it alone in the configuration"},
    Words{VideoFault::kControlRange, "control", "choose a value between the camera's least and greatest"},
    Words{VideoFault::kControlRefused, "control",
          "the camera did not take it: leave it alone, or another value"},
    Words{VideoFault::kControlNotHeld, "control", "choose a value the camera can hold, on its steps"},
    Words{VideoFault::kBuffers, "buffers", "ask for 5 to 8, of a kind of memory the driver knows"},
    Words{VideoFault::kBufferBytes, "bytes of a buffer",
          "the driver is at fault; choose another kind of memory"},
    Words{VideoFault::kMapping, "memory", "choose another kind of memory, or allow more of it"},
    Words{VideoFault::kStreamOn, "stream",
          "give the camera more of the bus: another port, or a smaller size"},
    Words{VideoFault::kQueue, "buffer queue", "look into the kernel's log"},
    Words{VideoFault::kStream, "stream", "check the cable and the signal, look into the kernel's log"},
    Words{VideoFault::kUnplugged, "device", "plug it in again"},
    Words{VideoFault::kStalled, "stream", "check the cable, the signal and the exposure time"},
    Words{VideoFault::kStampClock, "stamps", "choose a driver that stamps frames with the monotonic clock"},
    Words{VideoFault::kAnswer, "driver", "its answer makes no sense; look into the kernel's log"},
};

const Words& words(VideoFault fault) {
  for (const Words& each : kWords)
    if (each.fault == fault) return each;
  return kWords[0];
}

}  // namespace

const char* field(VideoFault fault) {
  return words(fault).field;
}

const char* remedy(VideoFault fault) {
  return words(fault).remedy;
}

bool is_permanent(const VideoError& error) {
  switch (error.fault) {
    case VideoFault::kConfig:
    case VideoFault::kStampClock: return true;
    case VideoFault::kNotACamera:
    case VideoFault::kNoStreaming:
    case VideoFault::kInput:
    case VideoFault::kPixelFormat:
    case VideoFault::kSize:
    case VideoFault::kInterlaced:
    case VideoFault::kStride:
    case VideoFault::kImageBytes:
    case VideoFault::kInterval:
    case VideoFault::kControlMissing:
    case VideoFault::kControlRange:
    case VideoFault::kControlRefused:
    case VideoFault::kControlNotHeld:
    case VideoFault::kBuffers:
    case VideoFault::kBufferBytes:
      return error.error_number == 0 || error.error_number == EINVAL || error.error_number == ENOTTY ||
             error.error_number == ERANGE || error.error_number == EACCES;
    default: return false;
  }
}

std::size_t write_message(const VideoError& error, std::span<char> text) {
  if (text.empty()) return 0;
  const Words& said = words(error.fault);
  int length = 0;
  if (error.fault == VideoFault::kPixelFormat) {
    const auto asked = spell(static_cast<std::uint32_t>(error.asked));
    const auto got = spell(static_cast<std::uint32_t>(error.got));
    const char* reason = refusal(static_cast<std::uint32_t>(error.got));
    length =
        std::snprintf(text.data(), text.size(), "%s: asked %s, got %s (%s), errno %d; %s", said.field,
                      asked.data(), got.data(), reason == nullptr ? "usable, but not what was asked" : reason,
                      error.error_number, said.remedy);
  } else {
    length = std::snprintf(text.data(), text.size(), "%s: asked %lld, got %lld, control %#x, errno %d; %s",
                           said.field, static_cast<long long>(error.asked), static_cast<long long>(error.got),
                           error.id, error.error_number, said.remedy);
  }
  return length < 0 ? 0 : std::min(static_cast<std::size_t>(length), text.size() - 1);
}

}  // namespace vergence::v4l2
