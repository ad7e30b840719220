#include "tools/io/csv.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
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

}  // namespace

Csv read_csv(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be read");
  Csv csv;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (is_blank(line)) continue;
    const auto fields = split(line);
    if (csv.columns.empty()) {
      csv.columns.assign(fields.begin(), fields.end());
      continue;
    }
    const std::string where = "line " + std::to_string(number);
    if (fields.size() != csv.columns.size()) {
      throw InputError(file, where,
                       "has " + std::to_string(fields.size()) + " fields but the header has " +
                           std::to_string(csv.columns.size()));
    }
    CsvRow row{number, {}};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0;
      const auto [end, error] = std::from_chars(fields[i].data(), fields[i].data() + fields[i].size(), value);
      if (error != std::errc{} || end != fields[i].data() + fields[i].size() || !std::isfinite(value)) {
        throw InputError(file, where + ": " + csv.columns[i],
                         "'" + std::string(fields[i]) + "' is not a finite number");
      }
      row.values.push_back(value);
    }
    csv.rows.push_back(std::move(row));
  }
  if (csv.columns.empty()) throw InputError(file, "", "is empty", "expected a header line");
  return csv;
}

}  // namespace vergence::tools
