#include "tools/bringup/table.hpp"

#include <nlohmann/json.hpp>

namespace vergence::tools {
namespace {

constexpr int kGroupWidth = 8;
constexpr int kCheckWidth = 26;

// So many that were skipped for one reason in a row are one line.
constexpr std::size_t kManySkipped = 3;

// How many findings from `first` on were skipped for the same reason.
std::size_t skipped_alike(const std::vector<Finding>& findings, std::size_t first) {
  std::size_t end = first;
  while (end < findings.size() && findings[end].outcome == Outcome::kSkipped &&
         findings[end].group == findings[first].group && findings[end].remedy == findings[first].remedy) {
    ++end;
  }
  return end - first;
}

std::string row(const Finding& finding, const std::string& check, const std::string& said) {
  const char* const outcome = finding.outcome == Outcome::kFail ? "FAIL" : to_string(finding.outcome);
  std::string line = format("%-*s %-*s %-8s %s", kGroupWidth, finding.group.c_str(), kCheckWidth,
                            check.c_str(), outcome, said.c_str());
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

}  // namespace

std::string table_of(const std::vector<Finding>& findings) {
  std::string table;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const Finding& finding = findings[i];
    if (finding.outcome != Outcome::kSkipped) {
      table += row(finding, finding.check, finding.measured);
      if (!finding.remedy.empty()) table += format("%*s-> %s\n", kGroupWidth + 1, "", finding.remedy.c_str());
      continue;
    }
    const std::size_t alike = skipped_alike(findings, i);
    if (alike < kManySkipped) {
      table += row(finding, finding.check, finding.remedy);
      continue;
    }
    const std::string range = finding.check + " to " + findings[i + alike - 1].check;
    table += row(finding, format("%zu checks", alike), range + ": " + finding.remedy);
    i += alike - 1;
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
