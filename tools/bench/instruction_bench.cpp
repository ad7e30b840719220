#include "tools/bench/instruction_bench.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>

#include "tools/io/input_error.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::tools {

// Callgrind counts inside this function only; it must keep its name and not be inlined.
[[gnu::noinline]] Estimate vergence_counted_frame(Estimator& estimator, const BenchScene& scene) {
  return estimator.run({0, {}, {}}, scene.left, scene.right).estimate;
}

void run_counted_frame(const std::string& kind_and_content) {
  const std::size_t colon = kind_and_content.find(':');
  const std::string kind = kind_and_content.substr(0, colon);
  const std::string content = colon == std::string::npos ? "" : kind_and_content.substr(colon + 1);
  if (kind == "marker" || kind == "photo") {
    for (const BenchContent candidate : kBenchContents) {
      if (content != to_string(candidate)) continue;
      const BenchScene scene =
          make_bench_scene(kind == "marker" ? TargetKind::kMarker : TargetKind::kPhoto, candidate);
      EstimateOptions options;
      options.generations = 240;
      Estimator estimator(scene.dataset, options);
      (void)vergence_counted_frame(estimator, scene);
      return;
    }
  }
  throw InputError("bench", "--frame", "'" + kind_and_content + "' is not KIND:CONTENT",
                   "marker or photo, and present, absent, noise, black or saturated");
}

namespace {

double count_instructions(const std::filesystem::path& executable, const std::string& frame,
                          const std::filesystem::path& folder) {
  const std::filesystem::path out = folder / "callgrind.out";
  const std::string command =
      "valgrind -q --tool=callgrind --toggle-collect='*vergence_counted_frame*' --callgrind-out-file='" +
      out.string() + "' '" + executable.string() + "' bench --frame " + frame + " >/dev/null 2>&1";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("valgrind could not count " + frame);
  std::ifstream in(out);
  std::string word;
  while (in >> word) {
    if (word == "totals:" || word == "summary:") {
      double total = 0;
      in >> total;
      if (total > 0) return total;
    }
  }
  throw std::runtime_error("no instruction count in " + out.string());
}

}  // namespace

std::optional<InstructionBenchResult> run_instruction_bench(const std::filesystem::path& executable) {
  // It does not know all that the newest processors' libraries use.
  const std::string trial = "valgrind -q --tool=none '" + executable.string() + "' --version >/dev/null 2>&1";
  if (std::system(trial.c_str()) != 0) return {};
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("vergence-bench-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  InstructionBenchResult result;
  for (const TargetKind kind : {TargetKind::kMarker, TargetKind::kPhoto}) {
    double least = 1e300;
    double most = 0;
    for (const BenchContent content : kBenchContents) {
      const std::string frame =
          std::string(kind == TargetKind::kMarker ? "marker:" : "photo:") + to_string(content);
      const double count = count_instructions(executable, frame, folder);
      result.counts.push_back({kind, content, count});
      least = std::min(least, count);
      most = std::max(most, count);
    }
    result.spread = std::max(result.spread, most / least - 1);
  }
  std::filesystem::remove_all(folder);
  return result;
}

}  // namespace vergence::tools
