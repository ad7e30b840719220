// The controller's configuration as a file of either kind, TOML or an image.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "firmware_like/config/controller_config.hpp"

namespace vergence::tools {

// By how it begins; false also where it cannot be read.
[[nodiscard]] bool is_config_image(const std::filesystem::path& file);

// Of either kind. Throws InputError.
[[nodiscard]] std::unique_ptr<ControllerConfig> read_any_config(const std::filesystem::path& file);

// What vergenced reads. Throws InputError, in which `file` stands for where the configuration came from.
[[nodiscard]] std::vector<std::byte> image_of(const std::filesystem::path& file,
                                              const ControllerConfig& config);

}  // namespace vergence::tools
