// What a drive is told and asked before it may be started, as a table of SDO transfers.
#pragma once

#include <cstdint>

#include "hal/canopen/arm_config.hpp"
#include "hal/canopen/pdo.hpp"

namespace vergence::canopen {

enum class BootStepKind : std::uint8_t {
  kWrite,
  kWriteIfThere,  // the drive may not have the object
  kExpect,        // read; under the mask it must be the value
  kReadHoming,    // read a statusword in homing mode
};

struct BootStep {
  BootStepKind kind = BootStepKind::kWrite;
  SdoWrite object;  // of a read: index, sub and the value that is expected
  std::uint32_t mask = 0xFFFFFFFF;
};

using BootScript = FixedList<BootStep, 56>;

// The one that sets the statusword's event timer. A drive without one must be asked for the statusword.
[[nodiscard]] bool is_statusword_timer(const BootStep& step);

// Of a config that passed check().
[[nodiscard]] BootScript boot_script(const CanopenArmConfig& config, int axis);

}  // namespace vergence::canopen
