#include "hal/canopen/bus_load.hpp"

#include "hal/clock.hpp"

namespace vergence::canopen {
namespace {

constexpr std::int64_t kProcessDataBytes = 6;  // control or status word, and velocity or position

}  // namespace

std::int64_t bus_load_permille(const CanopenArmConfig& config, std::int64_t bit_per_s) {
  const std::int64_t axes = config.axes;
  const std::int64_t period_bits = longest_frame_bits(0) + 2 * axes * longest_frame_bits(kProcessDataBytes);
  const std::int64_t heartbeat_bits = (axes + 1) * longest_frame_bits(1);
  const auto per_s = [](std::int64_t bits, std::int64_t period_ns) {
    return bits * kNsPerSecond / period_ns;
  };
  const std::int64_t bits_per_s =
      per_s(period_bits, config.sync_period_ns) + per_s(heartbeat_bits, config.heartbeat_ns);
  return bits_per_s * 1000 / bit_per_s;
}

}  // namespace vergence::canopen
