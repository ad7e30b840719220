// A configuration in words, and what every setting means.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/config/controller_config.hpp"

namespace vergence::tools {

// Every setting as TOML with its meaning behind it, where it differs from its default marked so; and in
// comments what came from other files, and what follows from it.
[[nodiscard]] std::string show_config(const ControllerConfig& config);

// Of each bus its name, axes and load at worst; none without an arm.
[[nodiscard]] std::vector<std::string> bus_loads(const ControllerConfig& config);

// The table of settings as Markdown: key, default, range, meaning.
[[nodiscard]] std::string describe_settings();

}  // namespace vergence::tools
