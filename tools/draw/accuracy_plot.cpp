#include "tools/draw/accuracy_plot.hpp"

#include <sstream>

#include "tools/draw/gnuplot.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Line {
  std::string name;
  Method method;
  std::vector<const StudyRow*> rows;
};

std::vector<Line> lines_of(const std::vector<StudyRow>& rows) {
  std::vector<Line> lines;
  for (const StudyRow& row : rows) {
    if (lines.empty() || lines.back().name != row.dataset || lines.back().method != row.method) {
      lines.push_back({row.dataset, row.method, {}});
    }
    if (row.found > 0) lines.back().rows.push_back(&row);
  }
  return lines;
}

}  // namespace

void write_accuracy_plot(const std::filesystem::path& png, const std::vector<StudyRow>& rows) {
  const std::vector<Line> lines = lines_of(rows);
  std::ostringstream script;
  script << "set terminal pngcairo size 1200,520 font 'Sans,10'\nset output " << gnuplot_quoted(png.string())
         << "\nset multiplot layout 1,2\nset logscale xy\nset grid\nset xrange [7:1300]\nset xlabel "
            "'generations a frame'\n"
            "set key outside below maxcols 2 noenhanced\nset xtics (9, 50, 200, 1000)\n";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    script << "$line" << i << " << EOD\n";
    for (const StudyRow* row : lines[i].rows) {
      script << row->generations << " " << row->rms_mm.norm() << " " << row->rms_e << "\n";
    }
    script << "EOD\n";
  }
  const auto panel = [&](const char* label, int column) {
    script << "set ylabel '" << label << "'\nplot ";
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const bool thesis = lines[i].method == Method::kThesis;
      script << (i > 0 ? ", " : "") << "$line" << i << " using 1:" << column << " with linespoints lw 2 dt "
             << (thesis ? 2 : 1) << " lc " << i / 2 + 1 << " pt " << (thesis ? 6 : 7) << " title "
             << gnuplot_quoted(lines[i].name + (thesis ? ", thesis" : ", ours"));
    }
    script << "\n";
  };
  panel("RMS position error in mm", 2);
  panel("RMS orientation error |e|", 3);
  script << "unset multiplot\n";
  run_gnuplot(script.str());
}

}  // namespace vergence::tools
