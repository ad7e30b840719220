// Options that several sub-commands share.
#pragma once

#include <CLI/CLI.hpp>
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

[[nodiscard]] inline Method parse_method(const std::string& name) {
  return name == "thesis" ? Method::kThesis : Method::kVergence;
}

}  // namespace vergence::tools
