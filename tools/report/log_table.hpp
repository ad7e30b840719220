// What happened, number by number: the log that a run leaves beside its report, and one number that tells
// whether another run was the same.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vergence::tools {

// Named columns of doubles; a name carries its unit ("hand_x_mm"). NaN means that there was no value.
class LogTable {
 public:
  // Throws std::invalid_argument: no columns, the same name twice, or a name that CSV cannot carry as it is.
  explicit LogTable(std::vector<std::string> columns);

  // One value a column. Throws std::invalid_argument where the row has another length.
  void append(std::span<const double> row);
  void append(std::initializer_list<double> row) { append(std::span(row.begin(), row.size())); }

  [[nodiscard]] const std::vector<std::string>& columns() const { return names_; }
  [[nodiscard]] std::size_t rows() const { return values_.front().size(); }
  [[nodiscard]] bool has_column(std::string_view name) const;
  // Throws std::invalid_argument naming the column that is missing.
  [[nodiscard]] const std::vector<double>& column(std::string_view name) const;

  // Header line, then the rows; each number in the fewest decimals that read back to the same bits, NaN as an
  // empty field. The same values are the same bytes on every machine. Throws InputError.
  void write_csv(const std::filesystem::path& file) const;

  // FNV-1a (64 bits) over the names and the bits of all values, row by row; 16 hexadecimal digits. Every NaN
  // counts as the same one: processors differ in the sign they give it, and the file does not keep it.
  [[nodiscard]] std::string signature() const;

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;  // one a column
};

// Throws InputError naming file and line.
[[nodiscard]] LogTable read_log_table(const std::filesystem::path& file);

}  // namespace vergence::tools
