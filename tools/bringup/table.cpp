#include "tools/bringup/table.hpp"

#include <nlohmann/json.hpp>

namespace vergence::tools {
namespace {

constexpr int kGroupWidth = 8;
constexpr int kCheckWidth = 26;

}  // namespace

std::string table_of(const std::vector<Finding>& findings) {
  std::string table;
  for (const Finding& finding : findings) {
    const char* const outcome = finding.outcome == Outcome::kFail ? "FAIL" : to_string(finding.outcome);
    const bool is_skipped = finding.outcome == Outcome::kSkipped;
    const std::string& said = is_skipped ? finding.remedy : finding.measured;
    std::string line = format("%-*s %-*s %-8s %s", kGroupWidth, finding.group.c_str(), kCheckWidth,
                              finding.check.c_str(), outcome, said.c_str());
    line.erase(line.find_last_not_of(' ') + 1);
    table += line + '\n';
    if (!finding.remedy.empty() && !is_skipped)
      table += format("%*s-> %s\n", kGroupWidth + 1, "", finding.remedy.c_str());
  }
  return table;
}

std::string summary_of(const std::vector<Finding>& findings) {
  const OutcomeCounts counts = count(findings);
  return format("%zu passed, %zu warning%s, %zu failed, %zu skipped", counts.passed, counts.warnings,
                counts.warnings == 1 ? "" : "s", counts.failed, counts.skipped);
}

nlohmann::json json_of(const std::vector<Finding>& findings) {
  const OutcomeCounts counts = count(findings);
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"group", finding.group},
                    {"check", finding.check},
                    {"outcome", to_string(finding.outcome)},
                    {"measured", finding.measured},
                    {"remedy", finding.remedy}});
  }
  return {{"passed", counts.passed},
          {"warnings", counts.warnings},
          {"failed", counts.failed},
          {"skipped", counts.skipped},
          {"findings", list}};
}

}  // namespace vergence::tools
