#include "tools/rig/rig_log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/clock.hpp"
#include "tools/demo/measures.hpp"

namespace vergence::rig {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A drive is sent whole units, and follows exactly: rounding is all that may be beyond a limit.
constexpr double kRounding = 1.0005;

void add(std::vector<double>& row, const Transform& T) {
  const Pose pose = to_pose(T);
  for (int i = 0; i < 3; ++i) row.push_back(pose.position_mm[i]);
  for (int i = 0; i < 3; ++i) row.push_back(pose.e[i]);
}

void add(std::vector<double>& row, const ControllerView& controller, std::int64_t start_ns) {
  constexpr std::size_t kValues = 11;
  if (!controller.record()) {
    row.insert(row.end(), kValues, kNaN);
    return;
  }
  const TelemetryRecord& said = *controller.record();
  row.insert(row.end(), {static_cast<double>(said.mode), static_cast<double>(said.track_state),
                         static_cast<double>(said.target_believed), static_cast<double>(said.sighting),
                         said.sighting_stamp_ns > 0 ? seconds(said.sighting_stamp_ns - start_ns) : kNaN});
  row.insert(row.end(), said.T_H_M.position_mm.begin(), said.T_H_M.position_mm.end());
  row.insert(row.end(), said.T_H_M.e.begin(), said.T_H_M.e.end());
}

}  // namespace

tools::LogTable empty_rig_log() {
  std::vector<std::string> names = {"t_s", "faults"};
  for (const char* of : {"target", "hand", "wanted"}) {
    for (const char* part : {"_x_mm", "_y_mm", "_z_mm", "_e1", "_e2", "_e3"})
      names.push_back(std::string(of) + part);
  }
  for (const char* part : {"tool_mm_per_s", "tilt_rad", "pan_right_rad", "pan_left_rad", "tilt_steps",
                           "pan_right_steps", "pan_left_steps", "lost_steps", "eyes_enabled"}) {
    names.emplace_back(part);
  }
  for (std::size_t i = 1; i <= kMaxJoints; ++i) {
    const std::string number = std::to_string(i);
    names.push_back("q" + number + "_rad");
    names.push_back("v" + number + "_rad_per_s");
    names.push_back("sent" + number + "_rad_per_s");
    names.push_back("state" + number);
  }
  for (const char* part : {"syncs", "frames_received", "frames_sent", "edges", "pictures", "mode",
                           "track_state", "believed", "sighting", "sighting_s"})
    names.emplace_back(part);
  for (const char* part : {"_x_mm", "_y_mm", "_z_mm", "_e1", "_e2", "_e3"})
    names.push_back(std::string("seen") + part);
  return tools::LogTable(names);
}

void add_row(tools::LogTable& log, const RigRow& row, const RigWorld& world, const DriveBank& drives,
             const EyeMotors& eyes, const DesiredRelation& relation, const ControllerView& controller) {
  const Transform T_S_W = world.T_W_S().inverse();
  const Transform T_S_M = T_S_W * world.T_W_M(row.t_s);
  const Transform T_S_H = T_S_W * world.T_W_H(drives.position_rad());
  std::vector<double> values = {row.t_s, static_cast<double>(row.faults)};
  add(values, T_S_M);
  add(values, T_S_H);
  add(values, relation.position_only ? Transform{T_S_H.R, T_S_M.t_mm - T_S_H.R * relation.T_Ed_M.t_mm}
                                     : T_S_M * relation.T_Ed_M.inverse());
  values.push_back(row.tool_mm_per_s);
  const EyeAngles angles = eyes.angles();
  for (const double angle : {angles.tilt_rad, angles.pan_right_rad, angles.pan_left_rad})
    values.push_back(angle);
  double lost = 0;
  for (std::size_t i = 0; i < kPanTiltMotors; ++i) {
    values.push_back(static_cast<double>(eyes.issued_steps(i)));
    lost += std::abs(eyes.lost_steps(i));
  }
  values.push_back(lost);
  values.push_back(eyes.is_enabled() ? 1 : 0);
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    const bool is_there = i < drives.joints();
    values.push_back(is_there ? drives.position_rad()[i] : kNaN);
    values.push_back(is_there ? drives.velocity_rad_per_s()[i] : kNaN);
    values.push_back(is_there ? drives.sent_rad_per_s(i) : kNaN);
    values.push_back(is_there ? static_cast<double>(drives.state(i)) : kNaN);
  }
  const BusCounts& bus = drives.counts();
  for (const std::uint64_t count : {bus.syncs, bus.received, bus.sent, eyes.edges(), row.pictures}) {
    values.push_back(static_cast<double>(count));
  }
  add(values, controller, row.start_ns);
  log.append(values);
}

