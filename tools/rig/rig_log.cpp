#include "tools/rig/rig_log.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/demo/measures.hpp"

namespace vergence::rig {
namespace {

constexpr double kStill_mm_per_s = 1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A drive is sent whole units, and follows exactly: rounding is all that may be beyond a limit.
constexpr double kRounding = 1.0005;

void add(std::vector<double>& row, const Transform& T) {
  const Pose pose = to_pose(T);
  for (int i = 0; i < 3; ++i) row.push_back(pose.position_mm[i]);
  for (int i = 0; i < 3; ++i) row.push_back(pose.e[i]);
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
  for (const char* part :
       {"syncs", "frames_received", "frames_sent", "edges", "pictures", "mode", "track_state", "believed"})
    names.emplace_back(part);
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
  add(values, T_S_M * relation.T_Ed_M.inverse());
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
  const std::optional<TelemetryRecord>& said = controller.record();
  values.push_back(said ? said->mode : kNaN);
  values.push_back(said ? said->track_state : kNaN);
  values.push_back(said ? said->target_believed : kNaN);
  log.append(values);
}

Judge::Judge(const RigScenario& scenario, const SerialArm& arm, double tool_limit_mm_per_s)
    : scenario_(scenario),
      arm_(arm),
      tool_limit_mm_per_s_(tool_limit_mm_per_s),
      verdicts_(scenario.faults.size()) {}

// A stop is latched until the operator's next word; the next fault is judged by itself.
double Judge::end_of(std::size_t fault) const {
  const double from_s = scenario_.faults[fault].at_s;
  double end_s = scenario_.duration_s;
  for (const OperatorEvent& event : scenario_.operators) {
    if (event.at_s > from_s) end_s = std::min(end_s, event.at_s);
  }
  for (const FaultEvent& other : scenario_.faults) {
    if (other.at_s > from_s) end_s = std::min(end_s, other.at_s);
  }
  return end_s;
}

void Judge::watch_rest(const FaultEvent& fault, Verdict& verdict, double t_s, double tool_mm_per_s,
                       const ControllerView& controller) const {
  const double since_s = t_s - fault.at_s;
  if (since_s >= fault.within_s && since_s < fault.for_s) {
    ++verdict.rest_rows;
    // Without pictures the last look remains what it was.
    const bool sees_it = fault.kind == FaultKind::kTargetAbsent && controller.tracks();
    if (controller.searches() && !sees_it) ++verdict.searching_rows;
  }
  if (since_s >= fault.for_s && verdict.again_s < 0 && tool_mm_per_s >= kStill_mm_per_s) {
    verdict.again_s = since_s - fault.for_s;
  }
}

void Judge::watch(double t_s, double tool_mm_per_s, const DriveBank& drives,
                  const ControllerView& controller) {
  worst_tool_mm_per_s_ = std::max(worst_tool_mm_per_s_, tool_mm_per_s);
  total_way_mm_ += tool_mm_per_s * 1e-3;
  for (std::size_t i = 0; i < drives.joints(); ++i) {
    const JointLimits& limits = arm_.limits[i];
    worst_sent_share_ =
        std::max(worst_sent_share_, std::abs(drives.sent_rad_per_s(i)) / limits.velocity_rad_per_s);
    worst_speed_share_ =
        std::max(worst_speed_share_, std::abs(drives.velocity_rad_per_s()[i]) / limits.velocity_rad_per_s);
    const double q = drives.position_rad()[i];
    worst_outside_rad_ = std::max({worst_outside_rad_, q - limits.max_rad, limits.min_rad - q});
  }
  for (std::size_t k = 0; k < verdicts_.size(); ++k) {
    const FaultEvent& fault = scenario_.faults[k];
    Verdict& verdict = verdicts_[k];
    if (t_s < fault.at_s) {
      verdict.was_enabled = drives.is_any_enabled();
      verdict.moving_mm_per_s = tool_mm_per_s;
    }
    if (t_s < fault.at_s || t_s >= end_of(k)) continue;
    const double since_s = t_s - fault.at_s;
    if (!drives.is_any_enabled()) verdict.was_disabled = true;
    if (fault.expect == Expectation::kRest) {
      watch_rest(fault, verdict, t_s, tool_mm_per_s, controller);
      if (since_s >= fault.for_s) continue;
    }
    const bool is_still = tool_mm_per_s < kStill_mm_per_s;
    if (!is_still && verdict.still_since_s >= 0 && since_s > fault.within_s && verdict.moved_again_s < 0) {
      verdict.moved_again_s = since_s;
    }
    if (since_s <= fault.within_s || verdict.still_since_s < 0) {
      if (!is_still) verdict.still_since_s = -1;
      if (is_still && verdict.still_since_s < 0) verdict.still_since_s = since_s;
    }
    if (since_s > fault.within_s)
      verdict.fastest_mm_per_s = std::max(verdict.fastest_mm_per_s, tool_mm_per_s);
  }
}

void Judge::add_rest(std::vector<tools::Metric>& metrics, const std::string& name, const FaultEvent& fault,
                     const Verdict& verdict) {
  const double searching =
      verdict.rest_rows > 0 ? static_cast<double>(verdict.searching_rows) / verdict.rest_rows : kNaN;
  metrics.push_back(demo::at_least(name + "_searching", searching, "", 1, std::nullopt,
                                   "share of that time in which the controller said that it searches, and "
                                   "believed in no target"));
  const double again_ms = verdict.again_s < 0 ? kNaN : verdict.again_s * 1e3;
  metrics.push_back(demo::at_most(name + "_again_ms", again_ms, "ms", fault.again_within_s * 1e3,
                                  std::nullopt, "from its end until the tool moved again"));
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
  for (std::size_t k = 0; k < verdicts_.size(); ++k) {
    const FaultEvent& fault = scenario_.faults[k];
    const Verdict& verdict = verdicts_[k];
    const std::string name = std::to_string(k + 1) + "_" + fault.name;
    if (fault.expect == Expectation::kStop || fault.expect == Expectation::kRest) {
      // A hand that rests proves nothing.
      std::optional<double> moving;
      if (fault.at_s >= scenario_.settle_s) moving = kStill_mm_per_s;
      metrics.push_back(at_least(name + "_from_mm_per_s", verdict.moving_mm_per_s, "mm/s", moving,
                                 std::nullopt, "how fast the tool was when the fault came"));
      const double still_ms = verdict.still_since_s < 0 ? kNaN : verdict.still_since_s * 1e3;
      metrics.push_back(at_most(name + "_still_ms", still_ms, "ms", fault.within_s * 1e3, std::nullopt,
                                "from the fault until the tool was slower than 1 mm/s"));
      const bool rests = fault.expect == Expectation::kRest;
      metrics.push_back(at_most(name + "_then_mm_per_s", verdict.fastest_mm_per_s, "mm/s", kStill_mm_per_s,
                                std::nullopt,
                                rests ? "fastest after that, until it was over"
                                      : "fastest after that, until the operator's next word"));
      if (rests) add_rest(metrics, name, fault, verdict);
    }
    if (fault.expect == Expectation::kStop) {
      metrics.push_back(at_least(name + "_drives_off", verdict.was_disabled ? 1 : 0, "", 1, std::nullopt,
                                 "whether the drives went out of operation"));
    }
    if (fault.expect == Expectation::kCarryOn || fault.expect == Expectation::kRest) {
      metrics.push_back(at_most(name + "_stops", verdict.was_enabled && !verdict.was_disabled ? 0 : 1, "", 0,
                                std::nullopt,
                                "whether the drives went out of operation, which was not called for"));
    }
  }
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
