// Gathers what the file checks judge: reads the configuration, and looks where the controller will write.
#pragma once

#include <filesystem>
#include <memory>

#include "firmware_like/config/controller_config.hpp"
#include "tools/bringup/file_checks.hpp"

namespace vergence::tools {

struct ConfigLook {
  FileObservation seen;
  std::unique_ptr<ControllerConfig> config;  // null where it cannot be read
};

// TOML, or an image. Never throws for what is wrong with the file.
[[nodiscard]] ConfigLook look_at_files(const std::filesystem::path& file);

}  // namespace vergence::tools
