// Finds one verdict among many, and what every list of findings must be.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "tools/bringup/finding.hpp"
#include "tools/bringup/table.hpp"

namespace vergence::tools {

inline void PrintTo(Outcome outcome, std::ostream* out) {
  *out << to_string(outcome);
}

}  // namespace vergence::tools

namespace vergence::testing {

using tools::Finding;
using tools::Outcome;
// A finding of its own, which matches nothing, where there is no such check.
inline Finding finding_of(const std::vector<Finding>& findings, const std::string& check) {
  for (const Finding& finding : findings) {
    if (finding.check == check) return finding;
  }
  ADD_FAILURE() << "no check '" << check << "' in\n" << tools::table_of(findings);
  return {"", "", Outcome::kSkipped, "missing", "missing"};
}

// Each check once; whatever did not pass says what to do, and whatever was looked at what it saw.
inline void expect_complete(const std::vector<Finding>& findings) {
  std::set<std::string> checks;
  for (const Finding& finding : findings) {
    EXPECT_TRUE(checks.insert(finding.group + finding.check).second) << finding.check << " twice";
    EXPECT_EQ(finding.remedy.empty(), finding.outcome == Outcome::kPass) << finding.check;
    EXPECT_EQ(finding.measured.empty(), finding.outcome == Outcome::kSkipped) << finding.check;
  }
}

// The verdict, a part of what was measured, and a part of what to do.
inline void expect_finding(const std::vector<Finding>& findings, const std::string& check, Outcome outcome,
                           const std::string& measured = "", const std::string& remedy = "") {
  const Finding finding = finding_of(findings, check);
  EXPECT_EQ(finding.outcome, outcome) << tools::table_of({finding});
  EXPECT_NE(finding.measured.find(measured), std::string::npos) << measured << " in " << finding.measured;
  EXPECT_NE(finding.remedy.find(remedy), std::string::npos) << remedy << " in " << finding.remedy;
}

inline void expect_all_pass(const std::vector<Finding>& findings) {
  EXPECT_TRUE(std::all_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.outcome == Outcome::kPass;
  })) << tools::table_of(findings);
}

}  // namespace vergence::testing
