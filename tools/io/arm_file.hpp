// A serial arm from TOML: its Denavit-Hartenberg rows, limits and mounting. Format: docs/formats.md.
#pragma once

#include <filesystem>

#include "algo/arm_kinematics.hpp"

namespace vergence::tools {

// Throws InputError naming file, line and field.
[[nodiscard]] SerialArm read_arm(const std::filesystem::path& file);

}  // namespace vergence::tools
