// An experiment on the simulated robot: what it is, and what came out of a run of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/report/html_report.hpp"
#include "tools/report/log_table.hpp"
#include "tools/report/metric.hpp"

namespace vergence::demo {

struct RunOptions {
  std::uint64_t seed = 1;
  std::filesystem::path out;  // exists; figures and the target's model go there
  // Simulated time goes no faster than the clock on the wall: to watch, or to run beside something real.
  // Where the machine is slower, it lags. The outcome is the same to the bit.
  bool wall_clock = false;
  // How far the run is, in [0, 1]; from one thread at a time.
  std::function<void(double)> progress;
};

struct Outcome {
  tools::LogTable log;
  double duration_s = 0;  // simulated
  std::vector<tools::Metric> metrics;
  std::vector<tools::Picture> pictures;
  std::vector<std::string> notes;
};

struct Scenario {
  const char* name;
  const char* title;
  const char* description;
  Outcome (*run)(const RunOptions& options);
};

// All there are, in the order of the thesis.
[[nodiscard]] std::span<const Scenario> scenarios();

// Null where there is none of that name.
[[nodiscard]] const Scenario* find_scenario(const std::string& name);

// Runs it and leaves report.html, log.csv, summary.json and the figures in options.out. Throws InputError
// where files cannot be written.
tools::Summary run_with_report(const Scenario& scenario, const RunOptions& options);

}  // namespace vergence::demo
