#include "tools/draw/heat_map.hpp"

#include <iomanip>
#include <sstream>
#include <stdexcept>

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

// Blocks cannot stand between the plots of a multiplot; names hold the map's number.
void write_data(std::ostream& script, const HeatMap& map, std::size_t number) {
  script << "$map" << number << " << EOD\n";
  for (int iy = 0; iy < map.y.count; ++iy) {
    for (int ix = 0; ix < map.x.count; ++ix) {
      script << map.values[static_cast<std::size_t>(iy) * static_cast<std::size_t>(map.x.count) +
                           static_cast<std::size_t>(ix)]
             << (ix + 1 < map.x.count ? ' ' : '\n');
    }
  }
  script << "EOD\n";
  for (std::size_t i = 0; i < map.marks.size(); ++i) {
    script << "$mark" << number << "_" << i << " << EOD\n"
           << map.marks[i].x << ' ' << map.marks[i].y << "\nEOD\n";
  }
}

void write_plot(std::ostream& script, const HeatMap& map, std::size_t number) {
  script << "set title " << gnuplot_quoted(map.title) << " noenhanced\n"
         << "set cblabel " << gnuplot_quoted(map.value_label) << "\n";
  set_range(script, "x", map.x);
  set_range(script, "y", map.y);
  script << "plot $map" << number << " matrix using (" << map.x.first << "+$1*" << map.x.step << "):("
         << map.y.first << "+$2*" << map.y.step << "):3 with image notitle";
  for (std::size_t i = 0; i < map.marks.size(); ++i) {
    const HeatMap::Mark& mark = map.marks[i];
    const std::string block = "$mark" + std::to_string(number) + "_" + std::to_string(i);
    // A dark rim, so that the mark shows on any colour.
    script << ", " << block << " with points pt " << mark.point_type << " ps 2.2 lw 5 lc '#202020' notitle"
           << ", " << block << " with points pt " << mark.point_type << " ps 2.2 lw 2 lc '#40e0ff' title "
           << gnuplot_quoted(mark.label);
  }
  script << "\n";
}

void draw(const std::filesystem::path& png, const std::vector<HeatMap>& maps, const std::string& size,
          const std::string& multiplot) {
  require_writable(png);
  std::ostringstream script;
  script << std::setprecision(9) << "set terminal pngcairo size " << size << " font 'sans,12'\n"
         << "set output " << gnuplot_quoted(png.string()) << "\n"
         << "set tics out nomirror\n"
         << "set key below height 0.5 noenhanced\n"
         << "set palette defined (0 '#000004', 0.25 '#51127c', 0.5 '#b63679', 0.75 '#fb8861', 1 '#fcfdbf')\n";
  for (std::size_t i = 0; i < maps.size(); ++i) write_data(script, maps[i], i);
  script << multiplot;
  for (std::size_t i = 0; i < maps.size(); ++i) write_plot(script, maps[i], i);
  run_gnuplot(script.str());
}

}  // namespace

void write_heat_map(const std::filesystem::path& png, const HeatMap& map) {
  draw(png, {map}, "960,800", "");
}

void write_heat_map_grid(const std::filesystem::path& png, const std::string& title,
                         const std::vector<HeatMap>& maps, int columns) {
  if (maps.empty() || columns < 1) throw std::invalid_argument("a figure without maps");
  const int rows = (static_cast<int>(maps.size()) + columns - 1) / columns;
  draw(png, maps, std::to_string(720 * columns) + "," + std::to_string(600 * rows + 40),
       "set multiplot layout " + std::to_string(rows) + "," + std::to_string(columns) + " title " +
           gnuplot_quoted(title) + " noenhanced font 'sans:Bold,14'\n");
}

}  // namespace vergence::tools
