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
#include "tools/rig/rig_scenario.hpp"
#include "tools/rig/rig_world.hpp"

namespace vergence::rig {

struct RigRow {
  double t_s = 0;
  double tool_mm_per_s = 0;  // largest since the row before
  int faults = 0;            // under way
  std::uint64_t pictures = 0;
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
  struct Verdict {
    double still_since_s = -1;    // after the fault; -1: not yet
    double moved_again_s = -1;    // after it was still in time, without being asked to
    double fastest_mm_per_s = 0;  // from the time on that it had
    double moving_mm_per_s = 0;   // when the fault came
    bool was_enabled = false;     // when the fault came
    bool was_disabled = false;    // since
    int rest_rows = 0;            // while it is to rest
    int searching_rows = 0;       // of them, in which the controller searched and believed in nothing
    double again_s = -1;          // after the end, until the tool moved; -1: not yet
  };
  [[nodiscard]] double end_of(std::size_t fault) const;
  void watch_rest(const FaultEvent& fault, Verdict& verdict, double t_s, double tool_mm_per_s,
                  const ControllerView& controller) const;
  static void add_rest(std::vector<tools::Metric>& metrics, const std::string& name, const FaultEvent& fault,
                       const Verdict& verdict);

  RigScenario scenario_;
  SerialArm arm_;
  double tool_limit_mm_per_s_;
  std::vector<Verdict> verdicts_;
  double worst_sent_share_ = 0;
  double worst_speed_share_ = 0;
  double worst_outside_rad_ = 0;
  double worst_tool_mm_per_s_ = 0;
  double total_way_mm_ = 0;
};

}  // namespace vergence::rig
