#include "hal/canopen/pdo.hpp"

#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

constexpr std::int64_t kNsPerInhibitStep = 100'000;
constexpr std::int64_t kNsPerTimerStep = 1'000'000;

// 16 bits of such steps.
bool is_in_steps(std::int64_t ns, std::int64_t step_ns) {
  return ns >= 0 && ns <= 0xFFFF * step_ns && ns % step_ns == 0;
}

std::uint16_t communication_index(PdoDirection direction, std::uint8_t number) {
  return static_cast<std::uint16_t>((direction == PdoDirection::kToDrive ? 0x1400 : 0x1800) + number - 1);
}

}  // namespace

std::uint32_t default_pdo_cob_id(PdoDirection direction, std::uint8_t number, std::uint8_t node_id) {
  const std::uint32_t first = direction == PdoDirection::kToDrive ? kRpdo1CobId : kTpdo1CobId;
  return first + 0x100U * (number - 1U) + node_id;
}

std::size_t pdo_bytes(const PdoConfig& config) {
  std::size_t bits = 0;
  for (const PdoEntry& entry : config.entries) bits += entry.bits;
  return bits / 8;
}

PdoWrites pdo_writes(const PdoConfig& config) {
  PdoWrites writes;
  bool whole_bytes = true;
  for (const PdoEntry& entry : config.entries) {
    whole_bytes = whole_bytes && entry.bits > 0 && entry.bits % 8 == 0;
  }
  const std::size_t bytes = pdo_bytes(config);
  const bool number_known = config.number >= 1 && config.number <= kPdos;
  const bool times_fit = is_in_steps(config.inhibit_ns, kNsPerInhibitStep) &&
                         is_in_steps(config.event_timer_ns, kNsPerTimerStep);
  if (!number_known || bytes == 0 || bytes > 8 || !whole_bytes || !times_fit || config.cob_id < 0x181 ||
      config.cob_id > 0x57F) {
    return writes;
  }
  const std::uint16_t communication = communication_index(config.direction, config.number);
  const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
  const std::uint32_t on =
      config.direction == PdoDirection::kFromDrive ? config.cob_id | kPdoNoRemote : config.cob_id;
  writes.add({communication, 1, 4, on | kPdoOff});
  writes.add({communication, 2, 1, config.transmission});
  if (config.inhibit_ns > 0) {
    const auto steps = static_cast<std::uint32_t>(config.inhibit_ns / kNsPerInhibitStep);
    writes.add({communication, kPdoInhibitSub, 2, steps, true});
  }
  if (config.event_timer_ns > 0) {
    const auto steps = static_cast<std::uint32_t>(config.event_timer_ns / kNsPerTimerStep);
    writes.add({communication, kPdoTimerSub, 2, steps, true});
  }
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
