// Findings as a table for people and as JSON for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/bringup/finding.hpp"

namespace vergence::tools {

// A line each, and the remedy on a line of its own below it; of what was skipped, why, in one line where that
// is the same for three or more in a row. Failures in capitals.
[[nodiscard]] std::string table_of(const std::vector<Finding>& findings);
// "31 passed, 2 warnings, 1 failed, 4 skipped"
[[nodiscard]] std::string summary_of(const std::vector<Finding>& findings);
[[nodiscard]] nlohmann::json json_of(const std::vector<Finding>& findings);

}  // namespace vergence::tools
