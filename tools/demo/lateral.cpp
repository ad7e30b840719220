// Section 4.1: the marker sways before the hand, and eyes and hand follow it; at which frequencies, and how
// late? With its pose given, with its position seen, with all six seen.
#include <cmath>
#include <numbers>

#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"
#include "tools/report/frequency_response.hpp"

namespace vergence::demo {
namespace {

using tools::FrequencyResponse;

enum class Seen {
  kNothing,   // the pose is given
  kPosition,  // and the orientation given
  kPose,
};

constexpr double kPeriods_s[] = {30, 25, 20, 15, 10, 5};
constexpr double kRun_s = 60;
constexpr double kAmplitude_mm = 150;

// The printed z_MO(t) = 150 - 150 cos(wt) [4.3] is along the axis that the figures call x: lateral.
std::string scene(double omega_rad_s, double amplitude_mm) {
  return "[rig]\nkind = \"eyes\"\n"
         "[target]\nkind = \"marker\"\n"
         "[motion]\nkind = \"cosine\"\npose = [" +
         std::to_string(-amplitude_mm) +
         ", -100, 545, 0, 0, 0]\n"
         "amplitude = [" +
         std::to_string(amplitude_mm) +
         ", 0, 0, 0, 0, 0]\n"
         "omega_rad_s = " +
         std::to_string(omega_rad_s) +
         "\n"
         "[background]\nhue_deg = 45\nsaturation = 0.12\nvalue = 0.60\n";
}

struct Sway {
  double omega_rad_s = 0;
  double amplitude_mm = kAmplitude_mm;
  double duration_s = kRun_s;
};

// Where the arm's joints would be asked for more than they can, the sway is smaller: it is the controller's
// answer that is wanted, not the motors'.
Sway quick_sway(double omega_rad_s) {
  const double w = omega_rad_s;
  return {w, std::min({kAmplitude_mm, 2000 / (w * w), 18000 / (w * w * w)}), 20};
}

struct LateralRun {
  Sway sway;
  tools::LogTable log;
  FrequencyResponse hand;
  FrequencyResponse gaze;
  tools::Picture last;
};

LateralRun run_sway(const Sway& sway, Seen seen, const HandGains& gains, const RunOptions& options,
                    const std::function<void(double)>& progress) {
  LoopSetup setup;
  setup.name = "lateral";
  setup.scene = scene(sway.omega_rad_s, sway.amplitude_mm);
  setup.duration_s = sway.duration_s;
  setup.T_W_S = lateral_start();
  setup.pose_given = seen == Seen::kNothing;
  setup.adjust_robot = [&](RobotConfig& robot) {
    robot.gains = gains;
    robot.relation.T_Ed_M.t_mm = {0, -100, 545};
    robot.hand_limits.linear_acceleration_mm_per_s2 = 4000;  // it is the joints' limits that are to be met
    if (seen == Seen::kPosition) robot.R_W_M_given = lateral_start().R;
    if (seen == Seen::kNothing) {
      // What is given has no noise to be smoothed away.
      robot.target_motion.position_noise_mm = 0.01;
      robot.target_motion.rotation_noise_rad = 1e-4;
      robot.target_motion.jerk_mm_per_s3 = 1e5;
      robot.target_motion.acceleration_memory_s = 0.1;
      robot.target_motion.gate_sigma = 1e6;
    }
  };
  ClosedLoop loop(setup, options);
  loop.run(progress);
  LateralRun run{sway, loop.take_log(), {}, {}, {}};
  const tools::SineFitOptions fit{.settle_s = std::max(5.0, 0.2 * sway.duration_s), .drift = false};
  const auto response = [&](const char* column) {
    return tools::frequency_response(run.log.column("t_s"), run.log.column("target_x_mm"),
                                     run.log.column(column), sway.omega_rad_s, fit);
  };
  run.hand = response("hand_x_mm");
  run.gaze = response("gaze_x_mm");
  if (seen != Seen::kNothing) {
    run.last = loop.draw_last_frame(options.out / "last_frame.png",
                                    "The last frame, with the marker as it was seen "
                                    "(magenta) and as it is (white).");
  }
  return run;
}

tools::BodeCurve bode(const std::string& label, const std::vector<FrequencyResponse>& responses) {
  tools::BodeCurve curve;
  curve.label = label;
  for (const FrequencyResponse& r : responses) {
    curve.omega_rad_s.push_back(r.omega_rad_s);
    curve.gain_db.push_back(r.gain_db);
    curve.phase_deg.push_back(r.phase_deg);
  }
  return curve;
}

std::string period_text(const Sway& sway) {
  char text[64];
  std::snprintf(text, sizeof text, "w = %.3f rad/s (T = %.3g s)", sway.omega_rad_s,
                2 * std::numbers::pi / sway.omega_rad_s);
  return text;
}

tools::Panel sway_panel(const LateralRun& run) {
  tools::Panel panel;
  panel.title = period_text(run.sway);
  panel.x_label = "t [s]";
  panel.y_label = "x [mm]";
  tools::Curve target = curve(run.log, "target_x_mm", "marker");
  target.style = tools::CurveStyle::kDashed;
  panel.curves = {target, curve(run.log, "hand_x_mm", "hand"), curve(run.log, "gaze_x_mm", "gazing point")};
  return panel;
}

tools::Panel lateness_panel(const LateralRun& run) {
  tools::Panel panel;
  panel.title = "errors, " + period_text(run.sway);
  panel.x_label = "t [s]";
  panel.y_label = "x [mm]";
  panel.curves = {error_curve(run.log, "wanted_x_mm", "hand_x_mm", "hand: wanted - is"),
                  error_curve(run.log, "target_x_mm", "gaze_x_mm", "gaze: marker - gazing point")};
  return panel;
}

// The logs of all runs, one after the other, with the run's number as a column of its own.
tools::LogTable joined(const std::vector<LateralRun>& runs) {
  std::vector<std::string> names = {"run", "omega_rad_s"};
  for (const std::string& name : runs.front().log.columns()) names.push_back(name);
  tools::LogTable all(names);
  std::vector<double> row(names.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const tools::LogTable& log = runs[r].log;
    std::vector<const std::vector<double>*> columns;
    for (const std::string& name : log.columns()) columns.push_back(&log.column(name));
    for (std::size_t i = 0; i < log.rows(); ++i) {
      row[0] = static_cast<double>(r + 1);
      row[1] = runs[r].sway.omega_rad_s;
      for (std::size_t c = 0; c < columns.size(); ++c) row[c + 2] = (*columns[c])[i];
      all.append(row);
    }
  }
  return all;
}

const LateralRun& at(const std::vector<LateralRun>& runs, double period_s) {
  for (const LateralRun& run : runs) {
    if (std::abs(2 * std::numbers::pi / run.sway.omega_rad_s - period_s) < 0.01) return run;
  }
  return runs.back();
}

Outcome run_lateral(Seen seen, const RunOptions& options) {
  std::vector<Sway> sways;
  for (const double period_s : kPeriods_s) sways.push_back({2 * std::numbers::pi / period_s});
  if (seen == Seen::kNothing) {
    for (const double w : {2.5, 4.0, 6.0, 8.0, 12.0, 16.0}) sways.push_back(quick_sway(w));
  }
  // The law as printed, for comparison; with the pose given, it takes no time.
  const bool compare = seen == Seen::kNothing;
  double total_s = 0;
  for (const Sway& sway : sways) total_s += (compare ? 2 : 1) * sway.duration_s;

  double done_s = 0;
  std::vector<LateralRun> runs;
  std::vector<FrequencyResponse> hand;
  std::vector<FrequencyResponse> gaze;
  std::vector<FrequencyResponse> thesis;
  for (const Sway& sway : sways) {
    const auto progress = [&](double share) {
      if (options.progress) options.progress((done_s + share * sway.duration_s) / total_s);
    };
    runs.push_back(run_sway(sway, seen, vergence_gains(), options, progress));
    hand.push_back(runs.back().hand);
    gaze.push_back(runs.back().gaze);
    done_s += sway.duration_s;
    if (compare) {
      thesis.push_back(run_sway(sway, seen, thesis_gains(), options, progress).hand);
      done_s += sway.duration_s;
    }
  }
  tools::unwrap_phases(hand);
  tools::unwrap_phases(gaze);
  tools::unwrap_phases(thesis);

  Outcome outcome{joined(runs), done_s, {}, {}, {}};
  const LateralRun& fast = at(runs, 5);
  const double fast_w = fast.sway.omega_rad_s;
  const Window settled{15, 1e9};
  if (seen == Seen::kNothing) {
    const auto hand_break = tools::break_frequency(std::span<const FrequencyResponse>(hand));
    const auto gaze_break = tools::break_frequency(std::span<const FrequencyResponse>(gaze));
    const auto thesis_break = tools::break_frequency(std::span<const FrequencyResponse>(thesis));
    double gaze_gain = 0;
    double gaze_phase = 0;
    for (const FrequencyResponse& r : gaze) {
      if (r.omega_rad_s > fast_w + 1e-9) continue;
      gaze_gain = std::max(gaze_gain, std::abs(r.gain_db));
      gaze_phase = std::max(gaze_phase, std::abs(r.phase_deg));
    }
    const double highest = hand.back().omega_rad_s;
    outcome.metrics = {
        at_least("hand_break_rad_s", hand_break.value_or(highest), "rad/s", 6, "0.24",
                 "where the hand's gain falls below -3 dB; the highest frequency tried, where it does not"),
        at_most("hand_lag_deg", -fast.hand.phase_deg, "deg", 5, std::nullopt, "of the hand at 1.256 rad/s"),
        at_most("gaze_gain_db", gaze_gain, "dB", 0.1, "0", "largest deviation from 0 dB up to 1.256 rad/s"),
        at_most("gaze_phase_deg", gaze_phase, "deg", 2, "0", "largest up to 1.256 rad/s"),
        at_least("gaze_break_rad_s", gaze_break.value_or(highest), "rad/s", 12, std::nullopt,
                 "as the hand's"),
        at_least("thesis_law_break_rad_s", thesis_break.value_or(highest), "rad/s", std::nullopt, "0.24",
                 "of the hand with the law as printed, on the same simulated arm")};
    outcome.pictures.push_back(drawn(options.out / "bode.png",
                                     tools::bode_figure("From the marker to hand and gazing point",
                                                        {bode("gazing point", gaze), bode("hand", hand),
                                                         bode("hand, law as printed", thesis)}),
                                     "Gain and phase, as Fig. 4.1 (d) and (e)."));
  } else {
    outcome.metrics = {
        at_least("hand_amplitude_mm", fast.hand.output.amplitude, "mm",
                 seen == Seen::kPose ? std::optional<double>(148) : std::nullopt,
                 seen == Seen::kPose ? std::optional<std::string>("50") : std::nullopt,
                 "of the marker's 150 mm, at T = 5 s"),
        at_most("hand_rms_mm", rms(distances_mm(fast.log, "wanted", "hand", settled)), "mm",
                seen == Seen::kPose ? std::optional<double>(5) : std::nullopt, std::nullopt, "at T = 5 s"),
        at_most("gaze_rms_mm", rms(distances_mm(fast.log, "target", "gaze", settled)), "mm",
                seen == Seen::kPose ? std::optional<double>(5) : std::nullopt, std::nullopt, "at T = 5 s"),
        at_most("hand_lag_deg", -fast.hand.phase_deg, "deg", std::nullopt, std::nullopt, "at 1.256 rad/s"),
        at_most("gaze_lag_deg", -fast.gaze.phase_deg, "deg", std::nullopt, "slightly late",
                "at 1.256 rad/s")};
    const SeenErrors errors = seen_errors(fast.log, settled);
    outcome.metrics.push_back(
        at_most("seen_rms_mm",
                std::sqrt(errors.rms_mm[0] * errors.rms_mm[0] + errors.rms_mm[1] * errors.rms_mm[1] +
                          errors.rms_mm[2] * errors.rms_mm[2]),
                "mm", std::nullopt, std::nullopt, "error of the position seen, at T = 5 s"));
    outcome.pictures.push_back(drawn(options.out / "bode.png",
                                     tools::bode_figure("From the marker to hand and gazing point",
                                                        {bode("gazing point", gaze), bode("hand", hand)}),
                                     "Gain and phase, as Fig. 4.2 (d) and (e)."));
  }
  tools::Figure tracking;
  tracking.title = "Marker, hand and gazing point";
  tracking.share_x = false;
  for (const double period_s : {20.0, 10.0, 5.0}) tracking.panels.push_back(sway_panel(at(runs, period_s)));
  outcome.pictures.push_back(
      drawn(options.out / "tracking.png", tracking, "As Figs. 4.1 to 4.3 (a) to (c)."));
  tools::Figure errors;
  errors.title = "How far hand and gazing point are off";
  errors.share_x = false;
  for (const double period_s : {20.0, 10.0, 5.0}) errors.panels.push_back(lateness_panel(at(runs, period_s)));
  outcome.pictures.push_back(drawn(options.out / "errors.png", errors, "As Fig. 4.3 (a.2) to (c.2)."));
  if (seen != Seen::kNothing) {
    outcome.pictures.push_back(drawn(options.out / "pose.png", pose_figure(fast.log, "All six at T = 5 s"),
                                     "As Figs. 4.3 to 4.8, relative to the hand at the start."));
    outcome.pictures.push_back(fast.last);
  } else {
    outcome.notes.emplace_back(
        "Beyond 1.256 rad/s the sway is smaller than 150 mm, so that no joint is asked for more speed, "
        "acceleration "
        "or jerk than it may have; each such run takes 20 s.");
  }
  outcome.notes.emplace_back(
      "The printed motion z_MO = 150 - 150 cos(wt) [4.3] is lateral, along what the thesis's figures call "
      "x.");
  return outcome;
}

}  // namespace

Outcome lateral_known(const RunOptions& options) {
  return run_lateral(Seen::kNothing, options);
}

Outcome lateral_3dof(const RunOptions& options) {
  return run_lateral(Seen::kPosition, options);
}

Outcome lateral_6dof(const RunOptions& options) {
  return run_lateral(Seen::kPose, options);
}

}  // namespace vergence::demo
