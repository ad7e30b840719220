// vergence_rig_plant: the simulated robot behind the kernel's cameras, CAN interface and GPIO lines; runs a
// scenario against a controller, and judges by what the motors did.
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "firmware_like/config/config_image.hpp"
#include "tools/demo/measures.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/report/html_report.hpp"
#include "tools/rig/plant_loop.hpp"
#include "tools/rig/rig_error.hpp"
#include "tools/rig/rig_operator.hpp"

namespace vergence::rig {
namespace {

constexpr int kOk = 0;
constexpr int kMissed = 1;
constexpr int kBadInput = 2;

struct Options {
  std::filesystem::path scenario;
  std::filesystem::path config;
  std::filesystem::path out = ".";
  std::string command = "tools/rig/run";
  bool real_time = false;
  std::vector<std::string> controller;
};

std::unique_ptr<ControllerConfig> read_image_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  auto config = std::make_unique<ControllerConfig>();
  const ImageResult result = read_image(std::as_bytes(std::span(bytes)), *config);
  if (result.status != ImageStatus::kOk) throw tools::InputError(file, "", describe(result.status));
  return config;
}

tools::Figure arm_figure(const tools::LogTable& log, const RigScenario& scenario) {
  tools::Panel speed;
  speed.title = "Speed of the tool";
  speed.x_label = "time (s)";
  speed.y_label = "mm/s";
  speed.curves = {demo::curve(log, "tool_mm_per_s", "")};
  tools::Panel joints;
  joints.title = "Velocities the drives were sent";
  joints.x_label = "time (s)";
  joints.y_label = "rad/s";
  for (int i = 1; i <= kMaxJoints; ++i) {
    const std::string number = std::to_string(i);
    joints.curves.push_back(demo::curve(log, "sent" + number + "_rad_per_s", "joint " + number));
  }
  for (const FaultEvent& fault : scenario.faults) {
    const double end_s = fault.for_s > 0 ? fault.at_s + fault.for_s : scenario.duration_s;
    for (tools::Panel* panel : {&speed, &joints}) panel->spans.push_back({fault.at_s, end_s, fault.name});
  }
  tools::Figure figure;
  figure.title = scenario.title;
  figure.panels = {speed, joints};
  return figure;
}

void write_lines(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  std::ofstream out(file);
  for (const std::string& line : lines) out << line << '\n';
}

std::vector<std::string> notes_of(PlantLoop& plant, int controller_status) {
  const auto wide = [](auto number) { return static_cast<long long>(number); };
  const BusCounts& bus = plant.drives().counts();
  const PulseTimes& pulses = plant.eyes().times();
  std::vector<std::string> notes;
  std::array<char, 300> text{};
  for (int side = 0; side < 2; ++side) {
    const PictureCounts pictures = plant.pictures(side);
    std::snprintf(text.data(), text.size(), "%s camera: %lld pictures, %lld of them skipped, %lld refused",
                  side == 0 ? "left" : "right", wide(pictures.asked), wide(pictures.skipped),
                  wide(pictures.refused));
    notes.emplace_back(text.data());
  }
  std::snprintf(text.data(), text.size(),
                "CAN: %lld frames received (%lld SYNC), hash of what came and when %016llx, %lld sent",
                wide(bus.received), wide(bus.syncs), static_cast<unsigned long long>(bus.hash),
                wide(bus.sent));
  notes.emplace_back(text.data());
  if (plant.eyes().edges() > 0) {
    std::snprintf(text.data(), text.size(),
                  "GPIO: %lld edges, shortest high %lld us, low %lld us, direction before a step %lld us",
                  wide(plant.eyes().edges()), wide(pulses.high_ns / 1000), wide(pulses.low_ns / 1000),
                  wide(pulses.setup_ns / 1000));
    notes.emplace_back(text.data());
  }
  if (const auto ages = plant.ages().spread()) {
    std::snprintf(text.data(), text.size(),
                  "pictures at their stamps: %.3f ms old in the middle, %.3f to %.3f",
                  static_cast<double>(ages->median_ns) * 1e-6, static_cast<double>(ages->least_ns) * 1e-6,
                  static_cast<double>(ages->most_ns) * 1e-6);
    notes.emplace_back(text.data());
  }
  std::snprintf(text.data(), text.size(), "the plant was %lld ms late at worst; the controller ended with %d",
                wide(plant.most_ticks_late()), controller_status);
  notes.emplace_back(text.data());
  return notes;
}

void add_pen(const demo::Pen& pen, const RigScenario& scenario, std::vector<tools::Metric>& metrics) {
  metrics.push_back(
      demo::at_least("hit", pen.hit ? 1 : 0, "", 1, std::nullopt, "whether the pen meets the target's body"));
  metrics.push_back(demo::at_most("miss_mm", pen.miss_mm, "mm", std::nullopt, std::nullopt,
                                  "from the target's middle, where the pen came down"));
  metrics.push_back(demo::at_most("dropped_at_s",
                                  pen.dropped_s.value_or(std::numeric_limits<double>::quiet_NaN()), "s",
                                  scenario.duration_s, std::nullopt, "when the pen was let go"));
}

bool is_left_dead(const RigScenario& scenario) {
  return std::any_of(scenario.faults.begin(), scenario.faults.end(), [](const FaultEvent& fault) {
    return fault.kind == FaultKind::kControllerKilled && fault.for_s == 0;
  });
}

// Memory is taken at once, and kept: in User Mode Linux each page that is touched first costs up to a
// millisecond, and every picture would take a thousand of them anew.
void keep_memory() {
  constexpr std::size_t kHeap = std::size_t{192} << 20;
  (void)mallopt(M_MMAP_MAX, 0);
  (void)mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  (void)mallopt(M_ARENA_MAX, 1);
  (void)mallopt(M_TOP_PAD, kHeap);
  void* volatile block = std::malloc(1 << 20);  // which the compiler must not leave out
  std::free(block);
  char* const begin = static_cast<char*>(sbrk(0)) - kHeap;  // on a page: malloc() ends its heap on one
  // A change of what is allowed maps all pages that are there on the host, many in a call.
  if (madvise(begin, kHeap, MADV_POPULATE_WRITE) == 0 && mprotect(begin, kHeap, PROT_READ) == 0) {
    (void)mprotect(begin, kHeap, PROT_READ | PROT_WRITE);
  }
}

int run(const Options& options) {
  const RigScenario scenario = read_scenario(options.scenario);
  const std::unique_ptr<ControllerConfig> config = read_image_file(options.config);
  tools::make_directory(options.out);
  for (const char* file : {"report.html", "log.csv", "summary.json"})
    tools::require_writable(options.out / file);
  std::filesystem::remove(options.out / "controller.log");
  ControllerProcess controller(options.controller, options.out / "controller.log");
  PlantLoop plant(scenario, *config, controller);
  RigOperator person(config->runtime.command_socket.data(), scenario, plant.start_ns());
  plant.run(options.real_time ? Pace::kReal : Pace::kVirtual);
  write_lines(options.out / "operator.log", person.finish());
  const int controller_status = controller.finish();

  tools::Summary summary;
  summary.scenario = scenario.name;
  summary.seed = 1;
  summary.signature = plant.log().signature();
  summary.duration_s = scenario.duration_s;
  summary.metrics = plant.judge().metrics(plant.log());
  if (scenario.pen_from_s > 0) add_pen(plant.pen(), scenario, summary.metrics);
  if (!is_left_dead(scenario)) {
    summary.metrics.push_back(demo::at_most("controller_status", std::abs(controller_status), "", 0,
                                            std::nullopt,
                                            "how the controller ended: its exit status, or the signal"));
  }
  plant.log().write_csv(options.out / "log.csv");
  tools::write_summary(options.out / "summary.json", summary);
  tools::ReportPage page;
  page.title = scenario.title;
  page.description = scenario.description;
  page.command = options.command;
  page.summary = summary;
  page.pictures = {
      demo::drawn(options.out / "pose.png", demo::pose_figure(plant.log(), scenario.title),
                  "Where the hand was wanted, where it was, and the target; relative to the hand at the "
                  "start."),
      demo::drawn(options.out / "arm.png", arm_figure(plant.log(), scenario),
                  "What the arm did, and what it was sent; faults are shaded.")};
  page.notes = notes_of(plant, controller_status);
  tools::write_html_report(options.out / "report.html", page);
  write_lines(options.out / "notes.txt", page.notes);
  std::fputs(tools::summary_text(summary).c_str(), stdout);
  for (const std::string& note : page.notes) std::printf("%s\n", note.c_str());
  return summary.all_met() ? kOk : kMissed;
}

}  // namespace
}  // namespace vergence::rig

int main(int argc, char** argv) {
  using namespace vergence;
  rig::Options options;
  CLI::App app{"The simulated robot behind the kernel's cameras, CAN interface and GPIO lines"};
  app.add_option("--scenario", options.scenario, "TOML; docs/rig.md has the keys")->required();
  app.add_option("--config", options.config, "the controller's configuration image")->required();
  app.add_option("--out", options.out, "where log.csv, summary.json and report.html go");
  app.add_option("--command", options.command, "what the report says the run is started with");
  app.add_flag("--real-time", options.real_time, "the clock does not wait: drives come before all else");
  app.add_option("controller", options.controller, "the controller and its arguments, after --");
  CLI11_PARSE(app, argc, argv);
  try {
    rig::keep_memory();
    return rig::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vergence_rig_plant: %s\n", error.what());
    return rig::kBadInput;
  }
}
