// Places where the user wants something written, checked before the work and not after it.
#pragma once

#include <filesystem>

namespace vergence::tools {

// Throws InputError where the file cannot be opened for writing. What it held is kept.
void require_writable(const std::filesystem::path& file);

// The directory, made with its parents where it is not there. Throws InputError.
void make_directory(const std::filesystem::path& directory);

}  // namespace vergence::tools
