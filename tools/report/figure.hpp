// Curves over time or frequency as a PNG, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vergence::tools {

enum class CurveStyle {
  kLine,
  kDashed,
  kPoints,
  kLinePoints,
};

enum class CurveAxis {
  kLeft,
  kRight,
};

struct Curve {
  std::string label;  // empty: not in the legend
  std::vector<double> x;
  std::vector<double> y;  // a line is broken where x or y is not finite
  CurveStyle style = CurveStyle::kLine;
  CurveAxis axis = CurveAxis::kLeft;
  // Of the palette; its place among the curves where not given. What was wanted and what was reached belong
  // together: the same colour, one dashed.
  std::optional<std::size_t> colour;
};

// A shaded stretch of x: a light, a time without sight.
struct Span {
  double first = 0;
  double last = 0;
  std::string label;
};

struct Range {
  double low = 0;
  double high = 1;
};

struct Panel {
  std::string title;
  std::string x_label;  // with units, as are the others
  std::string y_label;
  std::string right_label;
  std::vector<Curve> curves;
  bool log_x = false;
  std::optional<Range> y_range;  // of all values where not given
  std::vector<Span> spans;
};

struct Figure {
  std::string title;
  std::vector<Panel> panels;  // row by row
  int columns = 1;
  bool share_x = true;  // panels of a column have one range of x, written below the lowest
  int width_px = 1100;
  int height_px = 0;  // 0: what the panels need
};

// Throws std::invalid_argument where a curve's x and y differ in length or there is no panel, InputError
// where the file cannot be written, std::runtime_error without gnuplot.
void write_figure(const std::filesystem::path& png, const Figure& figure);

struct BodeCurve {
  std::string label;
  std::vector<double> omega_rad_s;
  std::vector<double> gain_db;
  std::vector<double> phase_deg;
  CurveStyle style = CurveStyle::kLinePoints;
};

// Gain, with the line at -3 dB, over phase.
[[nodiscard]] Figure bode_figure(const std::string& title, const std::vector<BodeCurve>& curves);

}  // namespace vergence::tools
