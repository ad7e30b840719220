// How much of its CAN buses an arm takes, at worst: every frame stuffed with as many bits as it may need.
#pragma once

#include <cstdint>

#include "hal/canopen/arm_config.hpp"

namespace vergence::canopen {

// What is left is for words of the state machine, SDO transfers, emergencies and frames sent again.
inline constexpr std::int64_t kMostBusLoad_permille = 800;

// Of a data frame with an 11-bit identifier and `bytes` of data, with the pause after it: 47 bits and the
// data; of 34 bits and the data, one more after each four may be stuffed.
[[nodiscard]] constexpr std::int64_t longest_frame_bits(std::int64_t bytes) {
  return 47 + 8 * bytes + (34 + 8 * bytes - 1) / 4;
}

// In steady motion: SYNC, the PDOs of each period, those with an event timer as often as that says, and the
// heartbeats of the bus's drives and of the master. A frame with two targets counts once. Of a config that
// passed check().
[[nodiscard]] std::int64_t bus_load_permille(const CanopenArmConfig& config, int bus, std::int64_t bit_per_s);

}  // namespace vergence::canopen
