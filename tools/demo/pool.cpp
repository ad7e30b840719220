// Section 6.3: a squid afloat under rippled, glinting water; a stick hides it and pushes it; the hand comes
// down over it and drops a pen.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "algo/trigonometry.hpp"
#include "tools/demo/closed_loop.hpp"
#include "tools/demo/experiments.hpp"
#include "tools/demo/measures.hpp"
#include "tools/demo/pen.hpp"
#include "tools/render/random.hpp"

namespace vergence::demo {
namespace {

constexpr double kStartHeight_mm = 680;
constexpr double kHeight_mm = 600;
constexpr double kPushed_s = 6.0;
constexpr double kPush_s = 1.2;
constexpr double kDropFrom_s = 9.0;  // not before
constexpr double kEnd_s = 15;

double sine(double angle_rad) {
  return sin_cos(std::fmod(angle_rad, 2 * std::numbers::pi)).sine;
}

// How this squid drifts, decided by the seed.
struct Squid {
  Vector3 start_mm;
  Vector3 push_mm;
  double phase_rad;
  double yaw;

  explicit Squid(std::uint64_t seed) {
    std::uint64_t drawn = 4000;
    const auto random = [&](double low, double high) {
      const double unit = static_cast<double>(render::hash(seed, drawn++) >> 11) * 0x1p-53;
      return low + (high - low) * unit;
    };
    const double x_mm = random(-60, 60);
    const double y_mm = random(-45, 45);
    start_mm = {x_mm, y_mm, kStartHeight_mm};
    const SinCos direction = sin_cos(random(0, 2 * std::numbers::pi));
    push_mm = random(30, 60) * Vector3(direction.cosine, direction.sine, 0);
    phase_rad = random(0, 2 * std::numbers::pi);
    yaw = random(-0.12, 0.12);
  }

