// What the controller kept of a fault, unpacked for people.
#pragma once

#include <cstddef>
#include <filesystem>

namespace vergence::tools {

struct BoxSummary {
  std::size_t records = 0;
  std::size_t pairs = 0;
  double fault_s = 0;
};

// Writes out/log.csv, a row a period, and out/pictures/NNNN_left.png and _right.png. Throws InputError where
// the file is none, of another version, cut short or corrupted; then nothing is written.
[[nodiscard]] BoxSummary unpack_black_box(const std::filesystem::path& file,
                                          const std::filesystem::path& out);

}  // namespace vergence::tools
