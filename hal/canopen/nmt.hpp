// Network management [CiA 301, 7.2.8]: one frame switches a node's communication, and its heartbeat says in
// which state that is.
#pragma once

#include <cstdint>

#include "hal/canopen/can_frame.hpp"

namespace vergence::canopen {

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kEnterPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};

enum class NmtState : std::uint8_t {
  kBootUp = 0x00,
  kStopped = 0x04,
  kOperational = 0x05,
  kPreOperational = 0x7F,
  kUnknown = 0xFF,  // no heartbeat yet, or one the standard does not know
};

inline constexpr std::uint8_t kMaxNodeId = 127;
inline constexpr std::uint32_t kNmtCobId = 0x000;
inline constexpr std::uint32_t kSyncCobId = 0x080;
inline constexpr std::uint32_t kEmergencyCobId = 0x080;  // plus the node's id, like those below
inline constexpr std::uint32_t kTpdo1CobId = 0x180;
inline constexpr std::uint32_t kRpdo1CobId = 0x200;
inline constexpr std::uint32_t kSdoResponseCobId = 0x580;
inline constexpr std::uint32_t kSdoRequestCobId = 0x600;
inline constexpr std::uint32_t kHeartbeatCobId = 0x700;

// Node 0 means all nodes.
[[nodiscard]] CanFrame nmt_command(NmtCommand command, std::uint8_t node_id);
[[nodiscard]] CanFrame sync_frame();
[[nodiscard]] CanFrame heartbeat_frame(std::uint8_t node_id, NmtState state);

// Of the byte of a heartbeat; its toggle bit (of node guarding, which is not used) is ignored.
[[nodiscard]] NmtState decode_nmt_state(std::uint8_t byte);
[[nodiscard]] const char* describe(NmtState state);

}  // namespace vergence::canopen
