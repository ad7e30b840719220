#include "tools/demo/loop_log.hpp"

#include <limits>
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace vergence::demo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> column_names() {
  std::vector<std::string> names = {"t_s", "mode"};
  const auto pose = [&names](const std::string& of) {
    for (const char* part : {"_x_mm", "_y_mm", "_z_mm", "_e1", "_e2", "_e3"}) names.push_back(of + part);
  };
  pose("target");    // the truth
  pose("hand");      // the truth
  pose("wanted");    // of the hand, by the truth of the target
  pose("believed");  // of the target, by the controller
  for (const char* part : {"gaze_x_mm", "gaze_y_mm", "gaze_z_mm"}) names.emplace_back(part);
  // Of a frame that was looked at since the row before: the target in the hand when it was exposed.
  names.emplace_back("frame");
  names.emplace_back("frame_stamp_s");
  pose("seen");
  pose("true");
  for (const char* part : {"fitness", "confidence", "state", "generations"}) names.emplace_back(part);
  for (const char* part : {"q1_rad", "q2_rad", "q3_rad", "q4_rad", "q5_rad", "q6_rad", "q7_rad"}) {
    names.emplace_back(part);
  }
  for (const char* part : {"sent1_rad_per_s", "sent2_rad_per_s", "sent3_rad_per_s", "sent4_rad_per_s",
                           "sent5_rad_per_s", "sent6_rad_per_s", "sent7_rad_per_s"}) {
    names.emplace_back(part);
  }
  for (const char* part :
       {"tilt_rad", "pan_right_rad", "pan_left_rad", "lost_tilt_steps", "lost_right_steps", "lost_left_steps",
        "hand_limits", "joint_limits", "eye_limits", "smallest_singular_value"}) {
    names.emplace_back(part);
  }
  return names;
}

class Row {
 public:
  void add(double value) { values_.push_back(value); }
  void add(const Transform& T) {
    const Pose pose = to_pose(T);
    for (int i = 0; i < 3; ++i) add(pose.position_mm[i]);
    for (int i = 0; i < 3; ++i) add(pose.e[i]);
  }
  void none(int count) { values_.insert(values_.end(), static_cast<std::size_t>(count), kNaN); }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
};

}  // namespace

LoopLog::LoopLog() : table_(column_names()) {}

void LoopLog::add(const plant::World& world, const Pipeline& pipeline, const Transform& T_W_S,
                  const DesiredRelation& relation, const std::optional<SeenFrame>& frame) {
  const ArmPeriod& arm = pipeline.arm_period();
  const Transform T_S_W = T_W_S.inverse();
  const double t_s = seconds(world.now_ns());
  const Transform T_S_M = T_S_W * world.T_W_M(t_s);
  Row row;
  row.add(t_s);
  row.add(static_cast<double>(arm.mode));
  const Transform T_S_H = T_S_W * world.T_W_H();
  row.add(T_S_M);
  row.add(T_S_H);
  if (relation.position_only) {
    row.add(Transform{T_S_H.R, T_S_M.t_mm - T_S_H.R * relation.T_Ed_M.t_mm});
  } else {
    row.add(T_S_M * relation.T_Ed_M.inverse());
  }
  arm.target_believed ? row.add(T_S_W * arm.target.T_W_M) : row.none(6);
  if (const auto gaze = world.gaze_point_W_mm()) {
    const Vector3 p = T_S_W * *gaze;
    for (int i = 0; i < 3; ++i) row.add(p[i]);
  } else {
    row.none(3);
  }
  if (frame) {
    const Sighting& sighting = frame->sighting;
    row.add(static_cast<double>(sighting.sequence));
    row.add(seconds(sighting.stamp_ns));
    row.add(sighting.T_H_M);
    row.add(frame->true_T_H_M);
    row.add(sighting.estimate.fitness);
    row.add(sighting.estimate.confidence);
    row.add(static_cast<double>(sighting.estimate.state));
    row.add(sighting.estimate.generations);
  } else {
    row.none(18);
  }
  const bool has_arm = world.has_arm();
  for (std::size_t i = 0; i < kMaxJoints; ++i) row.add(has_arm ? world.joints_rad()[i] : kNaN);
  for (std::size_t i = 0; i < kMaxJoints; ++i) row.add(has_arm ? arm.hand.velocity_rad_per_s[i] : kNaN);
  const EyeAngles eyes = world.eye_angles();
  row.add(eyes.tilt_rad);
  row.add(eyes.pan_right_rad);
  row.add(eyes.pan_left_rad);
  for (int i = 0; i < kPanTiltMotors; ++i) row.add(world.lost_steps(i));
  row.add(arm.hand.hand_flags);
  row.add(arm.hand.joint_flags);
  LimitFlags eye_flags = 0;
  for (const LimitFlags flags : pipeline.eye_command().flags) eye_flags |= flags;
  row.add(eye_flags);
  row.add(arm.hand.smallest_singular_value);
  table_.append(row.values());
}

}  // namespace vergence::demo
