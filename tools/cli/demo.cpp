// `vergence demo`: experiments on the simulated robot.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/cli/commands.hpp"
#include "tools/cli/progress.hpp"
#include "tools/demo/scenario.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/run/parallel.hpp"

namespace vergence::tools {
namespace {

using demo::Scenario;

constexpr const char* kDefaultScenario = "servo-position";
constexpr std::size_t kProgressSteps = 1000;

struct Options {
  std::vector<std::string> scenarios;
  std::uint64_t seed = 1;
  int seeds = 1;
  int threads = 0;
  std::string out;
  bool list = false;
  bool json = false;
  bool all = false;
  bool wall_clock = false;
  std::string page;
};

void list(bool json) {
  if (json) {
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    for (const Scenario& scenario : demo::scenarios()) names.push_back(scenario.name);
    std::printf("%s\n", names.dump().c_str());
    return;
  }
  for (const Scenario& scenario : demo::scenarios()) std::printf("%-18s %s\n", scenario.name, scenario.title);
}

Summary run_one(const Scenario& scenario, const Options& wanted, const std::filesystem::path& out) {
  Progress bar(scenario.name, kProgressSteps);
  std::size_t shown = 0;
  demo::RunOptions options;
  options.seed = wanted.seed;
  options.wall_clock = wanted.wall_clock;
  options.out = out;
  options.progress = [&](double share) {
    const auto steps = static_cast<std::size_t>(share * kProgressSteps);
    for (; shown < steps; ++shown) bar.step();
  };
  return demo::run_with_report(scenario, options);
}

// The same with other seeds, each in a folder of its own: how often is each number reached?
void run_seeds(const Scenario& scenario, const Options& options, const std::filesystem::path& out) {
  std::vector<Summary> summaries(static_cast<std::size_t>(options.seeds));
  {
    Progress bar(scenario.name, summaries.size());
    std::mutex mutex;
    in_parallel(summaries.size(), options.threads, [&](std::size_t i) {
      demo::RunOptions run;
      run.seed = options.seed + i;
      run.out = out / ("seed-" + std::to_string(run.seed));
      summaries[i] = demo::run_with_report(scenario, run);
      const std::scoped_lock lock(mutex);
      bar.step();
    });
  }
  std::printf("%s, seeds %llu to %llu\n", scenario.name, static_cast<unsigned long long>(options.seed),
              static_cast<unsigned long long>(options.seed + summaries.size() - 1));
  std::printf("  %-24s %12s %12s %12s  %-10s %s\n", "metric", "least", "median", "most", "target", "met");
  for (std::size_t m = 0; m < summaries.front().metrics.size(); ++m) {
    const Metric& first = summaries.front().metrics[m];
    std::vector<double> values;
    std::size_t met = 0;
    for (const Summary& summary : summaries) {
      values.push_back(summary.metrics[m].value);
      met += summary.metrics[m].met() ? 1 : 0;
    }
    // What was not reached at all is worse than any number.
    const double worst = first.bound == Bound::kAtMost ? std::numeric_limits<double>::infinity()
                                                       : -std::numeric_limits<double>::infinity();
    for (double& value : values) value = std::isnan(value) ? worst : value;
    std::sort(values.begin(), values.end());
    std::printf("  %-24s %12.4g %12.4g %12.4g  %-10s", first.name.c_str(), values.front(),
                values[values.size() / 2], values.back(), target_text(first).c_str());
    if (first.target) std::printf(" %zu of %zu", met, summaries.size());
    std::printf("\n");
  }
  std::printf("reports   %s\n", (out / "seed-*").c_str());
}

void print(const Summary& summary, const std::filesystem::path& out, bool json) {
  if (json) {
    std::printf("%s\n", summary_json(summary).c_str());
    return;
  }
  std::printf("%s\nsignature %s\nreport    %s\n", summary_text(summary).c_str(), summary.signature.c_str(),
              (out / "report.html").c_str());
}

// What all of them gave, for the documentation.
void write_page(const std::filesystem::path& file, const std::vector<Summary>& summaries) {
  std::ofstream out(file);
  out << "# Experiments on the simulated robot\n\n"
         "Written by `tools/experiments.sh`; each row is from a run with seed "
      << summaries.front().seed
      << ". What each scenario is and how it is judged: [demo.md](demo.md).\n"
         "Targets that were not reached stand as measured. Scenarios that are missing here were not run with "
         "this version yet.\n";
  std::size_t targets = 0;
  std::size_t met = 0;
  for (const Summary& summary : summaries) {
    for (const Metric& metric : summary.metrics) {
      if (!metric.target) continue;
      ++targets;
      met += metric.met() ? 1 : 0;
    }
  }
  out << "\n" << met << " of " << targets << " targets are reached.\n";
  for (const Summary& summary : summaries) {
    out << "\n## " << summary.scenario << "\n\n"
        << demo::find_scenario(summary.scenario)->description << "\n\n"
        << "| metric | value | unit | target | thesis | | what it is |\n|---|---|---|---|---|---|---|\n";
    for (const Metric& metric : summary.metrics) {
      out << "| `" << metric.name << "` | " << value_text(metric.value) << " | " << metric.unit << " | "
          << target_text(metric) << " | " << metric.thesis.value_or("-") << " | "
          << (!metric.target ? ""
              : metric.met() ? "met"
                             : "**not reached**")
          << " | " << metric.explanation << " |\n";
    }
    out << "\n`vergence demo " << summary.scenario << " --seed " << summary.seed << "`, signature `"
        << summary.signature << "`, " << value_text(summary.duration_s) << " s simulated.\n";
  }
  out.close();
  if (!out) throw InputError(file, "", "cannot be written");
}

std::vector<const Scenario*> chosen(const Options& options) {
  std::vector<const Scenario*> result;
  if (options.all) {
    for (const Scenario& scenario : demo::scenarios()) result.push_back(&scenario);
    // A span owns nothing.
    // cppcheck-suppress returnDanglingLifetime
    return result;
  }
  std::vector<std::string> names = options.scenarios;
  if (names.empty()) names.emplace_back(kDefaultScenario);
  for (const std::string& name : names) {
    result.push_back(demo::find_scenario(name));
    if (result.back() == nullptr) {
      throw CLI::ValidationError("SCENARIO", "there is no '" + name + "'; `vergence demo --list` names them");
    }
  }
  return result;
}

void run(const Options& options) {
  if (options.list) {
    list(options.json);
    return;
  }
  const std::vector<const Scenario*> wanted = chosen(options);
  if (!options.page.empty()) require_writable(options.page);
  const std::filesystem::path top = options.out.empty() ? "out" : options.out;
  std::vector<Summary> summaries;
  for (const Scenario* scenario : wanted) {
    // -o is the folder of a single run, and the folder of the folders of several.
    const bool is_alone = wanted.size() == 1 && !options.out.empty();
    const std::filesystem::path out = is_alone ? top : top / scenario->name;
    if (options.seeds > 1) {
      run_seeds(*scenario, options, out);
      continue;
    }
    summaries.push_back(run_one(*scenario, options, out));
    print(summaries.back(), out, options.json);
    std::fflush(stdout);
    if (!options.page.empty()) write_page(options.page, summaries);
  }
}

}  // namespace

void add_demo_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("demo", "The closed loop on the simulated robot, with a report");
  const auto options = std::make_shared<Options>();
  command->add_option("SCENARIO", options->scenarios, "Which; see --list; default: servo-position");
  command->add_option("--seed", options->seed, "Of noise and of all that is random")->capture_default_str();
  command
      ->add_option("--seeds", options->seeds,
                   "Run it so many times, from that seed on, and say how often it succeeds")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--threads", options->threads, "That share runs with several seeds; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command
      ->add_option("-o,--out", options->out,
                   "Folder for report.html, log.csv, summary.json; default: out/SCENARIO")
      ->type_name("DIR");
  command->add_flag("--list", options->list, "Name the scenarios");
  command->add_flag("--all", options->all, "Run them all, each into a folder of its own");
  command->add_flag("--wall-clock", options->wall_clock, "Simulate no faster than real time");
  command->add_option("--page", options->page, "All numbers as a page of Markdown")->type_name("FILE");
  command->add_flag("--json", options->json, "For machines: names or summaries as JSON");
  command->footer(
      "Time is virtual: a run gives the same log and signature on every machine, however fast.\n"
      "\nExamples:\n"
      "  vergence demo\n"
      "  vergence demo lateral-6dof --seed 3 --out out/lateral");
  command->callback([options] { run(*options); });
}

}  // namespace vergence::tools