Judge::Judge(const RigScenario& scenario, const SerialArm& arm, double tool_limit_mm_per_s)
    : scenario_(scenario), arm_(arm), tool_limit_mm_per_s_(tool_limit_mm_per_s), faults_(scenario) {}

void Judge::watch(double t_s, double tool_mm_per_s, const DriveBank& drives,
                  const ControllerView& controller) {
  worst_tool_mm_per_s_ = std::max(worst_tool_mm_per_s_, tool_mm_per_s);
  total_way_mm_ += tool_mm_per_s * 1e-3;
  was_any_enabled_ = was_any_enabled_ || drives.is_any_enabled();
  commands_ = drives.counts().commands;
  for (std::size_t i = 0; i < drives.joints(); ++i) {
    const JointLimits& limits = arm_.limits[i];
    worst_sent_share_ =
        std::max(worst_sent_share_, std::abs(drives.sent_rad_per_s(i)) / limits.velocity_rad_per_s);
    worst_speed_share_ =
        std::max(worst_speed_share_, std::abs(drives.velocity_rad_per_s()[i]) / limits.velocity_rad_per_s);
    const double q = drives.position_rad()[i];
    worst_outside_rad_ = std::max({worst_outside_rad_, q - limits.max_rad, limits.min_rad - q});
  }
  faults_.watch({t_s, tool_mm_per_s, drives.is_any_enabled(), controller.searches(), controller.tracks()});
}

void Judge::add_still(std::vector<tools::Metric>& metrics, const tools::LogTable& log) const {
  using demo::at_most;
  metrics.push_back(at_most("arm_way_mm", total_way_mm_, "mm", 0, std::nullopt, "how far the tool went"));
  metrics.push_back(at_most("drives_enabled", was_any_enabled_ ? 1 : 0, "", 0, std::nullopt,
                            "whether any drive of the arm was ever in operation"));
  metrics.push_back(at_most("bus_commands", static_cast<double>(commands_), "", 0, std::nullopt,
                            "frames on the bus that were more than a request to read an object"));
  const auto steps = static_cast<double>(scenario_.eye_steps);
  if (scenario_.eye_steps == 0) {
    metrics.push_back(at_most("gpio_edges", demo::largest(log.column("edges")), "", 0, std::nullopt,
                              "levels that were set on any line"));
  }
  for (const char* const motor : {"tilt", "pan_right", "pan_left"}) {
    const std::vector<double> way = log.column(std::string(motor) + "_steps");
    metrics.push_back(at_most(std::string(motor) + "_off_steps", std::abs(demo::largest(way) - steps),
                              "steps", 0, std::nullopt, "how far off the asked-for way it went at most"));
    metrics.push_back(at_most(std::string(motor) + "_left_steps", std::abs(way.back()), "steps", 0,
                              std::nullopt, "how far from its start it was left"));
  }
}

std::vector<tools::Metric> Judge::metrics(const tools::LogTable& log) const {
  using demo::at_least;
  using demo::at_most;
  std::vector<tools::Metric> metrics;
  metrics.push_back(at_most("sent_share_of_limit", worst_sent_share_, "", kRounding, std::nullopt,
                            "fastest velocity any drive was sent, as a share of its joint's limit"));
  metrics.push_back(at_most("speed_share_of_limit", worst_speed_share_, "", kRounding, std::nullopt,
                            "fastest any joint went, as a share of its limit"));
  metrics.push_back(at_most("outside_range_rad", worst_outside_rad_, "rad", 0, std::nullopt,
                            "farthest any joint was beyond its range"));
  metrics.push_back(at_most("tool_largest_mm_per_s", worst_tool_mm_per_s_, "mm/s",
                            tool_limit_mm_per_s_ * kRounding, std::nullopt, "fastest the tool went"));
  metrics.push_back(
      at_least("tool_way_mm", total_way_mm_, "mm", std::nullopt, std::nullopt, "way of the tool altogether"));
  for (tools::Metric& metric : faults_.metrics()) metrics.push_back(std::move(metric));
  if (scenario_.arm_rests) add_still(metrics, log);
  const demo::Window settled{scenario_.settle_s, scenario_.duration_s};
  std::optional<double> target;
  if (scenario_.hand_rms_mm > 0) target = scenario_.hand_rms_mm;
  metrics.push_back(at_most("hand_rms_mm", demo::rms(demo::distances_mm(log, "wanted", "hand", settled)),
                            "mm", target, std::nullopt,
                            "distance of the hand from where it is wanted, once settled"));
  metrics.push_back(at_most("lost_steps", demo::largest(log.column("lost_steps")), "", 0, std::nullopt,
                            "steps the eyes' motors could not follow"));
  return metrics;
}

}  // namespace vergence::rig
