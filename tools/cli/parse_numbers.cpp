#include "tools/cli/parse_numbers.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

namespace vergence::tools {

std::vector<double> parse_numbers(const std::string& option, const std::string& text, char separator,
                                  std::size_t count) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || !std::isfinite(value) || (next != end && *next != separator)) break;
    numbers.push_back(value);
    if (next == end) {
      if (numbers.size() == count) return numbers;
      break;
    }
    at = next + 1;
  }
  throw CLI::ValidationError(option, "'" + text + "' is not " +
                                         (count == 1 ? "a number" : std::to_string(count) + " numbers") +
                                         (count > 1 ? std::string(" with ") + separator + " between" : ""));
}

}  // namespace vergence::tools
