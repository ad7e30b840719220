// `vergence fitness-map`: the fitness of the method [Eqs. 3.22, 5.19] over two axes of the pose.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/parse_numbers.hpp"
#include "tools/cli/progress.hpp"
#include "tools/draw/heat_map.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::tools {
namespace {

constexpr std::array<const char*, kGenes> kAxisNames{"x", "y", "z", "e1", "e2", "e3"};
constexpr std::array<const char*, kGenes> kAxisUnits{"_mm", "_mm", "_mm", "", "", ""};
constexpr int kMaxPointsOfAxis = 4001;

struct Options {
  std::filesystem::path directory;
  int frame = 0;
  std::string axes;
  std::string step;
  std::vector<std::string> ranges;
  std::string at;
  std::string method = "vergence";
  int points = PhotoOptions{}.points;
  std::filesystem::path csv;
  std::filesystem::path png;
};

using PoseVector = std::array<double, kGenes>;

PoseVector as_vector(const Pose& pose) {
  return {pose.position_mm[0], pose.position_mm[1], pose.position_mm[2], pose.e[0], pose.e[1], pose.e[2]};
}

Pose as_pose(const PoseVector& v) {
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
}

std::size_t axis_index(const std::string& option, const std::string& name) {
  const auto found = std::find(kAxisNames.begin(), kAxisNames.end(), name);
  if (found == kAxisNames.end()) {
    throw CLI::ValidationError(option, "'" + name + "' is not an axis: x, y, z, e1, e2 or e3");
  }
  return static_cast<std::size_t>(found - kAxisNames.begin());
}

struct Interval {
  double low;
  double high;
};

// The search box's extent along each axis, where the user gives none (NAME=LOW:HIGH).
std::array<Interval, kGenes> intervals_of(const SearchBox& box, const std::vector<std::string>& ranges) {
  std::array<Interval, kGenes> intervals;
  for (std::size_t i = 0; i < kGenes; ++i) {
    intervals[i] = {box.centre[i] - box.half_range[i], box.centre[i] + box.half_range[i]};
  }
  for (const std::string& text : ranges) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw CLI::ValidationError("--range", "'" + text + "' is not AXIS=LOW:HIGH, as in x=-100:100");
    }
    const auto ends = parse_numbers("--range", text.substr(equals + 1), ':', 2);
    if (!(ends[0] < ends[1])) throw CLI::ValidationError("--range", "'" + text + "' is empty");
    intervals[axis_index("--range", text.substr(0, equals))] = {ends[0], ends[1]};
  }
  return intervals;
}

GridAxis grid_axis(std::size_t index, const Interval& interval, double step) {
  const double count = std::floor((interval.high - interval.low) / step + 1e-9) + 1;
  const std::string name = kAxisNames[index];
  if (!(step > 0) || count < 2 || count > kMaxPointsOfAxis) {
    throw CLI::ValidationError("--step", "between 2 and " + std::to_string(kMaxPointsOfAxis) +
                                             " points an axis, but " + name + " would have " +
                                             (step > 0 ? std::to_string(static_cast<long>(count)) : "none") +
                                             " (two steps may be given: --step 2,0.01)");
  }
  return {name + (index < 3 ? " [mm]" : ""), interval.low, step, static_cast<int>(count)};
}

const Frame& frame_of(const Dataset& dataset, int number) {
  for (const Frame& frame : dataset.frames) {
    if (frame.number == number) return frame;
  }
  throw InputError(dataset.directory, "--frame", "no frame " + std::to_string(number),
                   "there are " + std::to_string(dataset.frames.front().number) + " to " +
                       std::to_string(dataset.frames.back().number));
}

std::string text_of(const PoseVector& pose) {
  char text[160];
  std::snprintf(text, sizeof text, "x %.1f y %.1f z %.1f mm  e %.3f %.3f %.3f", pose[0], pose[1], pose[2],
                pose[3], pose[4], pose[5]);
  return text;
}

// The two axes, the grid over them, and the pose that the other four are taken from.
struct Map {
  std::array<std::size_t, 2> axis;
  std::array<GridAxis, 2> grid;
  PoseVector at;
  std::vector<double> values;
  std::size_t peak = 0;

  [[nodiscard]] std::array<double, 2> point(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(grid[0].count);
    return {grid[0].value(static_cast<int>(index % columns)),
            grid[1].value(static_cast<int>(index / columns))};
  }
};

void evaluate(const Tracker& tracker, Map& map) {
  Progress progress("fitness-map", static_cast<std::size_t>(map.grid[1].count));
  PoseVector pose = map.at;
  for (int iy = 0; iy < map.grid[1].count; ++iy) {
    pose[map.axis[1]] = map.grid[1].value(iy);
    for (int ix = 0; ix < map.grid[0].count; ++ix) {
      pose[map.axis[0]] = map.grid[0].value(ix);
      map.values.push_back(tracker.fitness_at(as_pose(pose)));
    }
    progress.step();
  }
  map.peak =
      static_cast<std::size_t>(std::max_element(map.values.begin(), map.values.end()) - map.values.begin());
}

void write_csv(const std::filesystem::path& file, const Map& map) {
  std::ofstream out(file);
  for (const std::size_t axis : map.axis) out << kAxisNames[axis] << kAxisUnits[axis] << ',';
  out << "fitness\n";
  out.precision(9);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const auto [a, b] = map.point(i);
    out << a << ',' << b << ',' << map.values[i] << '\n';
  }
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

