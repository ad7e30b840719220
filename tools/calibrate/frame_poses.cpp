#include "tools/calibrate/frame_poses.hpp"

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/io/csv.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

using tools::InputError;
using Json = nlohmann::json;
namespace fs = std::filesystem;

std::map<int, double> read_stamps(const fs::path& file) {
  std::map<int, double> stamps;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return stamps;
  const tools::Csv csv = tools::read_csv(file);
  if (csv.columns != std::vector<std::string>{"frame", "t_s"})
    throw InputError(file, "header", "has other columns", "expected frame,t_s");
  for (const tools::CsvRow& row : csv.rows) {
    const double number = row.values[0];
    const std::string where = "line " + std::to_string(row.line) + ": frame";
    if (number != std::floor(number) || number < 0 || number > 999'999)
      throw InputError(file, where, "is not a frame number", "0 to 999999, whole");
    if (!stamps.emplace(static_cast<int>(number), row.values[1]).second)
      throw InputError(file, where, "appears twice", "one row a frame");
  }
  return stamps;
}

class JsonLine {
 public:
  JsonLine(const fs::path& file, int line, const std::string& text)
      : file_(file), line_(line), json_(Json::parse(text, nullptr, false)) {
    if (!json_.is_object()) fail("", "is no JSON object");
  }

  [[noreturn]] void fail(const std::string& field, const std::string& problem) const {
    throw InputError(file_, "line " + std::to_string(line_) + (field.empty() ? "" : ": " + field), problem,
                     "expected lines as `vergence estimate --json` writes them");
  }

  [[nodiscard]] double number(const Json& object, const char* key) const {
    if (!object.is_object() || !object.contains(key) || !object[key].is_number())
      fail(key, "is not a number");
    const double value = object[key].get<double>();
    if (!std::isfinite(value)) fail(key, "is not a finite number");
    return value;
  }

  [[nodiscard]] const Json& json() const { return json_; }

 private:
  const fs::path& file_;
  int line_;
  Json json_;
};

std::vector<TimedPose> read_lines(const fs::path& file, const fs::path& stamp_file) {
  const std::map<int, double> stamps = read_stamps(stamp_file);
  std::vector<TimedPose> poses;
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be read");
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
    const JsonLine line(file, number, text);
    const auto state = line.json().find("state");
    if (state == line.json().end() || !state->is_string()) line.fail("state", "is missing");
    if (*state != "tracking") continue;
    double t_s = line.number(line.json(), "t_s");
    if (!stamps.empty()) {
      const auto frame = static_cast<int>(line.number(line.json(), "frame"));
      const auto stamp = stamps.find(frame);
      if (stamp == stamps.end()) {
        throw InputError(stamp_file, "frame", "no row for frame " + std::to_string(frame),
                         "one row for every frame of " + file.filename().string());
      }
      t_s = stamp->second;
    }
    const Json pose = line.json().value("pose", Json::object());
    const Pose T_H_M{{line.number(pose, "x_mm"), line.number(pose, "y_mm"), line.number(pose, "z_mm")},
                     {line.number(pose, "e1"), line.number(pose, "e2"), line.number(pose, "e3")}};
    if (!is_valid(T_H_M)) line.fail("e1", "e1, e2, e3 are no part of a unit quaternion");
    if (!poses.empty() && !(t_s > poses.back().t_s)) line.fail("t_s", "is not later than the frame before");
    poses.push_back({t_s, to_transform(T_H_M)});
  }
  if (poses.empty()) throw InputError(file, "state", "no frame was tracked", "the target must be in view");
  return poses;
}

}  // namespace

FramePoses read_frame_poses(const fs::path& directory) {
  std::error_code ignored;
  const fs::path lines = directory / "frames.jsonl";
  const fs::path table = directory / "frames.csv";
  if (!fs::exists(lines, ignored)) return {table, read_timed_poses(table)};
  if (fs::exists(table, ignored))
    throw InputError(table, "", "there is a frames.jsonl as well", "leave the one that counts");
  return {lines, read_lines(lines, directory / "stamps.csv")};
}

}  // namespace vergence::calibrate