  // Waves, and the push: as a smooth step.
  [[nodiscard]] Pose at(double t_s) const {
    const double share = std::clamp((t_s - kPushed_s) / kPush_s, 0.0, 1.0);
    const double pushed = share * share * (3 - 2 * share);
    const double t = 1.9 * t_s + phase_rad;
    Pose pose;
    pose.position_mm =
        start_mm + pushed * push_mm + Vector3(15 * sine(t), 8 * sine(0.7 * t + 1), 6 * sine(1.3 * t));
    pose.e = {0.04 * sine(t), 0.03 * sine(0.8 * t), yaw + 0.05 * sine(0.6 * t) + 0.04 * pushed};
    return pose;
  }
};

std::string key(double t_s, const Vector3& p_mm) {
  char text[160];
  std::snprintf(text, sizeof text, "  { t_s = %.3f, pose = [%.3f, %.3f, %.3f, 0, 0, 0] },\n", t_s, p_mm[0],
                p_mm[1], p_mm[2]);
  return text;
}

// The stick comes from behind the squid as it is going to be pushed, over its edge, follows, and goes.
std::string scene(const Squid& squid) {
  const Vector3 way = squid.push_mm.normalized();
  const Vector3 across(-way[1], way[0], 0);
  const auto beside = [&](double t_s, double behind_mm) {
    Vector3 p = squid.at(t_s).position_mm - behind_mm * way;
    p[2] -= 40;
    return p;
  };
  char direction[96];
  std::snprintf(direction, sizeof direction, "[%.6f, %.6f, -0.2]", across[0], across[1]);
  return std::string(
             "[rig]\nkind = \"photo\"\nconverge_mm = 640\n"
             "[target]\nkind = \"creature\"\ncreature = \"squid\"\n"
             "[background]\nhue_deg = 196\nsaturation = 0.55\nvalue = 0.66\ndistance_mm = 1300\nfeature_mm = "
             "160\n"
             "[water]\nstrength = 0.7\nsurface_mm = 600\nwavelength_mm = 55\ncoverage = 0.30\n"
             "[search]\ncentre = [0, 0, 640, 0, 0, 0]\nhalf_range = [140, 120, 110, 0.35, 0.35, 0.35]\n"
             "[[occluder]]\nwidth_mm = 14\nlength_mm = 500\nhue_deg = 28\nsaturation = 0.6\nvalue = "
             "0.6\ndirection = ") +
         direction + "\n[occluder.motion]\nkind = \"keys\"\nkey = [\n" +
         key(kPushed_s - 1.5, beside(kPushed_s, 330)) + key(kPushed_s, beside(kPushed_s, 25)) +
         key(kPushed_s + kPush_s, beside(kPushed_s + kPush_s, 25)) +
         key(kPushed_s + kPush_s + 1.5, beside(kPushed_s + kPush_s, 330)) + "]\n";
}

// By what the controller believes alone.
bool is_to_be_dropped(const Pipeline& pipeline) {
  const ArmPeriod& arm = pipeline.arm_period();
  if (arm.mode != Mode::kServo || !arm.target_believed) return false;
  return Pen::will_hit(arm.hand.T_W_H, arm.target.T_W_M,
                       arm.target.velocity.linear_mm_per_s - arm.hand.hand.linear_mm_per_s);
}

}  // namespace

Outcome pool(const RunOptions& options) {
  const Squid squid(options.seed);
  const Transform T_W_S = pool_start();
  LoopSetup setup;
  setup.name = "pool";
  setup.scene = scene(squid);
  setup.duration_s = kEnd_s;
  setup.T_W_S = T_W_S;
  setup.adjust_robot = [](RobotConfig& robot) {
    robot.relation.T_Ed_M.t_mm = {0, 0, kHeight_mm};
    robot.relation.position_only = true;
  };
  Pen pen(T_W_S.inverse());
  setup.adjust_world = [&](plant::WorldOptions& world) {
    world.target = [&squid, &pen, T_W_S](double t_s) {
      Pose pose = squid.at(std::max(t_s, 0.0));
      // What is hit drifts away.
      if (pen.hit && t_s > *pen.landed_s) {
        pose.position_mm += std::min(t_s - *pen.landed_s, 2.0) * 30 * squid.push_mm.normalized();
      }
      return T_W_S * to_transform(pose);
    };
  };
  ClosedLoop loop(setup, options);
  loop.on_tick = [&](double t_s) {
    plant::World& world = loop.world();
    const bool let_go = !pen.dropped_s && t_s >= kDropFrom_s && is_to_be_dropped(loop.pipeline());
    pen.step(t_s, world.T_W_H(), world.T_W_M(t_s), world.scene().target.mesh, let_go);
  };
  const auto run_to = [&](double end_s) {
    while (loop.now_s() < end_s && !(pen.landed_s && loop.now_s() > *pen.landed_s + 1)) {
      loop.run_until(loop.now_s() + 0.1);
      if (options.progress) options.progress(loop.now_s() / kEnd_s);
    }
  };
  std::vector<tools::Picture> eyes;
  const auto draw = [&](const char* file, const std::string& caption) {
    eyes.push_back(loop.draw_last_frame(options.out / file, caption));
  };
  run_to(0.2);
  draw("eyes_start.png", "At the start: the squid as it is seen (magenta), and as it is (white).");
  run_to(kPushed_s + 0.4);
  draw("eyes_pushed.png", "The stick pushes the squid.");
  run_to(kEnd_s);
  draw("eyes_end.png", "After the pen has fallen.");

  Outcome outcome{loop.take_log(), loop.now_s(), {}, {}, {}};
  const tools::LogTable& log = outcome.log;
  const SeenErrors first = seen_errors(log, {0, 0.3});
  const auto height_at = [&](double t_s) {
    return largest(difference(log, "target_z_mm", "hand_z_mm", {t_s - 0.005, t_s + 0.005}));
  };
  const double before_drop_s = pen.dropped_s.value_or(kEnd_s);
  outcome.metrics = {
      at_least("hit", pen.hit ? 1 : 0, "", 1, "hits", "whether the pen meets the squid's body"),
      at_most("miss_mm", pen.miss_mm, "mm", std::nullopt, std::nullopt,
              "from the squid's middle, where the pen came down"),
      at_most("start_height_error_mm", first.rms_mm[2], "mm", 10, "near 680",
              "error of the height seen in the first 0.3 s"),
      at_most("height_off_at_5s_mm", std::abs(height_at(5) - kHeight_mm), "mm", 10, "about 600",
              "5 s after the start"),
      at_most(
          "hand_rms_mm", rms(distances_mm(log, "wanted", "hand", {5, before_drop_s})), "mm", std::nullopt,
          std::nullopt,
          "distance of the hand from where it is wanted, from 5 s until the drop, stick and push included"),
      at_most("dropped_at_s", pen.dropped_s.value_or(std::numeric_limits<double>::quiet_NaN()), "s", kEnd_s,
              std::nullopt, "when the pen was let go")};
  std::vector<tools::Span> spans = {{kPushed_s, kPushed_s + kPush_s, "pushed"}};
  if (pen.dropped_s)
    spans.push_back({*pen.dropped_s, pen.landed_s.value_or(*pen.dropped_s + 0.3), "pen falls"});
  tools::Figure figure = pose_figure(log, "Hand and squid");
  figure.panels.front().spans = spans;
  outcome.pictures = {
      drawn(options.out / "pose.png", figure,
            "As Fig. 6.8, relative to the hand at the start, which looks down: z is depth. Of the hand's "
            "orientation nothing is wanted."),
      drawn(options.out / "seen_errors.png", seen_error_figure(log, "Errors of the pose seen"),
            "Frame by frame, in the hand's frame.")};
  outcome.pictures.insert(outcome.pictures.end(), eyes.begin(), eyes.end());
  outcome.notes.emplace_back(
      "The pen is let go when, by what the controller believes, it will come down within 8 mm of the "
      "squid's middle; it falls freely from 100 mm below the hand.");
  return outcome;
}

}  // namespace vergence::demo
