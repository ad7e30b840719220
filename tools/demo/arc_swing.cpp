// Section 4.2.2: the marker swings on a turntable while the light changes; is its turn tracked through it?
#include <cmath>

#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"

namespace vergence::demo {
namespace {

constexpr double kPeriod_s = 17.76;
constexpr const char* kLights[] = {"80lx", "500lx", "900lx", "2200lx"};
constexpr int kChanges = 8;  // every quarter of a swing there and back

std::string scene() {
  std::string text =
      "[rig]\nkind = \"eyes\"\n[target]\nkind = \"marker\"\n"
      "[motion]\nkind = \"swing\"\npose = [0, -100, 545, 0, 0, 0]\nswing_deg = 20\nswing_deg_s = 4.5\n"
      "[background]\nhue_deg = 45\nsaturation = 0.12\nvalue = 0.60\n[light]\npreset = \"80lx\"\n";
  for (int i = 1; i < kChanges; ++i) {
    text += "[[light.step]]\nt_s = " + std::to_string(i * kPeriod_s / 4) + "\npreset = \"" + kLights[i % 4] +
            "\"\n";
  }
  return text;
}

std::vector<tools::Span> lights() {
  std::vector<tools::Span> spans;
  for (int i = 0; i < kChanges; ++i)
    spans.push_back({i * kPeriod_s / 4, (i + 1) * kPeriod_s / 4, kLights[i % 4]});
  return spans;
}

}  // namespace

Outcome arc_swing(const RunOptions& options) {
  LoopSetup setup;
  setup.name = "arc-swing";
  setup.scene = scene();
  setup.duration_s = 2 * kPeriod_s;
  setup.T_W_S = lateral_start();
  setup.adjust_robot = [](RobotConfig& robot) { robot.relation.T_Ed_M.t_mm = {0, -100, 545}; };
  ClosedLoop loop(setup, options);
  loop.run(options.progress);
  const tools::Picture last =
      loop.draw_last_frame(options.out / "last_frame.png",
                           "The last frame, with the marker as it was seen (magenta) and as it is (white).");

  Outcome outcome{loop.take_log(), setup.duration_s, {}, {}, {}};
  const tools::LogTable& log = outcome.log;
  tools::Curve error = points(log, "seen_e2", "seen - truth");
  const tools::Curve truth = points(log, "true_e2", "");
  for (std::size_t i = 0; i < error.y.size(); ++i) error.y[i] -= truth.y[i];
  const SeenErrors seen = seen_errors(log, {});
  const Window settled{3, 1e9};
  outcome.metrics = {
      at_most("e2_largest", largest(error.y), "", 0.02, "a transient at 32 s",
              "largest error of e2 seen, over all frames and changes of light"),
      at_most("e2_rms", rms(error.y), "", std::nullopt, std::nullopt, "the same, RMS"),
      at_least("tracked_percent", 100.0 * seen.tracked / seen.frames, "%", 100, std::nullopt,
               "of the frames"),
      at_most("hand_rms_mm", rms(distances_mm(log, "wanted", "hand", settled)), "mm", std::nullopt,
              std::nullopt, "distance of the hand from where it is wanted, after 3 s"),
      at_most("hand_rms_e", rms(turns_e(log, "wanted", "hand", settled)), "", std::nullopt,
              "e1 about 0.05 off", "the same of its orientation")};

  tools::Figure figure;
  figure.title = "The marker swings, the light changes";
  tools::Panel fitness{.title = "",
                       .x_label = "t [s]",
                       .y_label = "fitness",
                       .right_label = "",
                       .curves = {points(log, "fitness", "of the pose seen [Eq. 3.22]")},
                       .log_x = false,
                       .y_range = std::nullopt,
                       .spans = lights()};
  figure.panels.push_back(fitness);
  const char* const names[] = {"e1", "e2", "e3"};
  for (const char* name : names) {
    tools::Panel panel = fitness;
    panel.y_label = name;
    panel.spans.clear();
    const std::string part = std::string("_") + name;
    tools::Curve marker = curve(log, "target" + part, "marker");
    marker.style = tools::CurveStyle::kDashed;
    panel.curves = {marker, curve(log, "believed" + part, "marker, believed"),
                    curve(log, "hand" + part, "hand")};
    figure.panels.push_back(panel);
  }
  tools::Panel errors = fitness;
  errors.y_label = "e2";
  errors.spans.clear();
  errors.curves = {error, error_curve(log, "wanted_e2", "hand_e2", "hand: wanted - is")};
  figure.panels.push_back(errors);
  outcome.pictures = {
      drawn(options.out / "swing.png", figure, "As Fig. 4.14, relative to the hand at the start."), last};
  outcome.notes.emplace_back(
      "Lamps of so many lx are rendered as exposure, noise, saturation and a cast of colour.");
  return outcome;
}

}  // namespace vergence::demo
