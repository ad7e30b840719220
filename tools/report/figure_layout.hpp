// Where the parts of a figure lie, in pixels from its lower left corner, worked out before gnuplot draws: its
// own legends lie on top of curves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/report/figure.hpp"

namespace vergence::tools {

inline constexpr double kFont_pt = 10;

// A piece of line or a point, then the label.
struct LegendEntry {
  std::size_t curve = 0;
  double left_px = 0;
  double y_px = 0;  // the middle of its height
};
inline constexpr double kLegendSample_px = 30;

struct SpanLabel {
  double x_px = 0;  // the middle of its width
  double y_px = 0;  // the middle of its height
  std::string text;
};

// A panel and its surroundings: title, legend and names of spans above the plot, in that order.
struct PanelLayout {
  double left_px = 0;
  double right_px = 0;
  double bottom_px = 0;
  double top_px = 0;
  double title_px = 0;  // the middle of its height
  std::vector<LegendEntry> legend;
  bool x_written = true;  // tic labels and x_label below
  Range x;
  Range left;
  Range right;
  std::vector<SpanLabel> span_labels;
};

struct FigureLayout {
  int width_px = 0;
  int height_px = 0;
  double title_px = 0;
  std::vector<PanelLayout> panels;
};

// Throws std::invalid_argument as write_figure does.
[[nodiscard]] FigureLayout layout(const Figure& figure);

// Whether the value can be drawn on the panel's x axis.
[[nodiscard]] bool drawable_x(const Panel& panel, double x);

[[nodiscard]] bool uses_right_axis(const Panel& panel);

}  // namespace vergence::tools
