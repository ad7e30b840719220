// `vergence bench rt`: is this machine fit for the controller, and what to mend.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "tools/bench/rt_bench.hpp"
#include "tools/bench/rt_report.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/progress.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Options {
  RtBenchOptions bench;
  std::filesystem::path json;
};

void run(const Options& options) {
  if (!options.json.empty()) require_writable(options.json);
  RtBenchResult result;
  {
    const int slices = rt_bench_slices(options.bench.seconds) * (options.bench.stress ? 2 : 1);
    Progress progress("bench rt", static_cast<std::size_t>(slices));
    result = run_rt_bench(options.bench, [&progress] { progress.step(); });
  }
  std::printf("%s", rt_report_text(result).c_str());
  if (options.json.empty()) return;
  std::ofstream out(options.json);
  out << rt_report_json(result) << '\n';
  if (!out.flush()) throw std::runtime_error("cannot write " + options.json.string());
}

}  // namespace

CLI::App* add_bench_rt_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("rt", "Is this machine fit for real time, and what to mend");
  const auto options = std::make_shared<Options>();
  constexpr int kMost_s = 24 * 3600;
  command
      ->add_option("--seconds", options->bench.seconds,
                   "Measure for so long; cyclictest takes as long again, and so does --stress")
      ->check(CLI::Range(1, kMost_s))
      ->capture_default_str();
  command->add_flag("--stress", options->bench.stress, "Again with all cores loaded by stress-ng");
  command->add_option("--json", options->json, "Write the numbers there")->type_name("FILE");
  command->footer(
      "Run it as the user the controller will run as, with the same limits. A machine is judged by its "
      "worst\n"
      "moment: measure under load, and for hours before it is trusted.");
  command->callback([options] { run(*options); });
  return command;
}

}  // namespace vergence::tools
