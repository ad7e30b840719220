// Options that several sub-commands share.
#pragma once

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

#include "algo/tracker.hpp"

namespace vergence::tools {

inline void add_method_option(CLI::App& command, std::string& method) {
  command
      .add_option("--method", method,
                  "vergence, or thesis: votes of hue alone, any saturation (for comparison)")
      ->check(CLI::IsMember({"vergence", "thesis"}))
      ->capture_default_str();
}

// A number in [low, high]; unlike CLI::Range, not nan.
[[nodiscard]] inline CLI::Validator within(double low, double high) {
  std::ostringstream range;
  range << "[" << low << ", " << high << "]";
  return {[low, high, text = range.str()](std::string& input) -> std::string {
            double value = 0;
            const bool good = CLI::detail::lexical_cast(input, value) && value >= low && value <= high;
            return good ? "" : input + " is not in " + text;
          },
          range.str()};
}

[[nodiscard]] inline Method parse_method(const std::string& name) {
  return name == "thesis" ? Method::kThesis : Method::kVergence;
}

}  // namespace vergence::tools
