// Why the arm was stopped: one record, with time and axis, and in words.
#pragma once

#include <array>
#include <cstdint>

namespace vergence::canopen {

enum class ArmFaultKind : std::uint8_t {
  kNone,
  kNeverBooted,
  kSdoAbort,        // detail: the abort code; index and sub: the object
  kWrongValue,      // an object read at boot; detail: its value
  kNotHomed,        // detail: HomingState
  kNotOperational,  // did not become so when started; detail: NmtState
  kHeartbeatLost,
  kRebooted,         // by itself
  kLeftOperational,  // detail: NmtState
  kPdoMissing,       // detail: how many in a row
  kStatusMissing,    // detail: for how many ms
  kEmergency,        // detail: its code
  kFollowingError,   // detail: microradians, or 0 where the drive said so
  kDriveFault,       // detail: statusword
  kBadStatusword,    // detail: statusword
  kLeftEnabled,      // detail: statusword
  kEnableTimeout,    // detail: statusword
  kBusOff,           // of the bus; detail: BusState
  kTransmitFull,     // of the bus: two periods in a row could not be sent
  kNoCommand,        // of the controller; detail: periods in a row without a command
};

struct ArmFaultRecord {
  std::int64_t t_ns = 0;
  ArmFaultKind kind = ArmFaultKind::kNone;
  std::int8_t axis = -1;  // from 0; -1: the whole arm, or a bus
  std::uint8_t sub = 0;
  std::uint16_t index = 0;
  std::uint32_t detail = 0;
  std::int8_t bus = -1;  // of two, the one that failed, from 0; -1: there is one, or it is no bus's fault
};

// For ArmFeedback::fault: kind in the upper byte, then axis + 1, or 8 + bus where it is one of two, then 16
// bits of the detail (of an abort, the object's index). 0: none.
[[nodiscard]] std::uint32_t fault_code(const ArmFaultRecord& record);

using FaultText = std::array<char, 192>;
// Ends with a zero. Axes are counted from 1, as people do.
[[nodiscard]] FaultText describe(const ArmFaultRecord& record);

}  // namespace vergence::canopen
