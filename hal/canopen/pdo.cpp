#include "hal/canopen/pdo.hpp"

#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

std::uint16_t communication_index(PdoDirection direction, std::uint8_t number) {
  return static_cast<std::uint16_t>((direction == PdoDirection::kToDrive ? 0x1400 : 0x1800) + number - 1);
}

}  // namespace

std::uint32_t default_pdo_cob_id(PdoDirection direction, std::uint8_t number, std::uint8_t node_id) {
  const std::uint32_t first = direction == PdoDirection::kToDrive ? kRpdo1CobId : kTpdo1CobId;
  return first + 0x100U * (number - 1U) + node_id;
}

PdoWrites pdo_writes(const PdoConfig& config) {
  PdoWrites writes;
  unsigned bits = 0;
  bool whole_bytes = true;
  for (const PdoEntry& entry : config.entries) {
    bits += entry.bits;
    whole_bytes = whole_bytes && entry.bits > 0 && entry.bits % 8 == 0;
  }
  const bool number_known = config.number >= 1 && config.number <= kPdos;
  if (!number_known || bits == 0 || bits > 64 || !whole_bytes || config.cob_id < 0x181 ||
      config.cob_id > 0x57F) {
    return writes;
  }
  const std::uint16_t communication = communication_index(config.direction, config.number);
  const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
  const std::uint32_t on =
      config.direction == PdoDirection::kFromDrive ? config.cob_id | kPdoNoRemote : config.cob_id;
  writes.add({communication, 1, 4, on | kPdoOff});
  writes.add({communication, 2, 1, config.transmission});
  writes.add({mapping, 0, 1, 0});
  std::uint8_t sub = 0;
  for (const PdoEntry& entry : config.entries) {
    const std::uint32_t object =
        std::uint32_t{entry.index} << 16 | std::uint32_t{entry.sub} << 8 | entry.bits;
    writes.add({mapping, ++sub, 4, object});
  }
  writes.add({mapping, 0, 1, sub});
  writes.add({communication, 1, 4, on});
  return writes;
}

SdoWrite pdo_off(PdoDirection direction, std::uint8_t number, std::uint8_t node_id) {
  return {communication_index(direction, number), 1, 4,
          default_pdo_cob_id(direction, number, node_id) | kPdoOff};
}

}  // namespace vergence::canopen
