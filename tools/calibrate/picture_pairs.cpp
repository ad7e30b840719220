#include "tools/calibrate/picture_pairs.hpp"

#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "tools/calibrate/picture_file.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;
using Pictures = std::map<int, std::filesystem::path>;

constexpr const char* kExpected =
    "expected left/000000.png and right/000000.png, or left01.jpg and right01.jpg";

std::optional<int> number_after(const std::string& stem, std::string_view prefix) {
  constexpr std::size_t kMostDigits = 9;
  if (stem.compare(0, prefix.size(), prefix) != 0) return {};
  const std::string digits = stem.substr(prefix.size());
  if (digits.empty() || digits.size() > kMostDigits ||
      digits.find_first_not_of("0123456789") != std::string::npos)
    return {};
  int number = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

Pictures pictures_in(const std::filesystem::path& folder, std::string_view prefix) {
  Pictures pictures;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::filesystem::path& path = entry.path();
    if (!is_picture(path)) continue;
    const auto number = number_after(path.stem().string(), prefix);
    if (!number) continue;
    const auto [other, is_new] = pictures.emplace(*number, path);
    if (!is_new) {
      throw InputError(path, "", "has the same number as " + other->second.filename().string(),
                       "one picture a number");
    }
  }
  if (error) throw InputError(folder, "", "no such folder", kExpected);
  return pictures;
}

// The place where the partner of `file` should be.
std::filesystem::path partner(const std::filesystem::path& file, bool in_folders, std::string_view from,
                              std::string_view to) {
  if (in_folders) return file.parent_path().parent_path() / to / file.filename();
  return file.parent_path() / (std::string(to) + file.filename().string().substr(from.size()));
}

}  // namespace

std::vector<PicturePair> list_pairs(const std::filesystem::path& directory) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(directory, ignored))
    throw InputError(directory, "", "no such folder", kExpected);
  const bool in_folders = std::filesystem::is_directory(directory / "left", ignored) ||
                          std::filesystem::is_directory(directory / "right", ignored);
  const Pictures left = in_folders ? pictures_in(directory / "left", "") : pictures_in(directory, "left");
  const Pictures right = in_folders ? pictures_in(directory / "right", "") : pictures_in(directory, "right");
  if (left.empty() && right.empty()) throw InputError(directory, "", "holds no pictures", kExpected);

  const auto missing = [&](const std::filesystem::path& path) {
    return InputError(path, "", "missing",
                      "its partner is there: " + std::to_string(left.size()) + " left pictures, " +
                          std::to_string(right.size()) + " right; take pairs, or delete the single ones");
  };
  for (const auto& [number, path] : right) {
    if (left.count(number) == 0) throw missing(partner(path, in_folders, "right", "left"));
  }
  std::vector<PicturePair> pairs;
  for (const auto& [number, path] : left) {
    const auto other = right.find(number);
    if (other == right.end()) throw missing(partner(path, in_folders, "left", "right"));
    pairs.push_back({number, {path, other->second}});
  }
  return pairs;
}

}  // namespace vergence::calibrate
