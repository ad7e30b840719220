// Data sets small enough to be written, broken and read many times in a test.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "algo/pose.hpp"

namespace vergence::test {

// A new directory, gone with this object.
class TempDirectory {
 public:
  TempDirectory();
  ~TempDirectory();
  TempDirectory(const TempDirectory&) = delete;
  TempDirectory& operator=(const TempDirectory&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(std::string_view name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline constexpr int kSmallFrames = 3;

// T_H_M of a frame: upright, moving 4 mm a frame.
[[nodiscard]] Pose small_pose(int frame);

// kSmallFrames frames of 320 x 240 with truth: a coloured card, or three balls, before a plain background.
void write_small_photo_dataset(const std::filesystem::path& directory);
void write_small_marker_dataset(const std::filesystem::path& directory);

[[nodiscard]] std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, std::string_view content);
// Replaces the first `from`, which must be there.
void replace_in_file(const std::filesystem::path& file, std::string_view from, std::string_view to);

}  // namespace vergence::test
