// `vergence bringup`: walks through the devices of a new robot, one by one, and says what works, how well,
// and what to do about the rest. Without --move nothing is moved, switched on or changed.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/bringup/look_at_files.hpp"
#include "tools/bringup/real_devices.hpp"
#include "tools/bringup/table.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/options.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"

namespace vergence::tools {
namespace {

const std::vector<std::string> kGroups = {"files", "rt", "cameras", "can", "gpio"};

struct BringupOptions {
  std::filesystem::path config;
  std::vector<std::string> only = kGroups;
  bool moves = false;
  bool is_confirmed = false;
  double seconds = 5;
  std::filesystem::path json;
  std::filesystem::path out;
  std::string loopback;

  [[nodiscard]] bool has(const char* group) const {
    return std::find(only.begin(), only.end(), group) != only.end();
  }
};

// Prints a group as soon as it is there: some take long.
class Report {
 public:
  void begin(const char* what) const {
    if (::isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "%s ...\n", what);
  }
  void add(const std::vector<Finding>& findings) {
    std::fputs(table_of(findings).c_str(), stdout);
    (void)std::fflush(stdout);
    all_.insert(all_.end(), findings.begin(), findings.end());
  }
  void finish(const std::filesystem::path& json) const {
    std::printf("\n%s\n", summary_of(all_).c_str());
    (void)std::fflush(stdout);
    if (json.empty()) return;
    std::ofstream file(json);
    file << json_of(all_).dump(2) << '\n';
    if (!file) throw std::runtime_error(json.string() + ": cannot be written");
  }
  [[nodiscard]] std::size_t failures() const { return count(all_).failed; }

 private:
  std::vector<Finding> all_;
};

// What is about to happen, and a word that nobody types by accident.
bool is_allowed(const ControllerConfig& config, const PulsePlan& plan) {
  std::fprintf(
      stderr,
      "\n--move switches the drives of the EYES on and turns tilt, pan_right and pan_left, one after the "
      "other,\n%lld steps there and back at %.0f steps/s or less:",
      static_cast<long long>(plan.steps), plan.steps_per_s);
  for (const double steps_per_rad : config.robot.eye_control.steps_per_rad) {
    std::fprintf(stderr, " %.1f deg",
                 static_cast<double>(plan.steps) / std::abs(steps_per_rad) * 180 / std::numbers::pi);
  }
  std::fprintf(stderr,
               ".\nNothing may be in their way, and the emergency stop in reach. Type \"move\" to go on: ");
  std::string typed;
  std::getline(std::cin, typed);
  return typed == "move";
}

std::vector<Finding> try_to_move(const BringupOptions& options, const ConfigLook& look,
                                 bool lines_are_sound) {
  const PulsePlan plan;
  if (look.seen.controller != FileObservation::Controller::kStopped) {
    return not_moved("vergenced runs, or may run");
  }
  if (!lines_are_sound) return not_moved("a line failed");
  if (!options.is_confirmed && !is_allowed(*look.config, plan)) return not_moved("it was not confirmed");
  return move_eyes(*look.config, plan, options.loopback);
}

void check_devices(const BringupOptions& options, const ConfigLook& look, Report& report) {
  const ControllerConfig& config = *look.config;
  if (options.has("rt")) {
    report.begin("measuring wake-ups");
    report.add(check_rt(config, options.seconds));
  }
  if (options.has("cameras")) {
    report.begin("watching the cameras");
    report.add(check_cameras(config, options.seconds, options.out));
  }
  if (options.has("can")) {
    report.begin("listening to the CAN bus");
    report.add(check_can(config, options.seconds));
  }
  if (options.has("gpio")) {
    const std::vector<Finding> lines = check_gpio(config);
    report.add(lines);
    if (options.moves) report.add(try_to_move(options, look, count(lines).failed == 0));
  }
}

void bringup(const BringupOptions& options) {
  if (options.moves && !options.is_confirmed && ::isatty(STDIN_FILENO) == 0) {
    throw InputError("--move", "", "asks for a confirmation, and there is no terminal", "--yes confirms it");
  }
  if (!options.json.empty()) require_writable(options.json);
  const ConfigLook look = look_at_files(options.config);
  Report report;
  if (options.has("files") || look.config == nullptr) report.add(judge(look.seen));
  if (look.config == nullptr) {
    for (const std::string& group : options.only) {
      if (group == "files") continue;
      Findings skipped(group);
      skipped.skip("everything", "the configuration cannot be read");
      report.add(skipped.take());
    }
  } else {
    check_devices(options, look, report);
  }
  report.finish(options.json);
  if (look.config == nullptr) throw InputError(options.config, "", "cannot be used", "the table says why");
  if (report.failures() > 0)
    throw std::runtime_error("not everything works: what to do stands behind each ->");
}

}  // namespace

void add_bringup_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("bringup", "Check the devices of a real robot, one by one");
  const auto options = std::make_shared<BringupOptions>();
  command->add_option("--config", options->config, "Of the controller: TOML, or an image")
      ->required()
      ->type_name("FILE");
  command->add_option("--only", options->only, "Some of files, rt, cameras, can, gpio, with commas")
      ->delimiter(',')
      ->check(CLI::IsMember(kGroups));
  command
      ->add_option("--seconds", options->seconds,
                   "Cameras are watched, the bus listened to, wake-ups measured")
      ->check(within(0.1, 86'400))
      ->capture_default_str();
  command->add_option("--out", options->out, "A picture of each camera, left.png and right.png")
      ->type_name("DIR");
  command->add_option("--json", options->json, "The findings, for programs")->type_name("FILE");
  CLI::Option* move =
      command->add_flag("--move", options->moves, "Also turn the motors of the eyes a little; asks first");
  command->add_flag("--yes", options->is_confirmed, "Do not ask")->needs(move);
  command
      ->add_option("--loopback", options->loopback,
                   "With --move: name of a GPIO input that a motor's step line is wired to")
      ->type_name("LINE")
      ->needs(move);
  command->callback([options] { bringup(*options); });
  command->footer(
      "\nExit status: 0 nothing failed, 1 something did, 2 bad input.\n"
      "docs/bringup.md leads from unpacked hardware to the first servo.\n"
      "\nExample:\n"
      "  vergence bringup --config robot.toml --only cameras --out pictures");
}

}  // namespace vergence::tools
