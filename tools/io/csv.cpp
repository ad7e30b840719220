#include "tools/io/csv.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>

#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view field = line.substr(0, comma);
    while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
    while (!field.empty() && (field.back() == ' ' || field.back() == '\t' || field.back() == '\r')) {
      field.remove_suffix(1);
    }
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

std::optional<double> number(std::string_view field, CsvNumbers numbers) {
  const bool any = numbers == CsvNumbers::kAny;
  if (field.empty() && any) return std::numeric_limits<double>::quiet_NaN();
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc{} || end != field.data() + field.size()) return {};
  if (!any && !std::isfinite(value)) return {};
  return value;
}

}  // namespace

Csv read_csv(const std::filesystem::path& file, CsvNumbers numbers) {
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be read");
  Csv csv;
  std::string line;
  for (int line_number = 1; std::getline(in, line); ++line_number) {
    const bool blank_is_row = numbers == CsvNumbers::kAny && csv.columns.size() == 1;
    if (is_blank(line) && !blank_is_row) continue;
    const auto fields = split(line);
    if (csv.columns.empty()) {
      csv.columns.assign(fields.begin(), fields.end());
      continue;
    }
    const std::string where = "line " + std::to_string(line_number);
    if (fields.size() != csv.columns.size()) {
      throw InputError(file, where,
                       "has " + std::to_string(fields.size()) + " fields but the header has " +
                           std::to_string(csv.columns.size()));
    }
    CsvRow row{line_number, {}};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const std::optional<double> value = number(fields[i], numbers);
      if (!value) {
        throw InputError(file, where + ": " + csv.columns[i],
                         "'" + std::string(fields[i]) + "' is not a " +
                             (numbers == CsvNumbers::kFinite ? "finite " : "") + "number");
      }
      row.values.push_back(*value);
    }
    csv.rows.push_back(std::move(row));
  }
  if (csv.columns.empty()) throw InputError(file, "", "is empty", "expected a header line");
  return csv;
}

}  // namespace vergence::tools
