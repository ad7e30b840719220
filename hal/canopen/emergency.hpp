// Emergency messages [CiA 301, 7.2.7; codes of drives: CiA 402-2 and 301, table 26].
#pragma once

#include <array>
#include <cstdint>

#include "hal/canopen/can_frame.hpp"

namespace vergence::canopen {

struct Emergency {
  std::uint16_t code = 0;           // 0: the error is gone
  std::uint8_t error_register = 0;  // object 0x1001
  std::array<std::uint8_t, 5> manufacturer{};
};

inline constexpr std::uint16_t kEmergencyHeartbeat = 0x8130;
inline constexpr std::uint16_t kEmergencySync = 0x8700;
inline constexpr std::uint16_t kEmergencyFollowingError = 0x8611;

// False where the frame is no emergency of this node: another identifier, or not 8 bytes.
[[nodiscard]] bool decode_emergency(const CanFrame& frame, std::uint8_t node_id, Emergency& emergency);
[[nodiscard]] CanFrame emergency_frame(std::uint8_t node_id, const Emergency& emergency);

// The code in words, else its class.
[[nodiscard]] const char* describe_emergency(std::uint16_t code);

}  // namespace vergence::canopen
