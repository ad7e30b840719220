#include "tools/bringup/finding.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace vergence::tools {

const char* to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kPass: return "pass";
    case Outcome::kWarn: return "warn";
    case Outcome::kFail: return "fail";
    case Outcome::kSkipped: return "skipped";
  }
  return "unknown";
}

Outcome worse(Outcome a, Outcome b) {
  if (a == Outcome::kFail || b == Outcome::kFail) return Outcome::kFail;
  if (a == Outcome::kWarn || b == Outcome::kWarn) return Outcome::kWarn;
  return a == Outcome::kSkipped ? b : a;
}

OutcomeCounts count(const std::vector<Finding>& findings) {
  const auto of = [&](Outcome outcome) {
    return static_cast<std::size_t>(
        std::count_if(findings.begin(), findings.end(),
                      [&](const Finding& finding) { return finding.outcome == outcome; }));
  };
  return {of(Outcome::kPass), of(Outcome::kWarn), of(Outcome::kFail), of(Outcome::kSkipped)};
}

std::string format(const char* pattern, ...) {
  std::va_list arguments;
  va_start(arguments, pattern);
  std::va_list again;
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, again);
  va_end(again);
  std::string text(static_cast<std::size_t>(std::max(length, 0)), '\0');
  if (length > 0) (void)std::vsnprintf(text.data(), text.size() + 1, pattern, arguments);
  va_end(arguments);
  return text;
}

}  // namespace vergence::tools
