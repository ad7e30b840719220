// The objects this master uses, by index. Of communication: CiA 301; of the drive: CiA 402.
#pragma once

#include <cstdint>

namespace vergence::canopen {

// Entries of an RPDO's mapping that are skipped: data types, by their number.
inline constexpr std::uint16_t kDummyUnsigned8 = 0x0005;
inline constexpr std::uint16_t kDummyUnsigned16 = 0x0006;
inline constexpr std::uint16_t kDummyUnsigned32 = 0x0007;

inline constexpr std::uint16_t kDeviceType = 0x1000;
inline constexpr std::uint16_t kErrorRegister = 0x1001;
inline constexpr std::uint16_t kCyclePeriod = 0x1006;  // us
inline constexpr std::uint16_t kDeviceName = 0x1008;
inline constexpr std::uint16_t kHeartbeatConsumer = 0x1016;  // node << 16 | ms
inline constexpr std::uint16_t kHeartbeatProducer = 0x1017;  // ms
inline constexpr std::uint16_t kIdentity = 0x1018;
inline constexpr std::uint16_t kRpdoCommunication = 0x1400;
inline constexpr std::uint16_t kRpdoMapping = 0x1600;
inline constexpr std::uint16_t kTpdoCommunication = 0x1800;
inline constexpr std::uint16_t kTpdoMapping = 0x1A00;
inline constexpr std::uint16_t kAbortConnectionOption = 0x6007;
inline constexpr std::uint16_t kControlword = 0x6040;
inline constexpr std::uint16_t kStatusword = 0x6041;
inline constexpr std::uint16_t kQuickStopOption = 0x605A;
inline constexpr std::uint16_t kModeOfOperation = 0x6060;
inline constexpr std::uint16_t kModeDisplay = 0x6061;
inline constexpr std::uint16_t kPositionActual = 0x6064;
inline constexpr std::uint16_t kFollowingErrorWindow = 0x6065;
inline constexpr std::uint16_t kFollowingErrorTime = 0x6066;  // ms
inline constexpr std::uint16_t kVelocityActual = 0x606C;
inline constexpr std::uint16_t kTargetPosition = 0x607A;
inline constexpr std::uint16_t kQuickStopDeceleration = 0x6085;
inline constexpr std::uint16_t kInterpolationPeriod = 0x60C2;  // sub 1 times 10^sub 2 s
inline constexpr std::uint16_t kTargetVelocity = 0x60FF;

inline constexpr std::uint32_t kDriveProfile = 402;  // the lower half of the device type

// Modes of operation.
inline constexpr std::uint8_t kModeHoming = 6;
inline constexpr std::uint8_t kModeCyclicPosition = 8;
inline constexpr std::uint8_t kModeCyclicVelocity = 9;

inline constexpr std::uint8_t kAbortConnectionQuickStop = 3;
inline constexpr std::uint8_t kQuickStopAndStay = 6;  // on the quick stop ramp, and hold there

}  // namespace vergence::canopen
