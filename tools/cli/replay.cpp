// `vergence replay`: runs again what a summary tells of, and says whether the same came out.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tools/cli/commands.hpp"
#include "tools/cli/progress.hpp"
#include "tools/demo/scenario.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

struct Recorded {
  const demo::Scenario* scenario;
  std::uint64_t seed;
  std::string signature;
};

Recorded read_summary(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be read", "the summary.json of a demo's report");
  const nlohmann::json summary = nlohmann::json::parse(in, nullptr, false);
  if (!summary.is_object())
    throw InputError(file, "", "is no JSON object", "the summary.json of a demo's report");
  for (const char* const key : {"scenario", "signature"}) {
    if (!summary.contains(key) || !summary[key].is_string())
      throw InputError(file, key, "missing or no text");
  }
  if (!summary.contains("seed") || !summary["seed"].is_number_unsigned()) {
    throw InputError(file, "seed", "missing or no number");
  }
  const demo::Scenario* scenario = demo::find_scenario(summary["scenario"].get<std::string>());
  if (scenario == nullptr) throw InputError(file, "scenario", "is none of `vergence demo --list`");
  return {scenario, summary["seed"].get<std::uint64_t>(), summary["signature"].get<std::string>()};
}

void replay(const std::filesystem::path& file, const std::filesystem::path& out) {
  const Recorded recorded = read_summary(file);
  make_directory(out);
  constexpr int kBarSteps = 100;
  Progress bar(recorded.scenario->name, kBarSteps);
  int shown = 0;
  demo::RunOptions options;
  options.seed = recorded.seed;
  options.out = out;
  options.progress = [&](double share) {
    for (; shown < kBarSteps * share; ++shown) bar.step();
  };
  const Summary summary = demo::run_with_report(*recorded.scenario, options);
  bar.hide();
  std::printf("signature %s\n", summary.signature.c_str());
  if (summary.signature != recorded.signature) {
    throw std::runtime_error(file.string() + " has signature " + recorded.signature +
                             ": it was recorded by another version");
  }
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("replay", "Run a recorded demo again and compare its signature");
  const auto file = std::make_shared<std::filesystem::path>();
  const auto out = std::make_shared<std::filesystem::path>("out/replay");
  command->add_option("FILE", *file, "summary.json of a demo's report")->required();
  command->add_option("-o,--out", *out, "Directory of the new report")
      ->type_name("DIR")
      ->capture_default_str();
  command->callback([file, out] { replay(*file, *out); });
}

}  // namespace vergence::tools
