// What a check found: one line for people who set a robot up, with the value that was measured and what to
// do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace vergence::tools {

enum class Outcome : std::uint8_t {
  kPass,
  kWarn,  // it works, and may stop to
  kFail,
  kSkipped,  // nothing is known
};
[[nodiscard]] const char* to_string(Outcome outcome);

struct Finding {
  std::string group;  // cameras, can, ...
  std::string check;  // what was looked at
  Outcome outcome = Outcome::kSkipped;
  std::string measured;
  std::string remedy;  // empty where it passed; of what was skipped, why

  bool operator==(const Finding&) const = default;
};

// The findings of one group, as they are made.
class Findings {
 public:
  explicit Findings(std::string group) : group_(std::move(group)) {}

  void pass(std::string check, std::string measured) {
    add({group_, std::move(check), Outcome::kPass, std::move(measured), ""});
  }
  void warn(std::string check, std::string measured, std::string remedy) {
    add({group_, std::move(check), Outcome::kWarn, std::move(measured), std::move(remedy)});
  }
  void fail(std::string check, std::string measured, std::string remedy) {
    add({group_, std::move(check), Outcome::kFail, std::move(measured), std::move(remedy)});
  }
  void skip(std::string check, std::string why) {
    add({group_, std::move(check), Outcome::kSkipped, "", std::move(why)});
  }
  // The remedy goes where it passed.
  void judge(Outcome outcome, std::string check, std::string measured, std::string remedy) {
    if (outcome == Outcome::kPass) remedy.clear();
    add({group_, std::move(check), outcome, std::move(measured), std::move(remedy)});
  }

  [[nodiscard]] std::vector<Finding> take() { return std::move(all_); }

 private:
  void add(Finding finding) { all_.push_back(std::move(finding)); }

  std::string group_;
  std::vector<Finding> all_;
};

// kFail above kWarn above the others.
[[nodiscard]] Outcome worse(Outcome a, Outcome b);

struct OutcomeCounts {
  std::size_t passed = 0;
  std::size_t warnings = 0;
  std::size_t failed = 0;
  std::size_t skipped = 0;
};
[[nodiscard]] OutcomeCounts count(const std::vector<Finding>& findings);

// printf into a string.
[[nodiscard, gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

}  // namespace vergence::tools
