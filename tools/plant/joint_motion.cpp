#include "tools/plant/joint_motion.hpp"

#include <algorithm>
#include <cmath>

#include "tools/plant/decay.hpp"

namespace vergence::plant {
namespace {

void accelerate(JointState& joint, double acceleration_rad_per_s2, double dt_s) {
  joint.position_rad += (joint.velocity_rad_per_s + 0.5 * acceleration_rad_per_s2 * dt_s) * dt_s;
  joint.velocity_rad_per_s += acceleration_rad_per_s2 * dt_s;
}

}  // namespace

void follow(const JointDrive& drive, double command_rad_per_s, double load_rad_per_s2, double dt_s,
            JointState& joint) {
  const double error = command_rad_per_s - joint.velocity_rad_per_s;
  const double excess = std::abs(error) - drive.acceleration_rad_per_s2 * drive.time_constant_s;
  if (excess > 0) {
    const double direction = std::copysign(1.0, error);
    const double limited_s =
        std::min(dt_s, excess / (drive.acceleration_rad_per_s2 + direction * load_rad_per_s2));
    accelerate(joint, direction * drive.acceleration_rad_per_s2 + load_rad_per_s2, limited_s);
    dt_s -= limited_s;
  }
  const double final_rad_per_s = command_rad_per_s + load_rad_per_s2 * drive.time_constant_s;
  const double away_rad_per_s = joint.velocity_rad_per_s - final_rad_per_s;
  const double remains = decay(dt_s / drive.time_constant_s);
  joint.position_rad += final_rad_per_s * dt_s + away_rad_per_s * drive.time_constant_s * (1 - remains);
  joint.velocity_rad_per_s = final_rad_per_s + away_rad_per_s * remains;
}

void brake(const JointDrive& drive, double load_rad_per_s2, double dt_s, JointState& joint) {
  const double speed = std::abs(joint.velocity_rad_per_s);
  if (speed == 0) return;
  const double direction = std::copysign(1.0, joint.velocity_rad_per_s);
  const double to_rest_s = speed / (drive.quick_stop_rad_per_s2 - direction * load_rad_per_s2);
  accelerate(joint, load_rad_per_s2 - direction * drive.quick_stop_rad_per_s2, std::min(dt_s, to_rest_s));
  if (to_rest_s <= dt_s) joint.velocity_rad_per_s = 0;
}

bool is_usable(const JointDrive& drive, double start_rad) {
  for (const double number : {drive.velocity_rad_per_s, drive.acceleration_rad_per_s2,
                              drive.quick_stop_rad_per_s2, drive.time_constant_s, drive.counts_per_rad}) {
    if (!(number > 0) || !std::isfinite(number)) return false;
  }
  return drive.min_rad <= start_rad && start_rad <= drive.max_rad;
}

bool keep_between_stops(const JointDrive& drive, JointState& joint) {
  const double inside_rad = std::clamp(joint.position_rad, drive.min_rad, drive.max_rad);
  if (inside_rad == joint.position_rad) return false;
  if ((joint.position_rad - inside_rad) * joint.velocity_rad_per_s > 0) joint.velocity_rad_per_s = 0;
  joint.position_rad = inside_rad;
  return true;
}

}  // namespace vergence::plant
