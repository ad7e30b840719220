// Small numeric CSV files with a header line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vergence::tools {

struct CsvRow {
  int line = 0;                // in the file, for messages
  std::vector<double> values;  // one a column
};

struct Csv {
  std::vector<std::string> columns;
  std::vector<CsvRow> rows;
};

// Throws InputError: no header, a row of another length, or a field that is not a finite number.
[[nodiscard]] Csv read_csv(const std::filesystem::path& file);

}  // namespace vergence::tools
