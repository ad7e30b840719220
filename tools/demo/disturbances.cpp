// What a robot meets beyond the thesis: a target that jumps, a hand that is pushed, cameras that drop out.
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"

namespace vergence::demo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kNear_mm = 5;

LoopSetup crab_before_the_hand(const std::string& motion, double duration_s) {
  LoopSetup setup;
  setup.name = "disturbed";
  setup.scene = "[target]\nkind = \"creature\"\ncreature = \"C12\"\n[motion]\n" + motion;
  setup.duration_s = duration_s;
  setup.T_W_S = lateral_start();
  setup.adjust_robot = [](RobotConfig& robot) { robot.relation.T_Ed_M.t_mm = {0, 0, 500}; };
  return setup;
}

// From an instant until the hand is within 5 mm of where it is wanted, for good before `to_s`.
double recovery_s(const tools::LogTable& log, double from_s, double to_s) {
  const auto& t_s = log.column("t_s");
  double last_far_s = kNaN;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (t_s[row] < from_s || t_s[row] >= to_s) continue;
    const auto far = distances_mm(log, "wanted", "hand", {t_s[row], t_s[row]});
    if (far.empty() || far.front() > kNear_mm) last_far_s = t_s[row];
  }
  if (std::isnan(last_far_s)) return 0;
  return last_far_s > to_s - 0.02 ? kNaN : last_far_s - from_s;
}

// Frames looked at from an instant on, until one is tracked and right to 10 mm.
int frames_until_found(const tools::LogTable& log, double from_s) {
  const auto& stamp_s = log.column("frame_stamp_s");
  const auto& state = log.column("state");
  int frames = 0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (std::isnan(stamp_s[row]) || stamp_s[row] < from_s - 1e-9) continue;
    ++frames;
    double squared = 0;
    for (const char* part : {"_x_mm", "_y_mm", "_z_mm"}) {
      const double d =
          log.column(std::string("seen") + part)[row] - log.column(std::string("true") + part)[row];
      squared += d * d;
    }
    if (state[row] == 1 && squared < 100) return frames;
  }
  return frames + 1;
}

tools::Figure hand_figure(const tools::LogTable& log, const std::string& title,
                          const std::vector<tools::Span>& spans) {
  tools::Figure figure;
  figure.title = title;
  tools::Panel distance{.title = "",
                        .x_label = "t [s]",
                        .y_label = "mm",
                        .right_label = "",
                        .curves = {},
                        .log_x = false,
                        .y_range = std::nullopt,
                        .spans = spans};
  tools::Curve off = curve(log, "t_s", "distance of the hand from where it is wanted");
  off.y = {};
  for (std::size_t row = 0; row < log.rows(); ++row) {
    double squared = 0;
    for (const char* part : {"_x_mm", "_y_mm", "_z_mm"}) {
      const double d =
          log.column(std::string("wanted") + part)[row] - log.column(std::string("hand") + part)[row];
      squared += d * d;
    }
    off.y.push_back(std::sqrt(squared));
  }
  distance.curves = {off};
  tools::Panel mode = distance;
  mode.spans.clear();
  mode.y_label = "mode";
  mode.y_range = tools::Range{-0.5, 8.5};
  mode.curves = {curve(
      log, "mode", "0 init, 1 self-test, 2 idle, 3 search, 4 track, 5 servo, 6 hold, 7 safe stop, 8 fault")};
  figure.panels = {distance, mode};
  return figure;
}

void add_pictures(Outcome& outcome, const RunOptions& options, const std::string& title,
                  const std::vector<tools::Span>& spans) {
  outcome.pictures.push_back(drawn(options.out / "hand.png", hand_figure(outcome.log, title, spans),
                                   "How far the hand was off, and what the controller was doing."));
  outcome.pictures.push_back(
      drawn(options.out / "pose.png", pose_figure(outcome.log, title), "Relative to the hand at the start."));
}

bool ever_stopped(const tools::LogTable& log) {
  for (const double mode : log.column("mode")) {
    if (mode >= static_cast<double>(Mode::kSafeStop)) return true;
  }
  return false;
}

}  // namespace

Outcome teleport(const RunOptions& options) {
  constexpr double kJumps_s[] = {4, 8, 12, 16};
  LoopSetup setup = crab_before_the_hand(
      "kind = \"keys\"\nkey = [\n"
      "{ t_s = 0, pose = [0, 0, 500, 0, 0, 0] },\n"
      "{ t_s = 4, pose = [90, -40, 520, 0, 0.1, 0], teleport = true },\n"
      "{ t_s = 8, pose = [-80, 50, 480, 0.1, 0, -0.15], teleport = true },\n"
      "{ t_s = 12, pose = [40, 60, 540, -0.1, -0.1, 0.1], teleport = true },\n"
      "{ t_s = 16, pose = [0, -20, 500, 0, 0, 0], teleport = true },\n]\n",
      20);
  ClosedLoop loop(setup, options);
  loop.run(options.progress);
  Outcome outcome{loop.take_log(), setup.duration_s, {}, {}, {}};
  int frames = 0;
  double recovery = 0;
  std::vector<tools::Span> spans;
  for (const double jump_s : kJumps_s) {
    frames = std::max(frames, frames_until_found(outcome.log, jump_s));
    const double took_s = recovery_s(outcome.log, jump_s, jump_s + 4);
    recovery = std::isnan(took_s) ? kNaN : std::max(recovery, took_s);
    spans.push_back({jump_s, jump_s + 0.1, "jump"});
  }
  outcome.metrics = {at_most("frames_until_found", frames, "", 3, std::nullopt,
                             "after the worst of four jumps, that frame included"),
                     at_most("recovery_s", recovery, "s", 3, std::nullopt,
                             "until the hand is within 5 mm again, the slowest"),
                     at_most("stops", ever_stopped(outcome.log) ? 1 : 0, "", 0, std::nullopt,
                             "safe stops, which a jump is no reason for")};
  add_pictures(outcome, options, "The crab jumps", spans);
  return outcome;
}

