#include "tools/draw/heat_map.hpp"

#include <iomanip>
#include <sstream>

#include "tools/draw/gnuplot.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

// gnuplot's image cells reach half a step beyond the outer values.
void set_range(std::ostream& script, const char* axis, const GridAxis& grid) {
  script << "set " << axis << "range [" << grid.first - 0.5 * grid.step << ":"
         << grid.last() + 0.5 * grid.step << "]\nset " << axis << "label " << gnuplot_quoted(grid.label)
         << "\n";
}

}  // namespace

void write_heat_map(const std::filesystem::path& png, const HeatMap& map) {
  require_writable(png);
  std::ostringstream script;
  script << std::setprecision(9) << "set terminal pngcairo size 960,800 font 'sans,12'\n"
         << "set output " << gnuplot_quoted(png.string()) << "\n"
         << "set title " << gnuplot_quoted(map.title) << " noenhanced\n"
         << "set tics out nomirror\n"
         << "set key below height 0.5 noenhanced\n"
         << "set cblabel " << gnuplot_quoted(map.value_label) << "\n"
         << "set palette defined (0 '#000004', 0.25 '#51127c', 0.5 '#b63679', 0.75 '#fb8861', 1 '#fcfdbf')\n";
  set_range(script, "x", map.x);
  set_range(script, "y", map.y);
  script << "$map << EOD\n";
  for (int iy = 0; iy < map.y.count; ++iy) {
    for (int ix = 0; ix < map.x.count; ++ix) {
      script << map.values[static_cast<std::size_t>(iy) * static_cast<std::size_t>(map.x.count) +
                           static_cast<std::size_t>(ix)]
             << (ix + 1 < map.x.count ? ' ' : '\n');
    }
  }
  script << "EOD\n";
  for (std::size_t i = 0; i < map.marks.size(); ++i) {
    script << "$mark" << i << " << EOD\n" << map.marks[i].x << ' ' << map.marks[i].y << "\nEOD\n";
  }
  script << "plot $map matrix using (" << map.x.first << "+$1*" << map.x.step << "):(" << map.y.first
         << "+$2*" << map.y.step << "):3 with image notitle";
  for (std::size_t i = 0; i < map.marks.size(); ++i) {
    const HeatMap::Mark& mark = map.marks[i];
    // A dark rim, so that the mark shows on any colour.
    script << ", $mark" << i << " with points pt " << mark.point_type << " ps 2.2 lw 5 lc '#202020' notitle"
           << ", $mark" << i << " with points pt " << mark.point_type << " ps 2.2 lw 2 lc '#40e0ff' title "
           << gnuplot_quoted(mark.label);
  }
  script << "\n";
  run_gnuplot(script.str());
}

}  // namespace vergence::tools
