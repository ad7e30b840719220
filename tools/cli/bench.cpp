// `vergence bench`: the measurements behind the claims, as ratios taken in one run on one machine.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/bench/fitness_bench.hpp"
#include "tools/bench/hue_bench.hpp"
#include "tools/bench/instruction_bench.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/progress.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Options {
  std::filesystem::path json;
  bool quick = false;
  std::string frame;
};

struct Results {
  FitnessBenchResult fitness;
  HueBenchResult hue;
  std::optional<InstructionBenchResult> instructions;
};

Results measure(bool quick) {
  Progress progress("bench", 3);
  Results results;
  results.fitness = run_fitness_bench(quick ? 21 : 201);
  progress.step();
  results.hue = run_hue_bench(quick ? 21 : 201);
  progress.step();
  results.instructions = run_instruction_bench(std::filesystem::read_symlink("/proc/self/exe"));
  progress.step();
  return results;
}

void print_ratios(const Results& results) {
  const FitnessBenchResult& fitness = results.fitness;
  const HueBenchResult& hue = results.hue;
  std::printf("%-34s %12s   %s\n", "fitness, one thread", "ns/sample",
              "times as fast as the plain evaluator");
  std::printf("%-34s %12.3f   %.1f\n", "  marker (360 samples)", fitness.marker_ns_per_sample,
              fitness.marker_speedup_vs_scalar);
  std::printf("%-34s %12.3f   %.1f\n", "  photo-model (about 2000)", fitness.photo_ns_per_sample,
              fitness.photo_speedup_vs_scalar);
  std::printf("%-34s %12.3f\n", "  photo-model, correlation", fitness.correlation_ns_per_sample);
  std::printf("\n%-34s %12s   %s\n", "hue of a stereo pair, one thread", "ns/pixel",
              "share of OpenCV's time");
  const auto hue_row = [](const char* name, const PairOfTimes& times) {
    std::printf("%-34s %12.3f   %.3f\n", name, times.ours_ns, times.ratio);
  };
  hue_row("  YUYV, a scene", hue.scene.yuyv);
  hue_row("  YUYV, random bytes", hue.noise.yuyv);
  hue_row("  RGB, a scene", hue.scene.rgb);
  hue_row("  RGB, random bytes", hue.noise.rgb);
  std::printf("\ngenerations in 24 ms                 marker %d, photo-model %d (the thesis: 9)\n",
              fitness.generations_in_24ms_marker, fitness.generations_in_24ms_photo);
}

void print_instructions(const std::optional<InstructionBenchResult>& instructions) {
  if (!instructions) {
    std::printf(
        "\ninstructions of a frame: not counted (needs valgrind, and a processor it knows: apt install "
        "valgrind)\n");
    return;
  }
  std::printf("\n%-34s %12s\n", "instructions of a frame", "millions");
  for (const InstructionCount& count : instructions->counts) {
    const std::string name =
        std::string(count.kind == TargetKind::kMarker ? "  marker, " : "  photo-model, ") +
        to_string(count.content);
    std::printf("%-34s %12.3f\n", name.c_str(), count.instructions / 1e6);
  }
  std::printf("%-34s %11.3f%%\n", "  largest over smallest", 100 * instructions->spread);
}

std::string to_json(const Results& results) {
  const FitnessBenchResult& fitness = results.fitness;
  nlohmann::ordered_json json = {
      {"marker_ns_per_sample", fitness.marker_ns_per_sample},
      {"photo_ns_per_sample", fitness.photo_ns_per_sample},
      {"correlation_ns_per_sample", fitness.correlation_ns_per_sample},
      {"marker_speedup_vs_scalar", fitness.marker_speedup_vs_scalar},
      {"photo_speedup_vs_scalar", fitness.photo_speedup_vs_scalar},
      {"hue_time_ratio_vs_opencv", results.hue.hue_time_ratio_vs_opencv},
      {"rgb_hue_time_ratio_vs_opencv", results.hue.rgb_hue_time_ratio_vs_opencv},
      {"yuyv_time_ratio_vs_hsv_alone", results.hue.yuyv_time_ratio_vs_hsv_alone},
      {"generations_in_24ms_marker", fitness.generations_in_24ms_marker},
      {"generations_in_24ms_photo", fitness.generations_in_24ms_photo},
      {"instructions_spread", nullptr},
  };
  if (results.instructions) json["instructions_spread"] = results.instructions->spread;
  return json.dump(2);
}

void run(const Options& options) {
  if (!options.frame.empty()) {
    run_counted_frame(options.frame);
    return;
  }
  if (!options.json.empty()) require_writable(options.json);
  const Results results = measure(options.quick);
  print_ratios(results);
  print_instructions(results.instructions);
  if (options.json.empty()) return;
  std::ofstream out(options.json);
  out << to_json(results) << '\n';
  if (!out.flush()) throw std::runtime_error("cannot write " + options.json.string());
}

}  // namespace

void add_bench_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("bench", "The measurements behind our claims, as ratios in one run");
  const auto options = std::make_shared<Options>();
  CLI::Option* json =
      command->add_option("--json", options->json, "Write the numbers there, one flat object");
  json->type_name("FILE");
  CLI::Option* quick = command->add_flag("--quick", options->quick, "Fewer repetitions, rougher numbers");
  // What runs under valgrind, to have its instructions counted.
  command->add_option("--frame", options->frame)->group("");
  add_bench_rt_command(*command)->excludes(json)->excludes(quick);
  command->footer(
      "Times are medians over many turns, ours and the rival's taken turn by turn. Instructions are counted "
      "with\n"
      "valgrind, where it is installed: the work of a frame must not depend on what the cameras see.");
  command->callback([options, command] {
    if (command->get_subcommands().empty()) run(*options);
  });
}

}  // namespace vergence::tools
