#include "tools/report/figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "tools/draw/gnuplot.hpp"
#include "tools/io/writable.hpp"
#include "tools/report/figure_layout.hpp"
#include "tools/report/thinned.hpp"

namespace vergence::tools {
namespace {

constexpr std::size_t kMostPoints = 2000;  // a curve; more than there are pixels across

// Okabe and Ito: told apart by colour-blind people too. Yellow is left out, it is lost on white.
constexpr std::array kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                              "#e69f00", "#56b4e9", "#000000", "#888888"};
constexpr std::array kPointTypes{7, 5, 9, 13, 11, 6, 4, 8};
constexpr std::array kSpanColours{"#dce9f5", "#fdebd3", "#dff1e4", "#f0e0ee", "#ececec"};

std::string block_name(std::size_t panel, std::size_t curve) {
  return "$p" + std::to_string(panel) + "c" + std::to_string(curve);
}

// Drawn values only; a blank line is where gnuplot lifts the pen. False where there is nothing.
bool write_data(std::ostream& script, const std::string& name, const Panel& panel, const Curve& curve) {
  std::vector<double> y = curve.y;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (!drawable_x(panel, curve.x[i])) y[i] = std::numeric_limits<double>::quiet_NaN();
  }
  const std::vector<std::size_t> kept = thinned(y, kMostPoints);
  if (kept.empty()) return false;
  script << name << " << EOD\n";
  for (const std::size_t i : kept) {
    if (i != kGap) script << curve.x[i] << ' ' << y[i];
    script << '\n';
  }
  script << "EOD\n";
  return true;
}

void write_range(std::ostream& script, const char* axis, const Range& range) {
  script << "set " << axis << "range [" << range.low << ":" << range.high << "]\n";
}

void write_spans(std::ostream& script, const Panel& panel, const PanelLayout& box) {
  std::vector<std::string> names;
  for (const Span& span : panel.spans) {
    const auto known = std::find(names.begin(), names.end(), span.label);
    const auto colour = static_cast<std::size_t>(known - names.begin()) % kSpanColours.size();
    if (known == names.end()) names.push_back(span.label);
    const double first = std::max(span.first, box.x.low);
    const double last = std::min(span.last, box.x.high);
    if (!(first <= last)) continue;
    script << "set object rectangle from " << first << ", graph 0 to " << last
           << ", graph 1 behind fillstyle solid 1 noborder fillcolor rgb '" << kSpanColours[colour] << "'\n";
  }
}

void write_text(std::ostream& script, const std::string& text, double x, double y, const char* how) {
  if (text.empty()) return;
  script << "set label " << gnuplot_quoted(text) << " at screen " << x << "," << y << " " << how
         << " noenhanced front\n";
}

// Of a few decades 1, 2, 5, 10, where gnuplot writes powers of ten alone.
void write_log_tics(std::ostream& script, const Range& range) {
  const double first = std::floor(std::log10(range.low));
  const double last = std::ceil(std::log10(range.high));
  script << "set logscale x\nset mxtics 10\nset xtics autofreq\n";
  if (last - first > 4) return;
  script << "set xtics (";
  for (double decade = first; decade <= last; ++decade) {
    for (const int digit : {1, 2, 5}) {
      const double tic = digit * std::pow(10, decade);
      script << (decade == first && digit == 1 ? "" : ", ") << tic;
    }
  }
  script << ")\nset xtics add (";
  for (double decade = first; decade <= last; ++decade) {
    for (const int digit : {3, 4, 6, 7, 8, 9}) {
      script << (decade == first && digit == 3 ? "" : ", ") << "'' " << digit * std::pow(10, decade) << " 1";
    }
  }
  script << ")\n";
}

void write_axes(std::ostream& script, const Panel& panel, const PanelLayout& box) {
  const bool right = uses_right_axis(panel);
  if (panel.log_x) {
    write_log_tics(script, box.x);
  } else {
    script << "unset logscale\nset xtics autofreq\nset mxtics default\n";
  }
  script << "set grid xtics ytics" << (panel.log_x ? " mxtics" : "")
         << " lt 1 lw 0.6 lc rgb '#d4d4d4', lt 1 lw 0.4 lc rgb '#e8e8e8'\n"
         << "set xlabel " << gnuplot_quoted(box.x_written ? panel.x_label : "") << " noenhanced\n"
         << "set ylabel " << gnuplot_quoted(panel.y_label) << " noenhanced\n"
         << "set y2label " << gnuplot_quoted(right ? panel.right_label : "") << " noenhanced\n"
         << "set format x " << (box.x_written ? "'%g'" : "''") << "\n"
         << (right ? "set y2tics textcolor rgb '#202020'\nset ytics nomirror\n"
                   : "unset y2tics\nset ytics mirror\n");
  write_range(script, "x", box.x);
  write_range(script, "y", box.left);
  if (right) write_range(script, "y2", box.right);
}

std::string colour_of(const Curve& curve, std::size_t place) {
  return std::string(" lc rgb '") + kColours[curve.colour.value_or(place) % kColours.size()] + "'";
}

// Of many points, small ones: what lies below shows through.
constexpr const char* kDrawnSize = " ps 0.4 ";
constexpr const char* kLegendSize = " ps 0.9 ";

std::string point_of(const Curve& curve, std::size_t place, const char* size) {
  if (curve.style == CurveStyle::kPoints) return std::string("pt 7") + size;
  return "ps 1.1 pt " + std::to_string(kPointTypes[curve.colour.value_or(place) % kPointTypes.size()]);
}

