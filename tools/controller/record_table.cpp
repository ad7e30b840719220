#include "tools/controller/record_table.hpp"

#include <array>

namespace vergence::tools {
namespace {

// One pass names the columns and takes the values, so that they cannot get out of step.
class Row {
 public:
  void add(const std::string& name, double value) {
    names.push_back(name);
    values.push_back(value);
  }
  template <typename T, std::size_t kCount>
  void add(const std::string& name, const std::array<T, kCount>& list) {
    for (std::size_t i = 0; i < kCount; ++i)
      add(name + "_" + std::to_string(i + 1), static_cast<double>(list[i]));
  }
  void add(const std::string& name, const PoseRecord& pose) {
    constexpr std::array<const char*, 3> kAxes = {"_x_mm", "_y_mm", "_z_mm"};
    constexpr std::array<const char*, 3> kParts = {"_e1", "_e2", "_e3"};
    for (std::size_t i = 0; i < 3; ++i) add(name + kAxes[i], pose.position_mm[i]);
    for (std::size_t i = 0; i < 3; ++i) add(name + kParts[i], pose.e[i]);
  }
  std::vector<std::string> names;
  std::vector<double> values;
};

double number(std::uint64_t value) {
  return static_cast<double>(value);
}

Row row_of(const TelemetryRecord& r) {
  Row row;
  row.add("t_s", static_cast<double>(r.t_ns) * 1e-9);
  row.add("period", number(r.period));
  row.add("mode_number", r.mode);
  row.add("arm_state", r.arm_state);
  row.add("arm_fault", r.arm_fault);
  row.add("arm_request", r.arm_request);
  row.add("q_rad", r.joint_rad);
  row.add("dq_rad_per_s", r.joint_rad_per_s);
  row.add("command_rad_per_s", r.command_rad_per_s);
  row.add("hand", r.T_W_H);
  row.add("hand_limits", r.hand_limits);
  row.add("joint_limits", r.joint_limits);
  row.add("smallest_singular_value", r.smallest_singular_value);
  row.add("target_believed", r.target_believed);
  row.add("target", r.T_W_M);
  row.add("track_state", r.track_state);
  row.add("sighting", number(r.sighting));
  row.add("sighting_s", static_cast<double>(r.sighting_stamp_ns) * 1e-9);
  row.add("seen", r.T_H_M);
  row.add("fitness", r.fitness);
  row.add("confidence", r.confidence);
  row.add("camera_state", r.camera_state);
  row.add("eyes_state", r.eyes_state);
  row.add("eye_steps", r.eye_steps);
  row.add("frames_left_out", number(r.frames_left_out));
  row.add("late_frames", number(r.late_frames));
  row.add("mode_changes", number(r.mode_changes));
  row.add("last_event", r.last_event);
  for (std::size_t i = 0; i < kTaskCount; ++i) {
    const std::string name = kTasks[i].name;
    const TaskRecord& task = r.tasks[i];
    row.add(name + "_worst_latency_us", static_cast<double>(task.worst_latency_ns) * 1e-3);
    row.add(name + "_worst_execution_us", static_cast<double>(task.worst_execution_ns) * 1e-3);
    row.add(name + "_runs", number(task.runs));
    row.add(name + "_slips", number(task.slips));
    row.add(name + "_misses", number(task.misses));
    row.add(name + "_page_faults", number(task.page_faults));
  }
  return row;
}

}  // namespace

const std::vector<std::string>& record_columns() {
  static const std::vector<std::string> columns = row_of({}).names;
  return columns;
}

std::vector<double> record_values(const TelemetryRecord& record) {
  return row_of(record).values;
}

}  // namespace vergence::tools
