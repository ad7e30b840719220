// The process data of an axis: which objects travel in which PDO, and when. One table for what a drive is
// told at boot, for what the master sends and takes, and for the load of the bus, so that they agree.
#pragma once

#include <array>

#include "hal/canopen/arm_config.hpp"
#include "hal/canopen/pdo.hpp"

namespace vergence::canopen {

// What changes every period travels with each SYNC; the state machine's words travel as they change, so that
// in steady motion they cost nothing but the statusword's event timer.
struct AxisPdos {
  PdoConfig target;       // RPDO 1: a velocity or a position, acts with SYNC; maybe beside another axis's
  PdoConfig controlword;  // RPDO 2: acts at once
  PdoConfig position;     // TPDO 1: sampled with SYNC
  PdoConfig statusword;   // TPDO 2

  [[nodiscard]] std::array<const PdoConfig*, 4> all() const& {
    return {&target, &controlword, &position, &statusword};
  }
  std::array<const PdoConfig*, 4> all() && = delete;  // they would be gone
};

// The 8 bytes of a frame hold two targets.
inline constexpr int kTargetsPerFrame = 2;
inline constexpr std::uint8_t kTargetBytes = 4;

// The axis in whose frame the target of this one travels: itself, or where targets are shared, of the axes of
// its bus taken two by two, the first.
[[nodiscard]] int target_leader(const CanopenArmConfig& config, int axis);
// Byte of that frame at which it begins.
[[nodiscard]] std::uint8_t target_offset(const CanopenArmConfig& config, int axis);

// Of an axis whose node id is in range.
[[nodiscard]] AxisPdos axis_pdos(const CanopenArmConfig& config, int axis);

}  // namespace vergence::canopen