std::string line_of(const Curve& curve) {
  return curve.style == CurveStyle::kDashed ? "lw 1.8 dt (10,6)" : "lw 1.8 dt solid";
}

bool has_line(const Curve& curve) {
  return curve.style != CurveStyle::kPoints;
}

bool has_points(const Curve& curve) {
  return curve.style == CurveStyle::kPoints || curve.style == CurveStyle::kLinePoints;
}

std::string drawn_as(const Curve& curve, std::size_t place) {
  std::string how = has_line(curve) && has_points(curve) ? "linespoints "
                    : has_line(curve)                    ? "lines "
                                                         : "points ";
  if (has_line(curve)) how += line_of(curve) + " ";
  if (has_points(curve)) how += point_of(curve, place, kDrawnSize);
  return how + colour_of(curve, place) + (curve.axis == CurveAxis::kRight ? " axes x1y2" : "");
}

void write_legend(std::ostream& script, const Panel& panel, const FigureLayout& place,
                  const PanelLayout& box) {
  for (const LegendEntry& entry : box.legend) {
    const Curve& curve = panel.curves[entry.curve];
    const double left = entry.left_px / place.width_px;
    const double right = (entry.left_px + kLegendSample_px) / place.width_px;
    const double y = entry.y_px / place.height_px;
    if (has_line(curve)) {
      script << "set arrow from screen " << left << "," << y << " to screen " << right << "," << y
             << " nohead " << line_of(curve) << colour_of(curve, entry.curve) << "\n";
    }
    if (has_points(curve)) {
      script << "set label '' at screen " << 0.5 * (left + right) << "," << y << " point "
             << point_of(curve, entry.curve, kLegendSize) << colour_of(curve, entry.curve) << "\n";
    }
    write_text(script, curve.label, right + 6.0 / place.width_px, y, "left");
  }
}

}  // namespace

void write_figure(const std::filesystem::path& png, const Figure& figure) {
  const FigureLayout place = layout(figure);
  require_writable(png);
  std::ostringstream script;
  script.precision(std::numeric_limits<double>::max_digits10);
  std::vector<std::vector<bool>> has_data(figure.panels.size());
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    for (std::size_t c = 0; c < figure.panels[p].curves.size(); ++c) {
      has_data[p].push_back(
          write_data(script, block_name(p, c), figure.panels[p], figure.panels[p].curves[c]));
    }
  }
  const double width = place.width_px;
  const double height = place.height_px;
  script << "set terminal pngcairo size " << place.width_px << "," << place.height_px << " font 'Sans,"
         << kFont_pt << "'\nset output " << gnuplot_quoted(png.string())
         << "\nset border 31 lw 0.6 lc rgb '#707070'\n"
            "set tics in scale 0.5 textcolor rgb '#202020'\nset key off\nset multiplot\n";
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    const Panel& panel = figure.panels[p];
    const PanelLayout& box = place.panels[p];
    script << "unset label\nunset object\nunset arrow\n";
    if (p == 0) {
      write_text(script, figure.title, 0.5, place.title_px / height, "center font 'Sans:Bold,12'");
    }
    write_text(script, panel.title, box.left_px / width, box.title_px / height, "left font 'Sans:Bold,10'");
    for (const SpanLabel& label : box.span_labels) {
      write_text(script, label.text, label.x_px / width, label.y_px / height,
                 "center font 'Sans,9' textcolor rgb '#505050'");
    }
    script << "set lmargin at screen " << box.left_px / width << "\nset rmargin at screen "
           << box.right_px / width << "\nset bmargin at screen " << box.bottom_px / height
           << "\nset tmargin at screen " << box.top_px / height << "\n";
    write_legend(script, panel, place, box);
    write_axes(script, panel, box);
    write_spans(script, panel, box);
    // Something must be drawn, or there would be no frame either.
    script << "plot NaN notitle";
    for (std::size_t c = 0; c < panel.curves.size(); ++c) {
      const Curve& curve = panel.curves[c];
      script << ", " << (has_data[p][c] ? block_name(p, c) + " using 1:2" : "NaN") << " with "
             << drawn_as(curve, c) << " notitle";
    }
    script << "\n";
  }
  script << "unset multiplot\n";
  run_gnuplot(script.str());
}

Figure bode_figure(const std::string& title, const std::vector<BodeCurve>& curves) {
  Panel gain;
  gain.y_label = "gain, dB";
  gain.log_x = true;
  Panel phase = gain;
  phase.y_label = "phase, °";
  phase.x_label = "angular frequency, rad/s";
  double lowest = std::numeric_limits<double>::infinity();
  double highest = 0;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const BodeCurve& curve = curves[i];
    gain.curves.push_back({.label = curve.label,
                           .x = curve.omega_rad_s,
                           .y = curve.gain_db,
                           .style = curve.style,
                           .axis = CurveAxis::kLeft,
                           .colour = i});
    phase.curves.push_back(gain.curves.back());
    phase.curves.back().y = curve.phase_deg;
    phase.curves.back().label.clear();  // one legend is enough
    for (const double omega : curve.omega_rad_s) {
      if (!drawable_x(gain, omega)) continue;
      lowest = std::min(lowest, omega);
      highest = std::max(highest, omega);
    }
  }
  if (lowest <= highest) {
    gain.curves.push_back({.label = "-3 dB",
                           .x = {lowest, highest},
                           .y = {-3, -3},
                           .style = CurveStyle::kDashed,
                           .axis = CurveAxis::kLeft,
                           .colour = kColours.size() - 1});
  }
  Figure figure;
  figure.title = title;
  figure.panels = {gain, phase};
  return figure;
}

}  // namespace vergence::tools
