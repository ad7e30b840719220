// rig.toml, as docs/formats.md describes it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "algo/camera_model.hpp"

namespace vergence::calibrate {

// `notes` stand as comments at the top. Throws InputError where the file cannot be written. A file that is
// there is replaced whole or not at all.
void write_rig(const std::filesystem::path& file, const StereoRig& rig,
               const std::vector<std::string>& notes);

}  // namespace vergence::calibrate
