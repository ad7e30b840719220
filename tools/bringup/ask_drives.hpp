// Gathers what the checks of the bus judge, by listening and by reading objects: no drive is started,
// switched on or changed.
#pragma once

#include "hal/canopen/arm_config.hpp"
#include "tools/bringup/can_checks.hpp"
#include "tools/bringup/read_only_bus.hpp"

namespace vergence::tools {

// Listens for so long, asks all nodes once who is there, then each drive configured on the bus of this
// number. What the interface itself says (CanObservation::link) is left to the caller.
[[nodiscard]] CanObservation ask_drives(ReadOnlyBus& bus, const canopen::CanopenArmConfig& config,
                                        double seconds, int number = 0);

}  // namespace vergence::tools
