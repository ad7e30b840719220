// `vergence estimate`: the pose of the target in every frame of a data set.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/commands.hpp"
#include "tools/cli/estimate_report.hpp"
#include "tools/cli/frame_range.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/progress.hpp"
#include "tools/draw/overlay.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::tools {
namespace {

struct Options {
  std::filesystem::path directory;
  std::string frames = "0:";
  EstimateOptions estimate;
  std::string method = "vergence";
  std::string coding;
  std::string stage = "relief";
  std::optional<double> mutation;
  std::optional<double> min_saturation;
  std::string json;
  std::filesystem::path overlay;
  bool no_progress = false;
};

EstimateOptions estimate_options(const Options& options) {
  EstimateOptions result = options.estimate;
  result.method = parse_method(options.method);
  if (!options.coding.empty()) {
    result.coding = options.coding == "gray" ? GeneCoding::kGray : GeneCoding::kBinary;
  }
  result.last_stage = *parse_stage(options.stage);
  if (options.mutation) result.mutation_per_1024 = static_cast<int>(*options.mutation * 1024 + 0.5);
  if (options.min_saturation) {
    result.min_saturation_permille = static_cast<int>(*options.min_saturation * 1000 + 0.5);
  }
  return result;
}

// Where the JSON lines go: nowhere, stdout ("-"), or a file.
class JsonLines {
 public:
  explicit JsonLines(const std::string& target) {
    if (target.empty()) return;
    if (target == "-") {
      out_ = &std::cout;
      return;
    }
    require_writable(target);
    file_.open(target);
    out_ = &file_;
  }

  void print(const std::string& line) {
    if (out_ == nullptr) return;
    *out_ << line << std::endl;
    if (!*out_) throw std::runtime_error("writing the JSON lines failed");
  }

 private:
  std::ofstream file_;
  std::ostream* out_ = nullptr;
};

std::vector<Frame> chosen_frames(const Dataset& dataset, const std::string& text) {
  const FrameRange range = parse_frame_range(text);
  std::vector<Frame> frames;
  for (const Frame& frame : dataset.frames) {
    if (range.contains(frame.number)) frames.push_back(frame);
  }
  if (frames.empty()) {
    throw InputError(dataset.directory, "--frames", "no frame in " + text,
                     "there are " + std::to_string(dataset.frames.front().number) + " to " +
                         std::to_string(dataset.frames.back().number));
  }
  return frames;
}

// Not an error: a part of a data set may have been copied. But a misspelt number should not go unseen.
void warn_of_truth_without_images(const Dataset& dataset) {
  std::size_t missing = 0;
  int first = 0;
  for (const auto& [number, truth] : dataset.truth) {
    const bool there = std::any_of(dataset.frames.begin(), dataset.frames.end(),
                                   [n = number](const Frame& frame) { return frame.number == n; });
    if (!there && missing++ == 0) first = number;
  }
  if (missing == 0) return;
  std::cerr << "vergence: warning: " << (dataset.directory / "truth.csv").string() << ": " << missing
            << " frames have no images, the first is " << first << '\n';
}

void run(const Options& options) {
  const Dataset dataset = read_dataset(options.directory);
  warn_of_truth_without_images(dataset);
  const std::vector<Frame> frames = chosen_frames(dataset, options.frames);
  Estimator estimator(dataset, estimate_options(options));

  JsonLines json(options.json);
  if (!options.overlay.empty()) make_directory(options.overlay);
  const bool human = options.json != "-";
  EstimateTable table(std::cout, !dataset.truth.empty());
  Progress progress("estimate", frames.size(), !options.no_progress);
  std::vector<FrameResult> results;
  for (const Frame& frame : frames) {
    const auto [left, right] = read_frame(dataset, frame);
    const FrameResult result = estimator.run(frame, left, right);
    progress.hide();
    if (human) table.print(result);
    json.print(to_json(result, options.estimate.seed));
    if (!options.overlay.empty()) {
      write_png(options.overlay / frame.left.filename(),
                draw_overlay(dataset, estimator, result, left, right));
    }
    results.push_back(result);
    progress.step();
  }
  progress.hide();
  if (human) print_summary(std::cout, results);
}

}  // namespace

void add_estimate_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("estimate", "Pose of the target in each frame of a data set");
  const auto options = std::make_shared<Options>();
  EstimateOptions& estimate = options->estimate;
  command->add_option("DIR", options->directory, "Data set: rig.toml, model/, search.toml, left/, right/")
      ->required();
  command->add_option("--frames", options->frames, "Frame numbers A:B, up to but without B; also A:, :B, A")
      ->type_name("A:B");
  command->add_option("--seed", estimate.seed, "Of the random numbers: equal seeds give equal poses")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--generations", estimate.generations,
                   "Budget of a frame; default: what searching or tracking usually takes")
      ->type_name("G")
      ->check(CLI::Range(0, 1'000'000));
  command
      ->add_option("--budget-ms", estimate.budget_ms,
                   "Budget of a frame by the clock, refinement included (not repeatable); with --generations "
                   "only a guard")
      ->type_name("X")
      ->check(within(0.001, 1e6));
  command->add_flag("--cold", estimate.cold, "Forget everything between frames: each is searched anew");
  command
      ->add_option("--json", options->json, "One JSON object a line to FILE; - is stdout, without the table")
      ->type_name("FILE");
  add_method_option(*command, options->method);
  command->add_option("--overlay", options->overlay, "Draw the posed model over each pair, as PNGs in OUTDIR")
      ->type_name("OUTDIR");
  command->add_flag("--no-progress", options->no_progress, "No progress bar");

  const auto tuning = [&](const char* name, auto& value, const char* text) {
    return command->add_option(name, value, text)->group("Tuning");
  };
  tuning("--set-points", estimate.photo_points, "Points of the photo-model")
      ->check(CLI::Range(20, kMaxPhotoPoints))
      ->capture_default_str();
  tuning("--set-coding", options->coding, "Of the genes: gray or binary")
      ->check(CLI::IsMember({"gray", "binary"}));
  tuning("--set-mutation", options->mutation, "Probability of a bit to flip")->check(within(0.0, 1.0));
  tuning("--set-stage", options->stage, "Last stage of a pose: evolved, refined, or relief (the learned one)")
      ->check(CLI::IsMember({"evolved", "refined", "relief"}))
      ->capture_default_str();
  tuning("--set-min-saturation", options->min_saturation, "Pixels below it have no hue")
      ->check(within(0.0, 1.0));
  command->footer(
      "Examples:\n"
      "  vergence estimate lab/crab\n"
      "  vergence estimate lab/crab --frames 100:200 --json poses.jsonl --overlay out\n"
      "  vergence estimate lab/crab --cold --budget-ms 33 --json - | jq .pose");
  command->callback([options] { run(*options); });
}

}  // namespace vergence::tools
