// `vergence calibrate`: the cameras, their place in the hand and their stamps, from pictures of a chessboard.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "tools/calibrate/draw_views.hpp"
#include "tools/calibrate/picture_file.hpp"
#include "tools/calibrate/rig_file.hpp"
#include "tools/calibrate/sightings.hpp"
#include "tools/calibrate/stereo.hpp"
#include "tools/cli/calibrate_report.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/progress.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Options {
  std::filesystem::path directory;
  std::string board = "9x6";
  double square_mm = 0;
  std::filesystem::path out;
  std::string json;
  bool no_progress = false;
  calibrate::StereoOptions stereo;
  std::filesystem::path overlay;
};

calibrate::Board board_of(const Options& options) {
  try {
    return calibrate::parse_board(options.board, options.square_mm);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError("--board", error.what());
  }
}

// What is wrong with a place should be known before the work, not after it.
void require_places(const Options& options) {
  if (!options.out.empty()) require_writable(options.out.string() + ".new");
  if (!options.json.empty() && options.json != "-") require_writable(options.json);
  if (!options.overlay.empty()) make_directory(options.overlay);
}

void write_json(const std::string& target, const std::string& json) {
  if (target.empty()) return;
  if (target == "-") {
    std::cout << json;
    return;
  }
  std::ofstream out(target);
  out << json;
  if (!out.flush()) throw std::runtime_error("writing " + target + " failed");
}

calibrate::Sightings find_board(const Options& options, const calibrate::Board& board) {
  const auto pairs = calibrate::list_pairs(options.directory);
  Progress progress("corners", pairs.size(), !options.no_progress);
  return calibrate::find_board(pairs, board, [&] { progress.step(); });
}

void write_overlays(const Options& options, const calibrate::Board& board,
                    const calibrate::Sightings& sightings, const calibrate::StereoCalibration& result) {
  if (options.overlay.empty()) return;
  for (std::size_t i = 0; i < sightings.seen.size(); ++i) {
    const calibrate::Sighting& sighting = sightings.seen[i];
    std::string name = std::to_string(sighting.pair.number);
    if (name.size() < 6) name.insert(0, 6 - name.size(), '0');
    const std::array<GreyImage, 2> images{calibrate::read_picture(sighting.pair.files[0]),
                                          calibrate::read_picture(sighting.pair.files[1])};
    write_png(options.overlay / (name + ".png"),
              calibrate::draw_view(images, sighting, result.views[i], result, board));
  }
}

std::string number_text(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

void run_stereo(const Options& options) {
  const calibrate::Board board = board_of(options);
  require_places(options);
  const calibrate::Sightings sightings = find_board(options, board);
  const calibrate::StereoCalibration result =
      calibrate::calibrate_stereo(options.directory, sightings, board, options.stereo);
  const auto used =
      std::count_if(result.views.begin(), result.views.end(), [](const auto& view) { return view.used; });
  calibrate::write_rig(
      options.out, result.rig,
      {"By `vergence calibrate stereo`: " + std::to_string(used) + " views, RMS " +
           number_text("%.3f", result.rms_px[0]) + " and " + number_text("%.3f", result.rms_px[1]) +
           " px, baseline " + number_text("%.3f", result.baseline_mm) + " mm.",
       "The hand frame is midway between the cameras: x from left to right, z forward."});
  write_overlays(options, board, sightings, result);
  if (options.json != "-") {
    print_stereo(std::cout, result, sightings.skipped);
    std::cout << "written     " << options.out.string() << '\n';
  }
  write_json(options.json, to_json(result, sightings.skipped));
}

void add_board_options(CLI::App& command, Options& options) {
  command.add_option("--board", options.board, "Inner corners in a row and a column")
      ->type_name("COLSxROWS")
      ->required();
  command.add_option("--square-mm", options.square_mm, "Side of a square, measured on the print")
      ->type_name("S")
      ->check(within(0.1, 1000))
      ->required();
  command.add_option("-o,--out", options.out, "The rig.toml to write")->type_name("FILE")->required();
}

void add_output_options(CLI::App& command, Options& options) {
  command.add_option("--json", options.json, "All numbers to FILE; - is stdout, without the tables")
      ->type_name("FILE");
  command.add_flag("--no-progress", options.no_progress, "No progress bar");
}

void add_stereo(CLI::App& parent, const std::shared_ptr<Options>& options) {
  CLI::App* command =
      parent.add_subcommand("stereo", "Focal lengths, distortion and baseline of both cameras");
  command
      ->add_option("DIR", options->directory,
                   "left/000000.png and right/000000.png, ..., or left01.jpg, right01.jpg")
      ->required();
  add_board_options(*command, *options);
  command
      ->add_option("--max-reprojection-px", options->stereo.max_reprojection_px,
                   "Leave out views with a larger RMS error; default: 2.5 times the middle one's")
      ->type_name("X")
      ->check(within(0.001, 1000));
  add_output_options(*command, *options);
  command
      ->add_option("--overlay", options->overlay,
                   "Draw corners and their errors over each pair, as PNGs in OUTDIR")
      ->type_name("OUTDIR");
  command->footer(
      "\nExample:\n"
      "  vergence calibrate stereo shots --board 9x6 --square-mm 25 -o rig.toml --overlay out");
  command->callback([options] { run_stereo(*options); });
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Cameras, their place in the hand, and their stamps");
  command->require_subcommand(1);
  const auto options = std::make_shared<Options>();
  add_stereo(*command, options);
}

}  // namespace vergence::tools
