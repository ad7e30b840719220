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

enum class CsvNumbers {
  kFinite,
  kAny,  // an empty field is NaN, and there may be infinities
};

// Throws InputError: no header, a row of another length, or a field that is not such a number. Blank lines
// are skipped, except where they are rows: in a file of a single column whose fields may be empty.
[[nodiscard]] Csv read_csv(const std::filesystem::path& file, CsvNumbers numbers = CsvNumbers::kFinite);

}  // namespace vergence::tools