Outcome shove(const RunOptions& options) {
  constexpr double kShoves_s[] = {4, 7, 10};
  // In rad/s, at once: some 20 mm at the hand before the drives have braked it.
  constexpr plant::JointArray kJumps[] = {
      {0, 0.5, 0, 0, 0, 0, 0}, {0, 0, 1.0, -1.0, 0, 0, 0}, {0, -0.3, 0, 0.6, 1, 1, -1}};
  LoopSetup setup = crab_before_the_hand(
      "kind = \"sine\"\npose = [0, 0, 500, 0, 0, 0]\namplitude = [40, 20, 0, 0, 0, 0.05]\nomega_rad_s = "
      "0.8\n",
      14);
  ClosedLoop loop(setup, options);
  std::size_t next = 0;
  loop.on_tick = [&](double t_s) {
    if (next < std::size(kShoves_s) && t_s >= kShoves_s[next]) loop.world().arm().shove(kJumps[next++]);
  };
  loop.run(options.progress);
  Outcome outcome{loop.take_log(), setup.duration_s, {}, {}, {}};
  double displaced = 0;
  double recovery = 0;
  std::vector<tools::Span> spans;
  for (const double t_s : kShoves_s) {
    displaced = std::max(displaced, largest(distances_mm(outcome.log, "wanted", "hand", {t_s, t_s + 3})));
    const double took_s = recovery_s(outcome.log, t_s, t_s + 3);
    recovery = std::isnan(took_s) ? kNaN : std::max(recovery, took_s);
    spans.push_back({t_s, t_s + 0.05, "shove"});
  }
  outcome.metrics = {
      at_most("recovery_s", recovery, "s", 1.5, std::nullopt,
              "until the hand is within 5 mm again, the slowest of three"),
      at_most("displaced_mm", displaced, "mm", std::nullopt, std::nullopt,
              "how far a shove moved the hand off, at most"),
      at_most("stops", ever_stopped(outcome.log) ? 1 : 0, "", 0, std::nullopt,
              "safe stops: a shove is taken, not answered by one"),
      at_least("tracked_percent",
               100.0 * seen_errors(outcome.log, {}).tracked / seen_errors(outcome.log, {}).frames, "%", 100,
               std::nullopt, "of the frames")};
  add_pictures(outcome, options, "The hand is pushed", spans);
  return outcome;
}

Outcome drop_outs(const RunOptions& options) {
  constexpr double kGaps_s[][2] = {{4, 4.1}, {7, 7.5}, {11, 13}};
  LoopSetup setup = crab_before_the_hand(
      "kind = \"sine\"\npose = [0, 0, 500, 0, 0, 0]\namplitude = [60, 20, 10, 0, 0, 0.05]\nomega_rad_s = "
      "1.0\n",
      18);
  setup.adjust_robot = [](RobotConfig& robot) {
    robot.relation.T_Ed_M.t_mm = {0, 0, 500};
    robot.camera_timeout_ns = 5'000'000'000;  // longer than the longest gap here
  };
  setup.adjust_world = [&](plant::WorldOptions& world) {
    world.camera.lost_share = 0.1;
    for (const auto& [from_s, to_s] : kGaps_s) {
      world.camera.lost_spans_ns.push_back({std::llround(from_s * 1e9), std::llround(to_s * 1e9)});
    }
  };
  ClosedLoop loop(setup, options);
  loop.run(options.progress);
  Outcome outcome{loop.take_log(), setup.duration_s, {}, {}, {}};
  const tools::LogTable& log = outcome.log;
  std::vector<tools::Span> spans;
  for (const auto& [from_s, to_s] : kGaps_s) spans.push_back({from_s, to_s, "no pictures"});
  const int found = frames_until_found(log, kGaps_s[2][1]);
  outcome.metrics = {
      at_most("random_losses_rms_mm", rms(distances_mm(log, "wanted", "hand", {2, 7})), "mm", 5, std::nullopt,
              "distance of the hand from where it is wanted while a tenth of the pairs is lost, and 0.1 s of "
              "them"),
      at_most("frames_until_found", found, "", 3, std::nullopt,
              "after 2 s without pictures, that frame included"),
      at_most("recovery_s", recovery_s(log, kGaps_s[2][1], 18), "s", 2, std::nullopt,
              "after 2 s without pictures, until the hand is within 5 mm again"),
      at_most("stops", ever_stopped(log) ? 1 : 0, "", 0, std::nullopt,
              "safe stops: gaps shorter than the camera's time-out")};
  outcome.notes.emplace_back(
      "Of the pairs outside the gaps, one in ten is lost at random. After 0.15 s without a pair the "
      "target is not believed any more: the hand comes to rest until it is seen again.");
  add_pictures(outcome, options, "Pictures are lost", spans);
  return outcome;
}

}  // namespace vergence::demo
