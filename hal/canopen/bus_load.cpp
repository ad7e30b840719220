#include "hal/canopen/bus_load.hpp"

#include "hal/canopen/axis_pdos.hpp"
#include "hal/clock.hpp"

namespace vergence::canopen {
namespace {

std::int64_t per_s(std::int64_t bits, std::int64_t period_ns) {
  return bits * kNsPerSecond / period_ns;
}

std::int64_t bits_per_s(const PdoConfig& pdo, std::int64_t sync_period_ns) {
  const std::int64_t bits = longest_frame_bits(static_cast<std::int64_t>(pdo_bytes(pdo)));
  if (pdo.transmission == kEverySync) return per_s(bits, sync_period_ns);
  return pdo.event_timer_ns > 0 ? per_s(bits, pdo.event_timer_ns) : 0;
}

}  // namespace

std::int64_t bus_load_permille(const CanopenArmConfig& config, int bus, std::int64_t bit_per_s) {
  std::int64_t sum = per_s(longest_frame_bits(0), config.sync_period_ns);
  int nodes = 1;
  for (int i = 0; i < config.axes; ++i) {
    if (config.axis[static_cast<std::size_t>(i)].bus != bus) continue;
    ++nodes;
    const AxisPdos pdos = axis_pdos(config, i);
    for (const PdoConfig* pdo : pdos.all()) {
      const bool is_in_another = pdo == &pdos.target && target_leader(config, i) != i;
      if (!is_in_another) sum += bits_per_s(*pdo, config.sync_period_ns);
    }
  }
  sum += per_s(nodes * longest_frame_bits(1), config.heartbeat_ns);
  return sum * 1000 / bit_per_s;
}

}  // namespace vergence::canopen
