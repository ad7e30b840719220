// The checks on this machine's devices: what gathers, what judges, and the drivers between them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "firmware_like/config/controller_config.hpp"
#include "tools/bringup/finding.hpp"
#include "tools/bringup/pulse_train.hpp"

namespace vergence::tools {

// A picture of each camera goes to `out`, unless that is empty.
[[nodiscard]] std::vector<Finding> check_cameras(const ControllerConfig& config, double seconds,
                                                 const std::filesystem::path& out);
// Only reads: see read_only_bus.hpp.
[[nodiscard]] std::vector<Finding> check_can(const ControllerConfig& config, double seconds);
// Takes no line but, for a moment, switches that are free inputs.
[[nodiscard]] std::vector<Finding> check_gpio(const ControllerConfig& config);
// MOVES the eyes. `loopback`: name of a line, or empty.
[[nodiscard]] std::vector<Finding> move_eyes(const ControllerConfig& config, const PulsePlan& plan,
                                             const std::string& loopback);
[[nodiscard]] std::vector<Finding> check_rt(const ControllerConfig& config, double seconds);

}  // namespace vergence::tools
