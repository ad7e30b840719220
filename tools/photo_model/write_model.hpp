// A photo-model's directory on disk, as `read_target()` reads it.
#pragma once

#include <filesystem>

#include "tools/io/dataset.hpp"

namespace vergence::tools {

// Writes model.toml, photo.png, background.png and, where the target has one, mask.png into an existing
// directory. Throws InputError where that fails.
void write_photo_model(const std::filesystem::path& directory, const Target& target,
                       const RgbImage& background);

}  // namespace vergence::tools
