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
#include "tools/calibrate/frame_poses.hpp"
#include "tools/calibrate/hand_eye.hpp"
#include "tools/calibrate/hand_poses.hpp"
#include "tools/calibrate/picture_file.hpp"
#include "tools/calibrate/rig_file.hpp"
#include "tools/calibrate/sightings.hpp"
#include "tools/calibrate/stereo.hpp"
#include "tools/calibrate/time_offset.hpp"
#include "tools/cli/calibrate_report.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/progress.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Options {
  std::filesystem::path directory;
  std::string board;
  double square_mm = 0;
  std::filesystem::path out;
  std::string json;
  bool no_progress = false;
  calibrate::StereoOptions stereo;
  std::filesystem::path overlay;
  std::filesystem::path rig;
  calibrate::HandEyeOptions hand_eye;
  double range_ms = 200;
  std::string in_camera;
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
  if (!options.out.empty()) {
    const std::filesystem::path beside = options.out.string() + ".new";  // where it is written first
    require_writable(beside);
    std::filesystem::remove(beside);
  }
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

void run_hand_eye(const Options& options) {
  const calibrate::Board board = board_of(options);
  if (board.is_symmetric()) {
    throw CLI::ValidationError(
        "--board", options.board +
                       " looks the same after half a turn, so its place in the world is in doubt; "
                       "use a board of which one number is odd and one even, as 9x6");
  }
  require_places(options);
  const StereoRig rig = read_rig(options.rig);
  const std::filesystem::path table = options.directory / "hand.csv";
  const auto T_W_H = calibrate::read_numbered_poses(table);
  const calibrate::Sightings sightings = find_board(options, board);
  if (sightings.width_px != rig.left.width_px || sightings.height_px != rig.left.height_px) {
    throw InputError(options.rig, "image",
                     "says " + std::to_string(rig.left.width_px) + " x " +
                         std::to_string(rig.left.height_px) + " but the pictures are " +
                         std::to_string(sightings.width_px) + " x " + std::to_string(sightings.height_px),
                     "calibrate stereo with pictures of this size first");
  }
  const calibrate::HandEye result =
      calibrate::calibrate_hand_eye(table, T_W_H, sightings, board, rig, options.hand_eye);
  calibrate::write_rig(
      options.out, result.rig,
      {"By `vergence calibrate hand-eye`: " + std::to_string(result.views.size()) + " views, RMS " +
           number_text("%.3f", result.rms_px[0]) + " and " + number_text("%.3f", result.rms_px[1]) + " px, " +
           number_text("%.3f", result.rms_mm) + " mm.",
       "The hand frame is that of hand.csv; focal lengths and distortion are as they were."});
  if (options.json != "-") {
    print_hand_eye(std::cout, result, sightings.skipped);
    std::cout << "written     " << options.out.string() << '\n';
  }
  write_json(options.json, to_json(result, sightings.skipped));
}

void run_time_offset(const Options& options) {
  require_places(options);
  calibrate::FramePoses frames = calibrate::read_frame_poses(options.directory);
  const std::filesystem::path table = options.directory / "hand.csv";
  const auto hand = calibrate::read_timed_poses(table);
  if (!options.in_camera.empty()) {
    const StereoRig rig = read_rig(options.rig);
    const Transform& T_H_C = options.in_camera == "left" ? rig.left.T_H_C : rig.right.T_H_C;
    for (calibrate::TimedPose& frame : frames.poses) frame.T = T_H_C * frame.T;
  }
  const calibrate::TimeOffset result =
      calibrate::find_time_offset({frames.file, table}, frames.poses, hand, options.range_ms);
  if (options.json != "-") print_time_offset(std::cout, result);
  write_json(options.json, to_json(result));
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

void add_json_option(CLI::App& command, Options& options) {
  command.add_option("--json", options.json, "All numbers to FILE; - is stdout, without the tables")
      ->type_name("FILE");
}

void add_output_options(CLI::App& command, Options& options) {
  add_json_option(command, options);
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

void add_hand_eye(CLI::App& parent, const std::shared_ptr<Options>& options) {
  CLI::App* command = parent.add_subcommand("hand-eye", "Where the cameras sit in the hand");
  command
      ->add_option("DIR", options->directory,
                   "Pictures as for stereo, and hand.csv: frame,x_mm,y_mm,z_mm,e1,e2,e3")
      ->required();
  command->add_option("--rig", options->rig, "The rig.toml that stereo wrote")->type_name("FILE")->required();
  add_board_options(*command, *options);
  command->add_flag("--keep-stereo", options->hand_eye.keep_stereo,
                    "Leave the pose between the cameras as it is in the rig");
  add_output_options(*command, *options);
  command->footer(
      "The board stands still; hand.csv holds the pose of the hand in the world at each pair of pictures.\n"
      "\nExample:\n"
      "  vergence calibrate hand-eye shots --rig rig.toml --board 9x6 --square-mm 25 -o rig.toml");
  command->callback([options] { run_hand_eye(*options); });
}

void add_time_offset(CLI::App& parent, const std::shared_ptr<Options>& options) {
  CLI::App* command = parent.add_subcommand("time-offset", "Between the cameras' stamps and the hand's");
  command
      ->add_option(
          "DIR", options->directory,
          "hand.csv: t_s,x_mm,y_mm,z_mm,e1,e2,e3; and frames.csv with the same columns, or frames.jsonl "
          "as `vergence estimate --json` writes it, with stamps.csv: frame,t_s")
      ->required();
  command->add_option("--range-ms", options->range_ms, "Offsets up to this are looked at, either way")
      ->type_name("R")
      ->check(within(10, 5000))
      ->capture_default_str();
  CLI::Option* rig = command->add_option("--rig", options->rig, "For --in-camera")->type_name("FILE");
  CLI::Option* in_camera = command
                               ->add_option("--in-camera", options->in_camera,
                                            "The frames' poses are in this camera, not in the hand")
                               ->check(CLI::IsMember({"left", "right"}))
                               ->needs(rig);
  rig->needs(in_camera);
  add_json_option(*command, *options);
  command->footer(
      "\nExample:\n"
      "  vergence estimate sway --json sway/frames.jsonl && vergence calibrate time-offset sway");
  command->callback([options] { run_time_offset(*options); });
}

}  // namespace

void add_calibrate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("calibrate", "Cameras, their place in the hand, and their stamps");
  command->require_subcommand(1);
  const auto options = std::make_shared<Options>();
  add_stereo(*command, options);
  add_hand_eye(*command, options);
  add_time_offset(*command, options);
}

}  // namespace vergence::tools
