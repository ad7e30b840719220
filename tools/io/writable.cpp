#include "tools/io/writable.hpp"

#include <fstream>

#include "tools/io/input_error.hpp"

namespace vergence::tools {

void require_writable(const std::filesystem::path& file) {
  if (!std::ofstream(file, std::ios::app)) {
    throw InputError(file, "", "cannot be written", "name a file in a folder that exists and is yours");
  }
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error || !std::filesystem::is_directory(directory)) {
    throw InputError(directory, "", "no folder can be made there", error ? error.message() : "");
  }
}

}  // namespace vergence::tools
