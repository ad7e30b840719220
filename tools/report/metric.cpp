#include "tools/report/metric.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

using Json = nlohmann::ordered_json;

// A number where the thesis gives one, so that scripts can compare.
Json thesis_json(const std::optional<std::string>& thesis) {
  if (!thesis) return nullptr;
  double value = 0;
  const char* const end = thesis->data() + thesis->size();
  const auto parsed = std::from_chars(thesis->data(), end, value);
  if (parsed.ec == std::errc{} && parsed.ptr == end && std::isfinite(value)) return value;
  return *thesis;
}

using Cells = std::array<std::string, 6>;

// On a terminal; every code point of UTF-8 taken as one column wide.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

bool Metric::met() const {
  if (!target) return true;
  return bound == Bound::kAtMost ? value <= *target : value >= *target;
}

bool Summary::all_met() const {
  return std::all_of(metrics.begin(), metrics.end(), [](const Metric& metric) { return metric.met(); });
}

std::string summary_json(const Summary& summary) {
  Json metrics = Json::object();
  for (const Metric& metric : summary.metrics) {
    if (metrics.contains(metric.name)) throw std::invalid_argument("two metrics named '" + metric.name + "'");
    metrics[metric.name] = {{"value", metric.value},
                            {"unit", metric.unit},
                            {"target", metric.target ? Json(*metric.target) : Json(nullptr)},
                            {"thesis", thesis_json(metric.thesis)},
                            {"met", metric.met()}};
  }
  const Json json = {{"scenario", summary.scenario},
                     {"seed", summary.seed},
                     {"signature", summary.signature},
                     {"duration_s", summary.duration_s},
                     {"metrics", metrics}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_summary(const std::filesystem::path& file, const Summary& summary) {
  const std::string json = summary_json(summary);
  require_writable(file);
  std::ofstream out(file, std::ios::binary);
  out << json;
  if (!out.flush()) throw InputError(file, "", "cannot be written to its end", "is the disk full?");
}

std::string value_text(double value) {
  if (std::isnan(value)) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string target_text(const Metric& metric) {
  if (!metric.target) return "-";
  return (metric.bound == Bound::kAtMost ? "≤ " : "≥ ") + value_text(*metric.target);
}

std::string summary_text(const Summary& summary) {
  std::vector<Cells> rows{{"metric", "value", "unit", "target", "thesis", ""}};
  for (const Metric& metric : summary.metrics) {
    const char* const judged = !metric.target ? "" : metric.met() ? "met" : "not reached";
    rows.push_back({metric.name, value_text(metric.value), metric.unit, target_text(metric),
                    metric.thesis.value_or("-"), judged});
  }
  std::array<std::size_t, 6> widths{};
  for (const Cells& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  std::string text = summary.scenario + ", seed " + std::to_string(summary.seed) + ", " +
                     value_text(summary.duration_s) + " s, signature " + summary.signature + "\n";
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::size_t blanks = widths[i] - width(row[i]);
      const bool to_the_right = i == 1;
      line.append(to_the_right ? 2 + blanks : 2, ' ').append(row[i]);
      if (!to_the_right) line.append(blanks, ' ');
    }
    text.append(line, 0, line.find_last_not_of(' ') + 1).append("\n");
  }
  return text;
}

}  // namespace vergence::tools
