#include "tools/calibrate/hand_poses.hpp"

#include <cmath>
#include <string>

#include "tools/io/csv.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::Csv;
using tools::CsvRow;
using tools::InputError;

Csv read_table(const std::filesystem::path& file, const std::string& first_column) {
  std::error_code ignored;
  const std::string columns = first_column + ",x_mm,y_mm,z_mm,e1,e2,e3";
  if (!std::filesystem::is_regular_file(file, ignored))
    throw InputError(file, "", "no such file", "expected a table " + columns);
  Csv csv = tools::read_csv(file);
  std::string found;
  for (const std::string& column : csv.columns) found += (found.empty() ? "" : ",") + column;
  if (found != columns) throw InputError(file, "header", "has other columns", "expected " + columns);
  if (csv.rows.empty()) throw InputError(file, "", "has no rows", "expected " + columns);
  return csv;
}

std::string where(const CsvRow& row, const std::string& column) {
  return "line " + std::to_string(row.line) + ": " + column;
}

Transform pose_of(const std::filesystem::path& file, const CsvRow& row) {
  const auto& v = row.values;
  const Pose pose{{v[1], v[2], v[3]}, {v[4], v[5], v[6]}};
  if (!is_valid(pose)) {
    throw InputError(file, where(row, "e1"), "e1, e2, e3 are no part of a unit quaternion",
                     "their length must be at most 1");
  }
  return to_transform(pose);
}

}  // namespace

std::map<int, Transform> read_numbered_poses(const std::filesystem::path& file) {
  std::map<int, Transform> poses;
  const Csv table = read_table(file, "frame");
  for (const CsvRow& row : table.rows) {
    const double number = row.values[0];
    if (number != std::floor(number) || number < 0 || number > 999'999'999)
      throw InputError(file, where(row, "frame"), "is not the number of a picture", "0 to 999999999, whole");
    if (!poses.emplace(static_cast<int>(number), pose_of(file, row)).second)
      throw InputError(file, where(row, "frame"), "appears twice", "one row a picture");
  }
  return poses;
}

std::vector<TimedPose> read_timed_poses(const std::filesystem::path& file) {
  std::vector<TimedPose> poses;
  const Csv table = read_table(file, "t_s");
  for (const CsvRow& row : table.rows) {
    const double t_s = row.values[0];
    if (!poses.empty() && !(t_s > poses.back().t_s))
      throw InputError(file, where(row, "t_s"), "is not later than the row before", "sort the rows by time");
    poses.push_back({t_s, pose_of(file, row)});
  }
  return poses;
}

}  // namespace vergence::calibrate
