// Section 6.2: the hand keeps its place before a crab that wanders, and before one that turns; and beyond the
// thesis, the photo-model with eyes that follow.
#include <cmath>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"

namespace vergence::demo {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kDistance_mm = 500;  // T_M_Hd of Eq. 6.1

double sine(double angle_rad) {
  return sin_cos(std::fmod(angle_rad, kTurn)).sine;
}

// y_W, z_W: 100 mm in 20 s; x_W: 100 mm in 60 s; in S, where x is y_W, y is -z_W and z is -x_W.
Pose wandering(double t_s) {
  const double quick = 100 * sine(kTurn * t_s / 20);
  return {{quick, -quick, kDistance_mm - 100 * sine(kTurn * t_s / 60)}, Vector3::Zero()};
}

// Half a period of 25 degrees in 20 s about z, x and y of the crab in turn.
Pose turning(double t_s) {
  constexpr double kStep_s = 20;
  constexpr double kMost_rad = 25 * std::numbers::pi / 180;
  constexpr int kAxes[] = {2, 0, 1};
  const int step = std::min(static_cast<int>(t_s / kStep_s), 2);
  const double share = std::min(t_s / kStep_s - step, 1.0);
  const double angle = kMost_rad * sine(std::numbers::pi * share);
  Pose pose{{0, 0, kDistance_mm}, Vector3::Zero()};
  pose.e[kAxes[step]] = sin_cos(angle / 2).sine;
  return pose;
}

// Sideways, up and down and in depth, turning a little, all at their own pace.
Pose swimming(double t_s) {
  return {{120 * sine(kTurn * t_s / 6), 60 * sine(kTurn * t_s / 9 + 1),
           kDistance_mm + 40 * sine(kTurn * t_s / 13)},
          {0.08 * sine(kTurn * t_s / 8), 0.1 * sine(kTurn * t_s / 7 + 2), 0.1 * sine(kTurn * t_s / 11)}};
}

struct CrabRun {
  std::string rig;
  double duration_s;
  Pose (*path)(double t_s);
  std::string title;
};

struct CrabOutcome {
  Outcome outcome;
  double hand_rms_mm;
  double hand_rms_e;
  double gaze_rms_mm;
};

CrabOutcome run_crab(const CrabRun& run, const RunOptions& options) {
  const Transform T_W_S = lateral_start();
  LoopSetup setup;
  setup.name = "crab";
  setup.scene = "[rig]\nkind = \"" + run.rig + "\"\n[target]\nkind = \"creature\"\ncreature = \"C12\"\n";
  setup.duration_s = run.duration_s;
  setup.T_W_S = T_W_S;
  setup.adjust_robot = [](RobotConfig& robot) { robot.relation.T_Ed_M.t_mm = {0, 0, kDistance_mm}; };
  setup.adjust_world = [&](plant::WorldOptions& world) {
    world.target = [T_W_S, path = run.path](double t_s) {
      return T_W_S * to_transform(path(std::max(t_s, 0.0)));
    };
  };
  ClosedLoop loop(setup, options);
  loop.run(options.progress);
  const tools::Picture last =
      loop.draw_last_frame(options.out / "last_frame.png",
                           "The last frame, with the photo-model as it was seen (magenta, its points "
                           "coloured by the relief it has learned) and as it is (white).");
  CrabOutcome result{{loop.take_log(), run.duration_s, {}, {}, {}}, 0, 0, 0};
  const tools::LogTable& log = result.outcome.log;
  const Window settled{3, 1e9};  // the drives take 0.2 s to come on
  result.hand_rms_mm = rms(distances_mm(log, "wanted", "hand", settled));
  result.hand_rms_e = rms(turns_e(log, "wanted", "hand", settled));
  result.gaze_rms_mm = rms(distances_mm(log, "target", "gaze", settled));
  const SeenErrors seen = seen_errors(log, {});
  const FirstLock lock = first_lock(log);
  auto& metrics = result.outcome.metrics;
  metrics.push_back(at_most("hand_largest_mm", largest(distances_mm(log, "wanted", "hand", settled)), "mm",
                            std::nullopt, std::nullopt, "largest error of the hand, after 3 s"));
  metrics.push_back(at_most("seen_x_rms_mm", seen.rms_mm[0], "mm", std::nullopt, std::nullopt,
                            "error of the pose seen, over all frames tracked"));
  metrics.push_back(at_most("seen_y_rms_mm", seen.rms_mm[1], "mm", std::nullopt, std::nullopt, "the same"));
  metrics.push_back(at_most("seen_z_rms_mm", seen.rms_mm[2], "mm", std::nullopt, std::nullopt, "the same"));
  metrics.push_back(at_most("seen_e_rms", seen.rms_e, "", std::nullopt, std::nullopt, "the same"));
  metrics.push_back(at_least("tracked_percent", 100.0 * seen.tracked / seen.frames, "%", std::nullopt,
                             std::nullopt, "of the frames"));
  metrics.push_back(at_most("frames_before_lock", lock.frames_before, "", 0, std::nullopt,
                            "frames looked at before the crab was found"));
  auto& pictures = result.outcome.pictures;
  pictures.push_back(
      drawn(options.out / "pose.png", pose_figure(log, run.title),
            "Where the hand was wanted, where it was, and the crab; relative to the hand at the start."));
  pictures.push_back(drawn(options.out / "seen_errors.png", seen_error_figure(log, "Errors of the pose seen"),
                           "Frame by frame, in the hand's frame."));
  pictures.push_back(last);
  return result;
}

}  // namespace

Outcome servo_position(const RunOptions& options) {
  CrabOutcome run = run_crab({"photo", 60, wandering, "The crab wanders, the hand follows"}, options);
  run.outcome.metrics.insert(run.outcome.metrics.begin(),
                             at_most("hand_rms_mm", run.hand_rms_mm, "mm", 5, "some phase lag",
                                     "distance of the hand from where it is wanted, after 3 s"));
  return run.outcome;
}

Outcome servo_orientation(const RunOptions& options) {
  CrabOutcome run = run_crab({"photo", 60, turning, "The crab turns, the hand follows"}, options);
  run.outcome.metrics.insert(
      run.outcome.metrics.begin(),
      {at_most("hand_rms_mm", run.hand_rms_mm, "mm", 5, "some phase lag",
               "distance of the hand from where it is wanted, after 3 s"),
       at_most("hand_rms_e", run.hand_rms_e, "", 0.02, "some phase lag", "the same of its orientation")});
  return run.outcome;
}

Outcome photo_vergence(const RunOptions& options) {
  CrabOutcome run = run_crab({"eyes", 40, swimming, "The crab swims, hand and eyes follow"}, options);
  run.outcome.metrics.insert(
      run.outcome.metrics.begin(),
      {at_most("hand_rms_mm", run.hand_rms_mm, "mm", 5, "future work",
               "distance of the hand from where it is wanted, after 3 s"),
       at_most("hand_rms_e", run.hand_rms_e, "", 0.02, "future work", "the same of its orientation"),
       at_most("gaze_rms_mm", run.gaze_rms_mm, "mm", 5, "future work",
               "distance of the gazing point from the crab")});
  return run.outcome;
}

}  // namespace vergence::demo
