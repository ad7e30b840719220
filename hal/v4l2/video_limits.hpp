// Every static size and fixed span of video capture, in one place.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vergence::v4l2 {

inline constexpr int kMaxVideoPath = 128;
inline constexpr int kMaxVideoBuffers = 8;                                  // of one camera
inline constexpr int kMaxVideoPlanes = 2;                                   // NV12 in two pieces of memory
inline constexpr std::size_t kMaxVideoBufferBytes = std::size_t{16} << 20;  // of one plane

inline constexpr int kPairingDepth = 3;   // frames of one camera that may wait for the other's
inline constexpr int kReaderBuffers = 2;  // the pair that is looked at, and the one that waits for it
inline constexpr int kDriverBuffers = 2;  // always left to the driver, or it would lose frames
inline constexpr int kMinVideoBuffers = kReaderBuffers + kDriverBuffers + 1;

inline constexpr int kGoodFramesToRecover = 10;  // fewer between two troubles: it is still the same trouble
inline constexpr int kIntervalTolerancePpm = 10'000;

inline constexpr std::int64_t kMaxStampAge_ns = 10'000'000'000;  // older: no stamp of this clock
inline constexpr std::int64_t kMaxStampLead_ns = 100'000'000;    // frames come after the clock was read
inline constexpr std::int64_t kMaxSkew_ns = 1'000'000'000;
inline constexpr std::int64_t kReaderWait_ns = 2'000'000;     // until the reader is looked after again
inline constexpr std::int64_t kFirstBackOff_ns = 20'000'000;  // doubles with each attempt
inline constexpr std::int64_t kMaxBackOff_ns = 500'000'000;
inline constexpr std::int64_t kMaxWait_ns = 100'000'000;  // of the capture thread, whatever else is due

}  // namespace vergence::v4l2
