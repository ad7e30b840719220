#include "tools/rig/trace_reader.hpp"

#include <fcntl.h>

#include <array>
#include <charconv>
#include <fstream>
#include <sstream>

#include "tools/rig/rig_error.hpp"

namespace vergence::rig {
namespace {

constexpr int kMostLines = 64;

template <typename T>
bool take_number(std::string_view& text, T& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

bool take_word(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

}  // namespace

std::optional<Edge> parse_edge(std::string_view text, int first_number) {
  constexpr std::string_view kEvent = ": gpio_value: ";
  const std::size_t event = text.find(kEvent);
  if (event == std::string_view::npos) return std::nullopt;
  std::string_view stamp = text.substr(0, event);
  const std::size_t blank = stamp.rfind(' ');
  if (blank != std::string_view::npos) stamp.remove_prefix(blank + 1);
  std::int64_t whole_s = 0;
  std::int64_t micros = 0;
  // Six digits behind the point.
  const std::size_t point = stamp.find('.');
  if (point == std::string_view::npos || stamp.size() - point - 1 != 6) return std::nullopt;
  if (!take_number(stamp, whole_s) || !take_word(stamp, ".") || !take_number(stamp, micros))
    return std::nullopt;

  std::string_view rest = text.substr(event + kEvent.size());
  int number = 0;
  int level = 0;
  if (!take_number(rest, number) || !take_word(rest, " set ") || !take_number(rest, level))
    return std::nullopt;
  const int line = number - first_number;
  if (line < 0 || line >= kMostLines) return std::nullopt;
  return Edge{whole_s * 1'000'000'000 + micros * 1000, line, level != 0};
}

std::optional<Capture> parse_capture(std::string_view text) {
  const auto number_behind = [text](std::string_view word, auto& number) {
    const std::size_t at = text.find(word);
    if (at == std::string_view::npos) return false;
    std::string_view rest = text.substr(at + word.size());
    return take_number(rest, number);
  };
  Capture capture;
  if (text.find(": v4l2_dqbuf: ") == std::string_view::npos || !number_behind("minor = ", capture.minor) ||
      !number_behind(", timestamp = ", capture.stamp_ns)) {
    return std::nullopt;
  }
  return capture;
}

std::optional<int> first_number_of(std::string_view chips, std::string_view label) {
  // `gpiochip0: GPIOs 499-511, parent: platform/gpio-sim.0, LABEL, can sleep:`
  std::istringstream lines{std::string(chips)};
  const std::string wanted = ", " + std::string(label);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find(wanted);
    const std::size_t end = at + wanted.size();
    if (!line.starts_with("gpiochip") || at == std::string::npos) continue;
    if (end < line.size() && line[end] != ',' && line[end] != ':') continue;
    constexpr std::string_view kNumbers = ": GPIOs ";
    const std::size_t numbers = line.find(kNumbers);
    if (numbers == std::string::npos) continue;
    std::string_view text = std::string_view(line).substr(numbers + kNumbers.size());
    int first = 0;
    if (take_number(text, first)) return first;
  }
  return std::nullopt;
}

TraceReader::TraceReader(const char* chip_label) {
  const char* const chips_file = "/sys/kernel/debug/gpio";
  std::ifstream chips(chips_file);
  std::stringstream text;
  text << chips.rdbuf();
  const std::optional<int> first = first_number_of(text.str(), chip_label);
  if (!first) {
    throw RigError(std::string("no GPIO chip '") + chip_label + "' in " + chips_file +
                   ": is gpio-sim set up?");
  }
  first_number_ = *first;
  const char* const trace = "/sys/kernel/tracing/trace_pipe";
  trace_ = FileHandle(::open(trace, O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!trace_.is_open()) fail_with_errno(trace);
}

void TraceReader::take(std::string_view line) {
  if (const std::optional<Edge> edge = parse_edge(line, first_number_)) {
    const std::uint64_t bit = std::uint64_t{1} << edge->line;
    if (((levels_ & bit) != 0) == edge->level) return;
    levels_ ^= bit;
    edges_.push_back(*edge);
  } else if (const std::optional<Capture> capture = parse_capture(line)) {
    captures_.push_back(*capture);
  }
}

void TraceReader::read() {
  edges_.clear();
  captures_.clear();
  std::array<char, 8192> buffer{};
  for (ssize_t got = 0; (got = ::read(trace_.get(), buffer.data(), buffer.size())) > 0;) {
    rest_.append(buffer.data(), static_cast<std::size_t>(got));
  }
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    take(std::string_view(rest_).substr(begin, end - begin));
  }
  rest_.erase(0, begin);
}

}  // namespace vergence::rig