void draw(const std::filesystem::path& png, const Options& options, const Map& map,
          const std::optional<PoseVector>& truth) {
  const auto [a, b] = map.point(map.peak);
  char label[100];
  std::snprintf(label, sizeof label, "peak %.3f at %s = %.6g, %s = %.6g", map.values[map.peak],
                kAxisNames[map.axis[0]], a, kAxisNames[map.axis[1]], b);
  HeatMap figure{"frame " + std::to_string(options.frame) + ", around " + text_of(map.at),
                 map.grid[0],
                 map.grid[1],
                 "fitness",
                 map.values,
                 {}};
  if (truth) figure.marks.push_back({(*truth)[map.axis[0]], (*truth)[map.axis[1]], "truth", 6});
  figure.marks.push_back({a, b, label, 2});
  write_heat_map(png, figure);
}

void print_summary(const Map& map, const std::optional<PoseVector>& truth) {
  const auto peak = map.point(map.peak);
  std::printf("around %s\n%zu poses\n", text_of(map.at).c_str(), map.values.size());
  std::printf("peak   %.4f at", map.values[map.peak]);
  for (std::size_t i = 0; i < 2; ++i) {
    std::printf(" %s %.*f%s", kAxisNames[map.axis[i]], map.axis[i] < 3 ? 2 : 4, peak[i],
                map.axis[i] < 3 ? " mm" : "");
  }
  std::printf("\n");
  if (!truth) return;
  std::printf("offset from truth:");
  for (std::size_t i = 0; i < 2; ++i) {
    std::printf(" %s %+.*f%s", kAxisNames[map.axis[i]], map.axis[i] < 3 ? 2 : 4,
                peak[i] - (*truth)[map.axis[i]], map.axis[i] < 3 ? " mm" : "");
  }
  std::printf("\n");
}

void run(const Options& options) {
  const Dataset dataset = read_dataset(options.directory);
  const Frame& frame = frame_of(dataset, options.frame);

  const std::size_t comma = options.axes.find(',');
  if (comma == std::string::npos) throw CLI::ValidationError("--axes", "two axes, as in x,z");
  Map map;
  map.axis = {axis_index("--axes", options.axes.substr(0, comma)),
              axis_index("--axes", options.axes.substr(comma + 1))};
  if (map.axis[0] == map.axis[1]) throw CLI::ValidationError("--axes", "the two axes must differ");
  const bool two_steps = options.step.find(',') != std::string::npos;
  const auto steps = parse_numbers("--step", options.step, ',', two_steps ? 2 : 1);
  const auto intervals = intervals_of(dataset.box, options.ranges);
  map.grid = {grid_axis(map.axis[0], intervals[map.axis[0]], steps.front()),
              grid_axis(map.axis[1], intervals[map.axis[1]], steps.back())};

  std::optional<PoseVector> truth;
  if (const auto found = dataset.truth.find(frame.number); found != dataset.truth.end()) {
    truth = as_vector(found->second.T_H_M);
  }
  map.at = truth.value_or(dataset.box.centre);
  if (!options.at.empty()) {
    const auto numbers = parse_numbers("--at", options.at, ',', kGenes);
    std::copy(numbers.begin(), numbers.end(), map.at.begin());
    if (!is_valid(as_pose(map.at))) throw CLI::ValidationError("--at", "e1, e2, e3 are longer than 1");
  }
  if (!options.csv.empty()) require_writable(options.csv);
  if (!options.png.empty()) require_writable(options.png);

  EstimateOptions estimate;
  estimate.method = parse_method(options.method);
  estimate.generations = 0;  // the images are wanted in the tracker, not a pose
  estimate.photo_points = options.points;
  Estimator estimator(dataset, estimate);
  const auto [left, right] = read_frame(dataset, frame);
  static_cast<void>(estimator.run(frame, left, right));

  evaluate(estimator.tracker(), map);
  print_summary(map, truth);
  if (!options.csv.empty()) write_csv(options.csv, map);
  if (!options.png.empty()) draw(options.png, options, map, truth);
}

}  // namespace

void add_fitness_map_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("fitness-map", "Fitness of one frame over two axes of the pose");
  const auto options = std::make_shared<Options>();
  command->add_option("DIR", options->directory, "Data set")->required();
  command->add_option("--frame", options->frame, "Number of the frame")->type_name("K")->required();
  command->add_option("--axes", options->axes, "Two of x, y, z [mm], e1, e2, e3")
      ->type_name("A,B")
      ->required();
  command->add_option("--step", options->step, "Of both axes, or one each: 2,0.01")
      ->type_name("S")
      ->required();
  command
      ->add_option("--range", options->ranges,
                   "AXIS=LOW:HIGH, as in x=-100:100; may be repeated; default: the search box")
      ->type_name("R");
  command
      ->add_option("--at", options->at,
                   "x,y,z,e1,e2,e3: the other four; default: truth, else the box's centre")
      ->type_name("POSE");
  add_method_option(*command, options->method);
  command->add_option("--points", options->points, "Points of the photo-model")
      ->check(CLI::Range(20, kMaxPhotoPoints))
      ->capture_default_str();
  command->add_option("--csv", options->csv, "Write every value there")->type_name("FILE");
  command->add_option("--png", options->png, "Draw a heat map there (needs gnuplot)")->type_name("FILE");
  command->footer(
      "The fitness is that of Eqs. 3.22 (marker) and 5.19 (photo-model), as `vergence estimate` reports it.\n"
      "\nExamples:\n"
      "  vergence fitness-map lab/marker --frame 0 --axes x,z --step 1 --range x=-100:100 --png map.png\n"
      "  vergence fitness-map lab/crab --frame 7 --axes z,e2 --step 2,0.01 --csv map.csv");
  command->callback([options] { run(*options); });
}

}  // namespace vergence::tools
