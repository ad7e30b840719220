#include "algo/stopping_room.hpp"

#include <algorithm>

namespace vergence {

ToolRoom stopping_room(const SerialArm& arm, const ArmJacobian& J_tool, const Vector3& tool_mm,
                       const std::array<JointMotion, kMaxJoints>& last, double period_s) {
  ToolRoom room{tool_mm, tool_mm};
  double turned = 0;   // of all joints together, at most
  double farther = 0;  // the longest column of J
  for (int i = 0; i < arm.joints; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const JointLimits& limits = arm.limits[k];
    const BrakePath path =
        brake_path(last[k].velocity_rad_per_s, last[k].acceleration_rad_per_s2 * period_s,
                   {limits.acceleration_rad_per_s2 * period_s, limits.jerk_rad_per_s3 * period_s * period_s});
    const double low = path.lowest * period_s;
    const double high = path.highest * period_s;
    const Vector3 column = J_tool.col(i).head<3>();
    room.min_mm += (column * low).cwiseMin(column * high);
    room.max_mm += (column * low).cwiseMax(column * high);
    turned += std::max(high, -low);
    farther = std::max(farther, column.norm());
  }
  // |column'| <= |column| for each rad that any joint turns: half the square of the way, as in Taylor's
  // series. Columns lengthen on the way by no more than that again.
  const Vector3 bent = Vector3::Constant(farther * turned * turned * (1 + turned) / 2);
  room.min_mm -= bent;
  room.max_mm += bent;
  return room;
}

}  // namespace vergence
