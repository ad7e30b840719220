#include "tools/accuracy/plots.hpp"

#include <algorithm>
#include <sstream>

#include "tools/draw/gnuplot.hpp"
#include "tools/io/writable.hpp"

namespace vergence::accuracy {
namespace {

struct Line {
  std::size_t panel = 0;  // data set
  std::string way;
  std::size_t colour = 1;
  std::vector<const StudyRow*> rows;
};

struct Lines {
  std::vector<std::string> panels;
  std::vector<std::string> ways;
  std::vector<Line> lines;
};

std::size_t index_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

Lines lines_of(const std::vector<StudyRow>& rows) {
  Lines result;
  for (const StudyRow& row : rows) {
    const std::size_t panel = index_of(result.panels, row.dataset);
    const std::string way = row.way.name();
    const std::size_t colour = index_of(result.ways, way);
    auto& lines = result.lines;
    if (lines.empty() || lines.back().panel != panel || lines.back().way != way) {
      lines.push_back({panel, way, colour, {}});
    }
    if (row.found > 0) lines.back().rows.push_back(&row);
  }
  return result;
}

// Told apart without colour as well.
constexpr const char* kColours[] = {"#888888", "#0072b2", "#e69f00", "#009e73"};
constexpr int kPoints[] = {6, 5, 9, 7};

}  // namespace

void write_generation_plot(const std::filesystem::path& png, const std::vector<StudyRow>& rows) {
  tools::require_writable(png);
  const Lines all = lines_of(rows);
  std::ostringstream script;
  script << "set terminal pngcairo size " << 120 + 270 * all.panels.size()
         << ",640 font 'Sans,11'\nset output " << tools::gnuplot_quoted(png.string())
         << "\nset multiplot layout 2," << all.panels.size()
         << " margins 0.06,0.99,0.15,0.93 spacing 0.045,0.06\nset logscale xy\nset grid lc rgb '#dddddd'\n"
            "set xrange [7:1300]\nset key off\nset xtics (9, 50, 200, 1000)\nset title noenhanced\n";
  for (std::size_t i = 0; i < all.lines.size(); ++i) {
    script << "$line" << i << " << EOD\n";
    for (const StudyRow* row : all.lines[i].rows) {
      script << row->generations << " " << row->rms_mm.norm() << " " << row->rms_e << "\n";
    }
    script << "EOD\n";
  }
  const auto panel = [&](std::size_t which, int column) {
    const bool lowest = column == 3;
    script << (lowest ? "set title ''\nset xlabel 'generations a frame'\nset yrange [0.0001:0.5]\n"
                      : "set title " + tools::gnuplot_quoted(all.panels[which]) +
                            "\nset xlabel ''\nset yrange [0.01:100]\n")
           << "set ylabel '"
           << (which > 0 ? ""
               : lowest  ? "RMS |e|"
                         : "RMS position, mm")
           << "'\n"
           << "set format y '%6g'\n"
           // One key for all of them, below.
           << (lowest && which == 0 ? "set key at screen 0.5,0.03 center maxrows 1\n" : "set key off\n")
           << "plot ";
    bool first = true;
    for (std::size_t i = 0; i < all.lines.size(); ++i) {
      const Line& line = all.lines[i];
      if (line.panel != which || line.rows.empty()) continue;
      script << (first ? "" : ", ") << "$line" << i << " using 1:" << column << " with linespoints lw 2 dt "
             << (line.colour == 0 ? 2 : 1) << " lc '" << kColours[line.colour % 4] << "' pt "
             << kPoints[line.colour % 4] << " notitle";
      first = false;
    }
    if (lowest && which == 0) {
      for (std::size_t w = 0; w < all.ways.size(); ++w) {
        script << (first ? "" : ", ") << "1/0 with linespoints lw 2 dt " << (w == 0 ? 2 : 1) << " lc '"
               << kColours[w % 4] << "' pt " << kPoints[w % 4] << " title "
               << tools::gnuplot_quoted(w == 0 ? all.ways[w] : "ours, " + all.ways[w]);
        first = false;
      }
    }
    script << (first ? "1/0 notitle\n" : "\n");
  };
  for (int column = 2; column <= 3; ++column) {
    for (std::size_t which = 0; which < all.panels.size(); ++which) panel(which, column);
  }
  script << "unset multiplot\n";
  tools::run_gnuplot(script.str());
}

void write_reliability_plot(const std::filesystem::path& png, const Reliability& r) {
  tools::require_writable(png);
  std::ostringstream script;
  script << "set terminal pngcairo size 640,640 font 'Sans,11'\nset output "
         << tools::gnuplot_quoted(png.string()) << "\n$bin << EOD\n";
  std::size_t most = 1;
  for (std::size_t i = 0; i < kReliabilityBins; ++i) {
    const ReliabilityBin& bin = r.bin[i];
    most = std::max(most, bin.frames);
    script << (static_cast<double>(i) + 0.5) / kReliabilityBins << " " << bin.frames << " ";
    if (bin.frames > 0) {
      script << bin.mean_confidence << " " << bin.right << "\n";
    } else {
      script << "NaN NaN\n";
    }
  }
  script << "EOD\nset multiplot\nset grid lc rgb '#dddddd'\nset xrange [0:1]\nset xtics 0.1\nset lmargin at "
            "screen 0.13\n"
            "set rmargin at screen 0.96\n"
            "set tmargin at screen 0.95\nset bmargin at screen 0.36\nset yrange [0:1.05]\nset format x ''\n"
            "set ylabel 'share of right poses'\nset key bottom right\n"
            "plot x with lines dt 2 lw 1.5 lc '#888888' title 'as stated', "
            "$bin using 3:4 with linespoints lw 2 pt 7 ps 1.3 lc '#0072b2' title 'observed'\n"
            "set tmargin at screen 0.32\nset bmargin at screen 0.11\nset format x '%g'\nset logscale y\n"
            "set yrange [0.7:"
         << 3 * most
         << "]\nset format y '%g'\nset ytics 10\nset ylabel 'frames'\nset xlabel 'stated confidence'\nset "
            "key off\n"
            "set boxwidth 0.08\nset style fill solid 0.6 noborder\n"
            "plot $bin using 1:2 with boxes lc '#0072b2', $bin using 1:2:2 with labels offset 0,0.6 font "
            "'Sans,9'\nunset multiplot\n";
  tools::run_gnuplot(script.str());
}

}  // namespace vergence::accuracy
