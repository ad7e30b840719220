// Process data objects [CiA 301, 7.2.2]: which objects travel in one frame, and when. What a drive must be
// told of it is a table of SDO writes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/canopen/fixed_list.hpp"

namespace vergence::canopen {

struct SdoWrite {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t size = 0;  // bytes, 1 to 4
  std::uint32_t value = 0;
  bool may_be_missing = false;  // a device need not have the object
};

struct PdoEntry {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bits = 0;
};

enum class PdoDirection : std::uint8_t {
  kToDrive,    // RPDO, by its name in the standard: the drive receives
  kFromDrive,  // TPDO
};

inline constexpr std::size_t kMaxPdoEntries = 8;
inline constexpr std::uint8_t kPdos = 4;              // numbers 1 to 4, each way
inline constexpr std::uint8_t kEverySync = 1;         // transmission type: with each SYNC
inline constexpr std::uint8_t kOnEvent = 255;         // sent as it changes, acts at once
inline constexpr std::uint8_t kPdoInhibitSub = 3;     // of a PDO's communication; 0.1 ms
inline constexpr std::uint8_t kPdoTimerSub = 5;       // ms
inline constexpr std::uint32_t kPdoOff = 0x80000000;  // bits of a COB-ID
inline constexpr std::uint32_t kPdoNoRemote = 0x40000000;

struct PdoConfig {
  PdoDirection direction = PdoDirection::kToDrive;
  std::uint8_t number = 1;
  std::uint32_t cob_id = 0;
  std::uint8_t transmission = kEverySync;
  std::int64_t inhibit_ns = 0;      // never sent sooner than this after the last; 0: as the device has it
  std::int64_t event_timer_ns = 0;  // sent again after this without a change; 0: as the device has it
  FixedList<PdoEntry, kMaxPdoEntries> entries;
};

// What PDO 1 to 4 has by default on node `node_id`.
[[nodiscard]] std::uint32_t default_pdo_cob_id(PdoDirection direction, std::uint8_t number,
                                               std::uint8_t node_id);

// Of what its entries hold.
[[nodiscard]] std::size_t pdo_bytes(const PdoConfig& config);

// Off, type, times, mapping cleared, entries, their number, on again: the order the standard wants. Empty
// where the entries do not fit 64 bits or are not whole bytes, or the number, COB-ID or a time is out of
// range.
using PdoWrites = FixedList<SdoWrite, kMaxPdoEntries + 7>;
[[nodiscard]] PdoWrites pdo_writes(const PdoConfig& config);

// The one that switches a PDO off.
[[nodiscard]] SdoWrite pdo_off(PdoDirection direction, std::uint8_t number, std::uint8_t node_id);

}  // namespace vergence::canopen
