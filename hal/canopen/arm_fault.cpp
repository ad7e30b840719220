#include "hal/canopen/arm_fault.hpp"

#include <cstdio>

#include "hal/canopen/can_bus.hpp"
#include "hal/canopen/drive_state.hpp"
#include "hal/canopen/emergency.hpp"
#include "hal/canopen/nmt.hpp"
#include "hal/canopen/sdo_abort.hpp"

namespace vergence::canopen {
namespace {

const char* in_words(ArmFaultKind kind) {
  switch (kind) {
    case ArmFaultKind::kNone: return "no fault";
    case ArmFaultKind::kNeverBooted: return "did not boot in time: check power, node id, bit rate";
    case ArmFaultKind::kSdoAbort: return "a transfer was aborted";
    case ArmFaultKind::kWrongValue: return "an object has not the value it must have";
    case ArmFaultKind::kNotHomed: return "is not homed";
    case ArmFaultKind::kNotOperational: return "was started and did not become operational with process data";
    case ArmFaultKind::kHeartbeatLost: return "its heartbeat stopped";
    case ArmFaultKind::kRebooted: return "restarted by itself";
    case ArmFaultKind::kLeftOperational: return "left the state operational";
    case ArmFaultKind::kPdoMissing: return "sent no process data";
    case ArmFaultKind::kStatusMissing: return "sent no statusword, for ms";
    case ArmFaultKind::kEmergency: return "emergency";
    case ArmFaultKind::kFollowingError: return "following error";
    case ArmFaultKind::kDriveFault: return "the drive is in a fault";
    case ArmFaultKind::kBadStatusword: return "its statusword has no meaning in CiA 402";
    case ArmFaultKind::kLeftEnabled: return "is not enabled any more";
    case ArmFaultKind::kEnableTimeout: return "could not be enabled in time";
    case ArmFaultKind::kBusOff: return "the bus cannot be used";
    case ArmFaultKind::kTransmitFull:
      return "two periods in a row could not be sent: bus full or not connected";
    case ArmFaultKind::kNoCommand: return "the controller sent no command";
  }
  return "unknown fault";
}

// What the detail means, if that has words of its own.
const char* detail_in_words(const ArmFaultRecord& record) {
  const std::uint32_t detail = record.detail;
  switch (record.kind) {
    case ArmFaultKind::kSdoAbort: return describe_abort(detail);
    case ArmFaultKind::kNotHomed: return describe(static_cast<HomingState>(detail));
    case ArmFaultKind::kNotOperational:
    case ArmFaultKind::kLeftOperational: return describe(static_cast<NmtState>(detail));
    case ArmFaultKind::kEmergency: return describe_emergency(static_cast<std::uint16_t>(detail));
    case ArmFaultKind::kDriveFault:
    case ArmFaultKind::kBadStatusword:
    case ArmFaultKind::kLeftEnabled:
    case ArmFaultKind::kEnableTimeout: return describe(decode_state(static_cast<std::uint16_t>(detail)));
    case ArmFaultKind::kFollowingError: return detail == 0 ? "reported by the drive" : "microradians";
    case ArmFaultKind::kBusOff:
      return detail == static_cast<std::uint32_t>(BusState::kOff) ? "bus off" : "interface down";
    default: return nullptr;
  }
}

}  // namespace

std::uint32_t fault_code(const ArmFaultRecord& record) {
  const std::uint32_t low = record.kind == ArmFaultKind::kSdoAbort ? record.index : record.detail & 0xFFFF;
  const int who = record.bus >= 0 ? 8 + record.bus : record.axis + 1;
  return static_cast<std::uint32_t>(record.kind) << 24 | static_cast<std::uint32_t>(who) << 16 | low;
}

FaultText describe(const ArmFaultRecord& record) {
  FaultText text{};
  std::array<char, 16> who{};
  if (record.axis >= 0) {
    (void)std::snprintf(who.data(), who.size(), "axis %d: ", record.axis + 1);
  } else if (record.bus >= 0) {
    (void)std::snprintf(who.data(), who.size(), "bus %d: ", record.bus + 1);
  }
  std::array<char, 24> object{};
  if (record.index != 0) {
    (void)std::snprintf(object.data(), object.size(), " (object 0x%04X:%02X)", unsigned{record.index},
                        unsigned{record.sub});
  }
  const char* words = detail_in_words(record);
  if (words != nullptr) {
    const char* form = record.kind == ArmFaultKind::kFollowingError ? "%s%s%s: %u, %s" : "%s%s%s: 0x%X, %s";
    (void)std::snprintf(text.data(), text.size(), form, who.data(), in_words(record.kind), object.data(),
                        record.detail, words);
  } else if (record.detail != 0 || record.kind == ArmFaultKind::kWrongValue) {
    (void)std::snprintf(text.data(), text.size(), "%s%s%s: %u", who.data(), in_words(record.kind),
                        object.data(), record.detail);
  } else {
    (void)std::snprintf(text.data(), text.size(), "%s%s%s", who.data(), in_words(record.kind), object.data());
  }
  return text;
}

}  // namespace vergence::canopen
