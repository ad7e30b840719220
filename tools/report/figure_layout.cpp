#include "tools/report/figure_layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace vergence::tools {
namespace {

// Of the text at kFont_pt, measured on pictures.
constexpr double kCharacter_px = 7.2;
constexpr double kLine_px = 19;
constexpr double kLegendGap_px = 18;

constexpr double kLeftMargin_px = 84;
constexpr double kRightMargin_px = 26;
constexpr double kFigureTitle_px = 34;
constexpr double kXText_px = 50;  // tic labels and label below a plot
constexpr double kGap_px = 12;
constexpr double kSinglePlot_px = 360;
constexpr double kStackedPlot_px = 190;
constexpr double kLeastPlot_px = 40;

double text_px(const std::string& text) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
  return kCharacter_px * static_cast<double>(characters);
}

// Of the finite values seen.
class Extent {
 public:
  void add(double value) {
    if (!std::isfinite(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  // Never empty: gnuplot refuses such a range.
  [[nodiscard]] Range range(double margin) const {
    if (low_ > high_) return {0, 1};
    const double least = 1e-9 * std::max(std::abs(low_), std::abs(high_));
    if (high_ - low_ <= least || high_ - low_ < 1e-300) {
      const double half = low_ == 0 && high_ == 0 ? 1 : std::max(0.05 * std::abs(low_), 1e-300);
      return {low_ - half, high_ + half};
    }
    return {low_ - margin * (high_ - low_), high_ + margin * (high_ - low_)};
  }
  [[nodiscard]] Range log_range() const {
    if (low_ > high_) return {1, 10};
    return {low_ / 1.15, high_ * 1.15};
  }

 private:
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

Range x_range(const Panel& scale, const std::vector<const Panel*>& panels) {
  Extent extent;
  for (const Panel* panel : panels) {
    for (const Curve& curve : panel->curves) {
      for (const double x : curve.x) {
        if (drawable_x(scale, x)) extent.add(x);
      }
    }
  }
  return scale.log_x ? extent.log_range() : extent.range(0);
}

Range y_range(const Panel& panel, CurveAxis axis) {
  Extent extent;
  for (const Curve& curve : panel.curves) {
    if (curve.axis != axis) continue;
    for (std::size_t i = 0; i < curve.y.size(); ++i) {
      if (drawable_x(panel, curve.x[i])) extent.add(curve.y[i]);
    }
  }
  return extent.range(0.06);
}

struct Header {
  double legend_px = 0;
  double spans_px = 0;
  std::vector<LegendEntry> legend;     // heights from the legend's top, downwards
  std::vector<SpanLabel> span_labels;  // heights from the plot's top

  [[nodiscard]] double height_px(const Panel& panel) const {
    return (panel.title.empty() ? 4 : kLine_px + 2) + legend_px + spans_px + 3;
  }
};

// Line by line, as words are.
void place_legend(const Panel& panel, const PanelLayout& box, Header& header) {
  double left_px = box.left_px;
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const std::string& label = panel.curves[i].label;
    if (label.empty()) continue;
    const double entry_px = kLegendSample_px + 6 + text_px(label);
    if (header.legend.empty() || left_px + entry_px > box.right_px) {
      left_px = box.left_px;
      header.legend_px += kLine_px;
    }
    header.legend.push_back({i, left_px, header.legend_px - 0.5 * kLine_px});
    left_px += entry_px + kLegendGap_px;
  }
}

void place_span_labels(const Panel& panel, const PanelLayout& box, Header& header) {
  const auto scale = [&](double x) { return panel.log_x ? std::log(x) : x; };
  const double low = scale(box.x.low);
  const double high = scale(box.x.high);
  std::vector<double> row_end_px;
  for (const Span& span : panel.spans) {
    const double first = std::max(scale(span.first), low);
    const double last = std::min(scale(span.last), high);
    if (span.label.empty() || !(first <= last)) continue;
    const double half_px = 0.5 * text_px(span.label);
    const double middle_px =
        box.left_px + (0.5 * (first + last) - low) / (high - low) * (box.right_px - box.left_px);
    // The first row where it does not run into the one before.
    std::size_t row = 0;
    while (row < row_end_px.size() && row_end_px[row] > middle_px - half_px) ++row;
    if (row == row_end_px.size()) row_end_px.push_back(0);
    row_end_px[row] = middle_px + half_px + 6;
    header.span_labels.push_back({middle_px, (static_cast<double>(row) + 0.5) * (kLine_px - 3), span.label});
  }
  header.spans_px = (kLine_px - 3) * static_cast<double>(row_end_px.size());
}

void check(const Figure& figure) {
  if (figure.panels.empty() || figure.columns < 1) throw std::invalid_argument("a figure without panels");
  for (const Panel& panel : figure.panels) {
    for (const Curve& curve : panel.curves) {
      if (curve.x.size() == curve.y.size()) continue;
      throw std::invalid_argument("curve '" + curve.label + "' has " + std::to_string(curve.x.size()) +
                                  " values of x and " + std::to_string(curve.y.size()) + " of y");
    }
  }
}

}  // namespace

bool drawable_x(const Panel& panel, double x) {
  return std::isfinite(x) && (!panel.log_x || x > 0);
}

bool uses_right_axis(const Panel& panel) {
  return std::any_of(panel.curves.begin(), panel.curves.end(),
                     [](const Curve& curve) { return curve.axis == CurveAxis::kRight; });
}

FigureLayout layout(const Figure& figure) {
  check(figure);
  const std::size_t count = figure.panels.size();
  const auto columns = std::min(static_cast<std::size_t>(figure.columns), count);
  const std::size_t rows = (count + columns - 1) / columns;
  const bool right_axes = std::any_of(figure.panels.begin(), figure.panels.end(), uses_right_axis);
  const double cell_px = static_cast<double>(figure.width_px) / static_cast<double>(columns);

  FigureLayout result;
  result.width_px = figure.width_px;
  result.panels.resize(count);
  std::vector<Header> headers(count);
  std::vector<double> header_px(rows, 0);
  std::vector<double> footer_px(rows, kGap_px);
  for (std::size_t i = 0; i < count; ++i) {
    const Panel& panel = figure.panels[i];
    PanelLayout& box = result.panels[i];
    std::vector<const Panel*> sharing{&panel};
    if (figure.share_x) {
      sharing.clear();
      for (std::size_t k = i % columns; k < count; k += columns) sharing.push_back(&figure.panels[k]);
    }
    box.x = x_range(panel, sharing);
    box.left = panel.y_range.value_or(y_range(panel, CurveAxis::kLeft));
    box.right = y_range(panel, CurveAxis::kRight);
    box.left_px = cell_px * static_cast<double>(i % columns) + kLeftMargin_px;
    box.right_px =
        cell_px * static_cast<double>(i % columns + 1) - (right_axes ? kLeftMargin_px : kRightMargin_px);
    box.x_written = !figure.share_x || i + columns >= count;
    place_legend(panel, box, headers[i]);
    place_span_labels(panel, box, headers[i]);
    header_px[i / columns] = std::max(header_px[i / columns], headers[i].height_px(panel));
    if (box.x_written) footer_px[i / columns] = kXText_px;
  }
  double text_height_px = figure.title.empty() ? kGap_px : kFigureTitle_px;
  for (std::size_t row = 0; row < rows; ++row) text_height_px += header_px[row] + footer_px[row];
  const double plots = static_cast<double>(rows);
  const double wanted_px = rows == 1 ? kSinglePlot_px : kStackedPlot_px;
  result.height_px =
      figure.height_px > 0 ? figure.height_px : static_cast<int>(text_height_px + plots * wanted_px);
  const double plot_px = std::max((result.height_px - text_height_px) / plots, kLeastPlot_px);
  result.title_px = result.height_px - 0.5 * kFigureTitle_px;

  double top_px = result.height_px - (figure.title.empty() ? kGap_px : kFigureTitle_px);
  for (std::size_t i = 0; i < count; ++i) {
    PanelLayout& box = result.panels[i];
    const std::size_t row = i / columns;
    box.top_px = top_px - header_px[row];
    box.bottom_px = box.top_px - plot_px;
    Header& header = headers[i];
    const double legend_top_px = box.top_px + 3 + header.spans_px + header.legend_px;
    box.title_px = legend_top_px + 0.5 * kLine_px;
    box.legend = std::move(header.legend);
    for (LegendEntry& entry : box.legend) entry.y_px = legend_top_px - entry.y_px;
    box.span_labels = std::move(header.span_labels);
    for (SpanLabel& label : box.span_labels) label.y_px += box.top_px + 1;
    if (i % columns + 1 == columns) top_px = box.bottom_px - footer_px[row];
  }
  return result;
}

}  // namespace vergence::tools
