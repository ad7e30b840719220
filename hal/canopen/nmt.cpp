#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {

CanFrame nmt_command(NmtCommand command, std::uint8_t node_id) {
  CanFrame frame;
  frame.id = kNmtCobId;
  frame.size = 2;
  frame.data[0] = static_cast<std::uint8_t>(command);
  frame.data[1] = node_id;
  return frame;
}

CanFrame sync_frame() {
  CanFrame frame;
  frame.id = kSyncCobId;
  return frame;
}

CanFrame heartbeat_frame(std::uint8_t node_id, NmtState state) {
  CanFrame frame;
  frame.id = kHeartbeatCobId + node_id;
  frame.size = 1;
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

NmtState decode_nmt_state(std::uint8_t byte) {
  switch (byte & 0x7F) {
    case 0x00: return NmtState::kBootUp;
    case 0x04: return NmtState::kStopped;
    case 0x05: return NmtState::kOperational;
    case 0x7F: return NmtState::kPreOperational;
    default: return NmtState::kUnknown;
  }
}

const char* describe(NmtState state) {
  switch (state) {
    case NmtState::kBootUp: return "booting";
    case NmtState::kStopped: return "stopped";
    case NmtState::kOperational: return "operational";
    case NmtState::kPreOperational: return "pre-operational";
    case NmtState::kUnknown: return "unknown";
  }
  return "unknown";
}

}  // namespace vergence::canopen
