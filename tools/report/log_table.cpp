#include "tools/report/log_table.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "tools/io/csv.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

class Fnv1a {
 public:
  void add_byte(std::uint64_t byte) {
    hash_ ^= byte;
    hash_ *= 0x100000001B3ULL;
  }
  void add(std::string_view text) {
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
    add_byte(0);  // "ab","c" is not "a","bc"
  }
  void add(double value) {
    const double kept = std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value;
    const auto bits = std::bit_cast<std::uint64_t>(kept);
    for (int shift = 0; shift < 64; shift += 8) add_byte((bits >> shift) & 0xFF);
  }
  [[nodiscard]] std::string hex() const {
    std::string text(16, '0');
    for (std::size_t i = 0; i < text.size(); ++i) text[i] = "0123456789abcdef"[(hash_ >> (60 - 4 * i)) & 0xF];
    return text;
  }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

void append_number(std::string& text, double value) {
  if (std::isnan(value)) return;
  char digits[32];
  const auto end = std::to_chars(std::begin(digits), std::end(digits), value).ptr;
  text.append(digits, end);
}

}  // namespace

LogTable::LogTable(std::vector<std::string> columns) : names_(std::move(columns)), values_(names_.size()) {
  if (names_.empty()) throw std::invalid_argument("a log table without columns");
  for (auto name = names_.begin(); name != names_.end(); ++name) {
    if (name->empty() || name->find_first_of(" \t\r\n,\"") != std::string::npos) {
      throw std::invalid_argument("'" + *name + "' is no name for a column: blanks, commas or quotes");
    }
    if (std::find(names_.begin(), name, *name) != name) {
      throw std::invalid_argument("two columns named '" + *name + "'");
    }
  }
}

void LogTable::append(std::span<const double> row) {
  if (row.size() != names_.size()) {
    throw std::invalid_argument("a row of " + std::to_string(row.size()) + " values for " +
                                std::to_string(names_.size()) + " columns");
  }
  for (std::size_t i = 0; i < row.size(); ++i) values_[i].push_back(row[i]);
}

bool LogTable::has_column(std::string_view name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

const std::vector<double>& LogTable::column(std::string_view name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) throw std::invalid_argument("the log has no column '" + std::string(name) + "'");
  return values_[static_cast<std::size_t>(found - names_.begin())];
}

void LogTable::write_csv(const std::filesystem::path& file) const {
  require_writable(file);
  std::ofstream out(file, std::ios::binary);
  std::string line;
  for (const std::string& name : names_) line += (line.empty() ? "" : ",") + name;
  out << line << '\n';
  for (std::size_t row = 0; row < rows(); ++row) {
    line.clear();
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (i > 0) line += ',';
      append_number(line, values_[i][row]);
    }
    line += '\n';
    out << line;
  }
  if (!out.flush()) throw InputError(file, "", "cannot be written to its end", "is the disk full?");
}

std::string LogTable::signature() const {
  Fnv1a hash;
  for (const std::string& name : names_) hash.add(name);
  for (std::size_t row = 0; row < rows(); ++row) {
    for (const std::vector<double>& column : values_) hash.add(column[row]);
  }
  return hash.hex();
}

LogTable read_log_table(const std::filesystem::path& file) {
  const Csv csv = read_csv(file, CsvNumbers::kAny);
  try {
    LogTable table(csv.columns);
    for (const CsvRow& row : csv.rows) table.append(row.values);
    return table;
  } catch (const std::invalid_argument& problem) {
    throw InputError(file, "line 1", problem.what());
  }
}

}  // namespace vergence::tools
