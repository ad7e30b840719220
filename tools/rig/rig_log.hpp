// What a run of the rig leaves, a row each hundredth of a second, and what is judged of it: all of it from
// the plant's side, by what the motors did.
#pragma once

#include <string>
#include <vector>

#include "algo/hand_servo.hpp"
#include "tools/report/log_table.hpp"
#include "tools/report/metric.hpp"
#include "tools/rig/controller_view.hpp"
#include "tools/rig/drive_bank.hpp"
#include "tools/rig/fault_judge.hpp"
#include "tools/rig/rig_scenario.hpp"
#include "tools/rig/rig_world.hpp"

namespace vergence::rig {

struct RigRow {
  double t_s = 0;
  double tool_mm_per_s = 0;  // largest since the row before
  int faults = 0;            // under way
  std::uint64_t pictures = 0;
  std::int64_t start_ns = 0;  // of t_s, on the controller's clock
};

[[nodiscard]] tools::LogTable empty_rig_log();
void add_row(tools::LogTable& log, const RigRow& row, const RigWorld& world, const DriveBank& drives,
             const EyeMotors& eyes, const DesiredRelation& relation, const ControllerView& controller);

// Each millisecond: what the arm was sent and did, against its limits; and when it stood still.
class Judge {
 public:
  Judge(const RigScenario& scenario, const SerialArm& arm, double tool_limit_mm_per_s);

  void watch(double t_s, double tool_mm_per_s, const DriveBank& drives, const ControllerView& controller);
  [[nodiscard]] std::vector<tools::Metric> metrics(const tools::LogTable& log) const;

 private:
  void add_still(std::vector<tools::Metric>& metrics, const tools::LogTable& log) const;

  RigScenario scenario_;
  SerialArm arm_;
  double tool_limit_mm_per_s_;
  FaultJudge faults_;
  double worst_sent_share_ = 0;
  double worst_speed_share_ = 0;
  double worst_outside_rad_ = 0;
  double worst_tool_mm_per_s_ = 0;
  double total_way_mm_ = 0;
  bool was_any_enabled_ = false;
  std::uint64_t commands_ = 0;
};

}  // namespace vergence::rig
