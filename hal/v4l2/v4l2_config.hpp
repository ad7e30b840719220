// What is asked of a camera, and of the pair.
#pragma once

#include <array>
#include <cstdint>

#include "hal/v4l2/video_limits.hpp"

namespace vergence::v4l2 {

enum class BufferMemory : std::uint8_t {
  kMapped,       // the driver's own (MMAP)
  kExported,     // the driver's own, read as a DMA-BUF, whose caches are synchronised by name
  kUserPointer,  // ours (USERPTR)
};

enum class ControlMode : std::uint8_t {
  kLeave,         // as it is
  kSet,           // to `value`, the automatic off
  kAutoThenLock,  // the automatic finds a value once, which then holds, over restarts as well
};

struct ControlSetting {
  ControlMode mode = ControlMode::kLeave;
  std::int32_t value = 0;  // in the driver's units
};

enum class ControlRole : std::uint8_t {
  kExposure,  // 100 us
  kGain,
  kWhiteBalance,  // K
  kRedBalance,    // cameras that have no temperature
  kBlueBalance,
  kFocus,
};
inline constexpr int kControlRoles = 6;

// Seconds, as a fraction; 0/0 leaves it.
struct FrameInterval {
  std::uint32_t numerator = 0;
  std::uint32_t denominator = 0;
};

struct VideoConfig {
  std::array<char, kMaxVideoPath> path{};  // one that survives unplugging, as /dev/v4l/by-path has
  int input = -1;                          // negative: as it is
  bool dv_timings = false;                 // take over those of the source: receivers of HDMI, DVI, SDI
  std::uint32_t fourcc = 0;
  int width_px = 0;
  int height_px = 0;
  FrameInterval interval;
  BufferMemory memory = BufferMemory::kMapped;
  int buffers = kMaxVideoBuffers;
  std::array<ControlSetting, kControlRoles> controls{};  // by ControlRole
  std::int64_t settle_ns = 2'000'000'000;                // what the automatics get
  std::int64_t stamp_to_mid_exposure_ns = 0;             // added to the driver's stamp; negative: before it
  std::int64_t stall_ns = 200'000'000;                   // without a good frame: the stream stalls
  std::int64_t first_frame_ns = 1'000'000'000;           // the same, until the first one: cameras wake slowly
  std::int64_t give_up_ns = 5'000'000'000;               // of trouble, or of a camera that never came
};

struct StereoVideoConfig {
  std::array<VideoConfig, 2> eyes{};  // left, right
  std::int64_t max_skew_ns = 8'000'000;
};

}  // namespace vergence::v4l2
