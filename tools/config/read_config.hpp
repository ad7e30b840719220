// The controller's configuration from TOML: the settings of the table, and the files of rig, arm, target and
// search box it names. Format and every setting: docs/config.md.
#pragma once

#include <filesystem>
#include <memory>

#include "firmware_like/config/controller_config.hpp"

namespace vergence::tools {

// What is not written has its default. Files are looked for beside the file that names them. Throws
// InputError with file, line and field.
[[nodiscard]] std::unique_ptr<ControllerConfig> read_config(const std::filesystem::path& file);

// What stands where nothing is written; also what an example begins with.
[[nodiscard]] std::unique_ptr<ControllerConfig> default_config();

}  // namespace vergence::tools
