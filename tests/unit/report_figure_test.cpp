// Figures are readable pictures of the size that was asked for, show what is in the data, and keep legends
// and curves apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/support/small_dataset.hpp"
#include "tools/draw/gnuplot.hpp"
#include "tools/draw/heat_map.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/report/figure.hpp"
#include "tools/report/figure_layout.hpp"
#include "tools/report/thinned.hpp"

namespace vergence::tools {
namespace {

using test::TempDirectory;
using test::write_file;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Curve curve(const char* label, std::vector<double> x, std::vector<double> y) {
  Curve result;
  result.label = label;
  result.x = std::move(x);
  result.y = std::move(y);
  return result;
}

Curve ramp(const char* label, double last) {
  std::vector<double> x;
  for (int i = 0; i <= 100; ++i) x.push_back(last * i / 100.0);
  return curve(label, x, x);
}

Figure small_figure() {
  Figure figure;
  figure.title = "It's a 'figure' with x_2 and \\n";
  Panel panel;
  panel.title = "upper";
  panel.x_label = "time, s";
  panel.y_label = "x, mm";
  panel.curves = {ramp("hand", 10), ramp("wanted", 10)};
  panel.curves[1].style = CurveStyle::kDashed;
  panel.spans = {{2, 4, "covered"}, {3.9, 4.1, "a long name of a light"}, {20, 30, "beyond"}};
  figure.panels = {panel, panel};
  figure.panels[1].curves = {ramp("right", 5)};
  figure.panels[1].curves[0].axis = CurveAxis::kRight;
  return figure;
}

// Pixels within a few levels of the colour.
std::size_t pixels_of(const RgbImage& image, int r, int g, int b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < image.data.size(); i += 3) {
    const auto near = [&](std::size_t k, int level) { return std::abs(image.data[i + k] - level) < 12; };
    if (near(0, r) && near(1, g) && near(2, b)) ++count;
  }
  return count;
}

TEST(Figure, IsAPngOfTheWantedSize) {
  const TempDirectory folder;
  Figure figure = small_figure();
  figure.width_px = 640;
  figure.height_px = 500;
  write_figure(folder / "it's.png", figure);
  const RgbImage image = read_png_rgb(folder / "it's.png");
  EXPECT_EQ(image.width_px, 640);
  EXPECT_EQ(image.height_px, 500);
}

TEST(Figure, ShowsItsCurves) {
  const TempDirectory folder;
  Figure figure = small_figure();
  write_figure(folder / "with.png", figure);
  for (Panel& panel : figure.panels) {
    for (Curve& c : panel.curves) std::fill(c.y.begin(), c.y.end(), kNaN);
  }
  write_figure(folder / "without.png", figure);
  const RgbImage with = read_png_rgb(folder / "with.png");
  const RgbImage without = read_png_rgb(folder / "without.png");
  EXPECT_EQ(with.height_px, layout(figure).height_px);
  // The legends' samples are in both; a curve crosses its panel.
  EXPECT_GT(pixels_of(with, 0x00, 0x72, 0xb2), pixels_of(without, 0x00, 0x72, 0xb2) + 500);
  EXPECT_GT(pixels_of(without, 0x00, 0x72, 0xb2), 20U);
}

TEST(Figure, DrawsEveryStyleInCurveAndLegend) {
  const TempDirectory folder;
  for (const CurveStyle style :
       {CurveStyle::kLine, CurveStyle::kDashed, CurveStyle::kPoints, CurveStyle::kLinePoints}) {
    Figure figure;
    figure.panels.resize(1);
    figure.panels[0].curves = {ramp("hand", 10)};
    figure.panels[0].curves[0].style = style;
    figure.panels[0].curves[0].colour = 1;
    const auto drawn = [&] {
      write_figure(folder / "style.png", figure);
      return pixels_of(read_png_rgb(folder / "style.png"), 0xd5, 0x5e, 0x00);
    };
    const std::size_t both = drawn();
    figure.panels[0].curves[0].label = "";
    const std::size_t curve_alone = drawn();
    EXPECT_GT(curve_alone, 100U) << static_cast<int>(style);
    EXPECT_GT(both, curve_alone + 3) << static_cast<int>(style);
  }
}

TEST(Figure, IsDrawnWhateverTheData) {
  const TempDirectory folder;
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Curve> odd{
      curve("none", {}, {}),
      curve("one", {3}, {4}),
      curve("constant", {0, 1, 2}, {7, 7, 7}),
      curve("zero", {0, 1}, {0, 0}),
      curve("gaps", {0, 1, kNaN, 3, 4}, {kNaN, 1, 2, infinity, 3}),
      curve("negative on a log axis", {-1, 0, 1, 10}, {1, 2, 3, 4}),
      curve("all at once", {1, 1, 1}, {1, 2, 3}),
      curve("two\nlines", {0, 1}, {1e-320, -1e-320}),
      curve("huge", {0, 1}, {-1e300, 1e300}),
  };
  for (const bool log_x : {false, true}) {
    for (const Curve& c : odd) {
      Figure figure;
      figure.panels.resize(1);
      figure.panels[0].log_x = log_x;
      figure.panels[0].curves = {c};
      EXPECT_NO_THROW(write_figure(folder / "odd.png", figure)) << c.label << " " << log_x;
      EXPECT_EQ(read_png_rgb(folder / "odd.png").width_px, 1100);
    }
  }
}

TEST(Figure, RefusesWhatItCannotDraw) {
  const TempDirectory folder;
  Figure figure;
  EXPECT_THROW(write_figure(folder / "a.png", figure), std::invalid_argument);
  figure = small_figure();
  figure.panels[0].curves[0].y.pop_back();
  EXPECT_THROW(write_figure(folder / "a.png", figure), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
  write_file(folder / "file", "");
  const std::filesystem::path below = folder / "file/below/a.png";
  try {
    write_figure(below, small_figure());
    FAIL() << "written below a file";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(below.string()), std::string::npos);
  }
}

TEST(FigureLayout, KeepsLegendsNamesAndPlotsApart) {
  Figure figure = small_figure();
  for (int i = 0; i < 14; ++i) figure.panels[0].curves.push_back(ramp("one of many curves", 10));
  for (const int columns : {1, 2}) {
    figure.columns = columns;
    const FigureLayout place = layout(figure);
    double above_px = place.title_px;
    for (std::size_t p = 0; p < 2; ++p) {
      const PanelLayout& box = place.panels[p];
      EXPECT_LT(box.bottom_px + 100, box.top_px);
      EXPECT_LT(box.left_px + 100, box.right_px);
      EXPECT_LE(box.right_px, place.width_px);
      ASSERT_EQ(box.legend.size(), figure.panels[p].curves.size());
      double lowest_px = box.title_px;
      for (const LegendEntry& entry : box.legend) {
        EXPECT_GE(entry.left_px, box.left_px);
        EXPECT_LT(entry.left_px + kLegendSample_px, box.right_px);
        EXPECT_LT(entry.y_px, box.title_px - 10);
        lowest_px = std::min(lowest_px, entry.y_px);
      }
      // The two names overlap, so one stands above the other; the one beyond the axis is not there.
      if (p == 0) {
        ASSERT_EQ(box.span_labels.size(), 2U);
        EXPECT_NE(box.span_labels[0].y_px, box.span_labels[1].y_px);
      }
      for (const SpanLabel& label : box.span_labels) {
        EXPECT_GT(label.y_px, box.top_px);
        EXPECT_LT(label.y_px, lowest_px - 8);
      }
      EXPECT_GT(lowest_px, box.top_px + 8);
      EXPECT_LT(box.title_px, above_px);
      if (columns == 1) above_px = box.bottom_px;
    }
    EXPECT_GT(place.panels[1].bottom_px, 30) << "room for the axis below";
    EXPECT_EQ(place.panels[0].legend.front().y_px == place.panels[0].legend.back().y_px, false);
  }
}

TEST(FigureLayout, SharesXInAColumnWhereAsked) {
  Figure figure = small_figure();
  EXPECT_EQ(layout(figure).panels[1].x.high, 10);
  EXPECT_FALSE(layout(figure).panels[0].x_written);
  EXPECT_TRUE(layout(figure).panels[1].x_written);
  figure.share_x = false;
  EXPECT_EQ(layout(figure).panels[1].x.high, 5);
  EXPECT_TRUE(layout(figure).panels[0].x_written);
  figure.panels[0].y_range = Range{-1, 77};
  EXPECT_EQ(layout(figure).panels[0].left.high, 77);
}

TEST(Thinned, KeepsPeaksAndGapsOfALongSeries) {
  std::vector<double> y(100000);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(1e-4 * static_cast<double>(i));
  y[31415] = 9;
  y[62831] = -9;
  for (std::size_t i = 50000; i < 50003; ++i) y[i] = kNaN;
  const auto kept = thinned(y, 2000);
  EXPECT_LE(kept.size(), 2001U);
  EXPECT_GE(kept.size(), 900U);
  const auto has = [&](std::size_t i) { return std::find(kept.begin(), kept.end(), i) != kept.end(); };
  EXPECT_TRUE(has(0) && has(31415) && has(62831) && has(99999) && has(49999) && has(50003));
  EXPECT_EQ(std::count(kept.begin(), kept.end(), kGap), 1);
  const auto gap = std::find(kept.begin(), kept.end(), kGap);
  EXPECT_LT(*(gap - 1), 50000U);
  EXPECT_GT(*(gap + 1), 50002U);
}

TEST(Thinned, LeavesAShortSeriesWhole) {
  const std::vector<double> y{kNaN, 1, 2, kNaN, kNaN, 3, kNaN};
  EXPECT_EQ(thinned(y, 100), (std::vector<std::size_t>{1, 2, kGap, 5}));
  EXPECT_TRUE(thinned(std::vector<double>{}, 100).empty());
  EXPECT_TRUE(thinned(std::vector<double>(5000, kNaN), 100).empty());
}

TEST(BodeFigure, HasGainOverPhaseAndTheLineOfMinusThree) {
  const Figure figure = bode_figure("loop", {{"ours", {0.1, 1, 10}, {0, -3, -20}, {0, -45, -90}}});
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_TRUE(figure.panels[0].log_x && figure.panels[1].log_x);
  EXPECT_EQ(figure.panels[0].curves[0].y[2], -20);
  EXPECT_EQ(figure.panels[1].curves[0].y[2], -90);
  EXPECT_EQ(figure.panels[0].curves[1].y, (std::vector<double>{-3, -3}));
  EXPECT_EQ(figure.panels[0].curves[1].x, (std::vector<double>{0.1, 10}));
  const TempDirectory folder;
  write_figure(folder / "bode.png", figure);
  EXPECT_EQ(read_png_rgb(folder / "bode.png").width_px, figure.width_px);
}

TEST(HeatMapGrid, HoldsEveryMap) {
  HeatMap map{"fitness", {"x, mm", -1, 1, 3}, {"z, mm", 0, 1, 2}, "fitness", {0, 1, 2, 3, 4, 5}, {}};
  map.marks = {{0, 0, "truth", 2}};
  const TempDirectory folder;
  write_heat_map_grid(folder / "maps.png", "four", {map, map, map}, 2);
  const RgbImage image = read_png_rgb(folder / "maps.png");
  EXPECT_EQ(image.width_px, 1440);
  EXPECT_EQ(image.height_px, 1240);
  EXPECT_THROW(write_heat_map_grid(folder / "none.png", "none", {}, 2), std::invalid_argument);
  // The palette's lower end fills a third of each map's lower row: three of four corners of the picture have
  // it.
  const auto dark_in = [&](int left, int top) {
    std::size_t count = 0;
    for (int y = top; y < top + 600; ++y) {
      for (int x = left; x < left + 500; ++x) {
        const std::uint8_t* p = image.at(x, y);
        if (p[0] < 6 && p[1] < 6 && p[2] > 0 && p[2] < 12) ++count;
      }
    }
    return count;
  };
  EXPECT_GT(dark_in(0, 40), 5000U);
  EXPECT_GT(dark_in(720, 40), 5000U);
  EXPECT_GT(dark_in(0, 640), 5000U);
  EXPECT_EQ(dark_in(720, 640), 0U);
}

TEST(Gnuplot, TakesTextForTextOnly) {
  EXPECT_EQ(gnuplot_quoted("it's\n\tso"), "'it''s  so'");
}

}  // namespace
}  // namespace vergence::tools
