// A figure of values over two axes: colours, axes with units, colour bar, and marks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vergence::tools {

// Evenly spaced values of an axis.
struct GridAxis {
  std::string label;  // with unit
  double first = 0;
  double step = 1;
  int count = 0;

  [[nodiscard]] double value(int i) const { return first + step * i; }
  [[nodiscard]] double last() const { return value(count - 1); }
};

struct HeatMap {
  std::string title;
  GridAxis x;
  GridAxis y;
  std::string value_label;
  std::vector<double> values;  // row by row: values[iy * x.count + ix]

  struct Mark {
    double x = 0;
    double y = 0;
    std::string label;
    int point_type = 1;  // gnuplot's
  };
  std::vector<Mark> marks;
};

// Draws it to a PNG. Throws std::runtime_error without gnuplot, InputError where the file cannot be written.
void write_heat_map(const std::filesystem::path& png, const HeatMap& map);

// Several of them in one PNG, row by row under one title. Throws std::invalid_argument where there are none.
void write_heat_map_grid(const std::filesystem::path& png, const std::string& title,
                         const std::vector<HeatMap>& maps, int columns);

}  // namespace vergence::tools
