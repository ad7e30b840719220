#include "tools/cli/frame_range.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>
#include <string_view>

namespace vergence::tools {
namespace {

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0) return {};
  return value;
}

}  // namespace

FrameRange parse_frame_range(const std::string& text) {
  const auto number = [&](std::string_view part) {
    const auto value = whole_number(part);
    if (!value) throw CLI::ValidationError("--frames", "'" + text + "' is not A:B, A:, :B or A");
    return *value;
  };
  FrameRange range;
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) {
    range.first = number(text);
    range.end = range.first == std::numeric_limits<int>::max() ? range.first : range.first + 1;
    return range;
  }
  const std::string_view whole = text;
  if (colon > 0) range.first = number(whole.substr(0, colon));
  if (colon + 1 < text.size()) range.end = number(whole.substr(colon + 1));
  if (range.first >= range.end) throw CLI::ValidationError("--frames", "'" + text + "' holds no frame");
  return range;
}

}  // namespace vergence::tools
