// The numbers a run is judged by, beside what was wanted and what the thesis reached.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vergence::tools {

enum class Bound {
  kAtMost,
  kAtLeast,
};

struct Metric {
  std::string name;  // with its unit, as in the log: "hand_error_rms_mm"
  double value = 0;  // NaN where the run did not get far enough to measure it
  std::string unit;
  std::optional<double> target;
  Bound bound = Bound::kAtMost;       // which side of the target is good
  std::optional<std::string> thesis;  // what the thesis reports, a number or a few words
  std::string explanation;

  // Without a target there is nothing to miss; NaN reaches none.
  [[nodiscard]] bool met() const;
};

struct Summary {
  std::string scenario;
  std::uint64_t seed = 0;
  std::string signature;  // of the log
  double duration_s = 0;  // of what was simulated
  std::vector<Metric> metrics;

  [[nodiscard]] bool all_met() const;
};

// As summary.json: {"scenario","seed","signature","duration_s","metrics":{name:{"value","unit","target",
// "thesis","met"}}}; null where there is no target, no word of the thesis, or no finite value. Throws
// std::invalid_argument where two metrics share a name.
[[nodiscard]] std::string summary_json(const Summary& summary);

// Throws InputError where the file cannot be written.
void write_summary(const std::filesystem::path& file, const Summary& summary);

// The same for the terminal: a line a metric, in columns.
[[nodiscard]] std::string summary_text(const Summary& summary);

// A number as people read it: four significant digits, "-" for NaN; and "≤ 0.5", "-" without a target.
[[nodiscard]] std::string value_text(double value);
[[nodiscard]] std::string target_text(const Metric& metric);

}  // namespace vergence::tools
