#include "algo/stopping_room.hpp"

#include <algorithm>

namespace vergence {
namespace {

// What Taylor's series of the tool's place leaves out after the first order, at most, where no joint turns
// farther than its way. The second derivative by joints i and j, j the nearer to the hand, is axis i x column
// j: no longer than column j. A column keeps its length while joints before its own turn, and each behind it
// lengthens it by its way times its own column at most.
double bend(const SerialArm& arm, const ArmJacobian& J_tool, const std::array<double, kMaxJoints>& way) {
  double sum = 0;
  double lengthened = 0;  // of the columns before, by the joints behind
  double before = 0;      // ways of the joints before
  for (const double w : way) before += w;
  for (int j = arm.joints - 1; j >= 0; --j) {
    const double w = way[static_cast<std::size_t>(j)];
    const double column = J_tool.col(j).head<3>().norm() + lengthened;
    before -= w;
    sum += column * w * (w / 2 + std::max(before, 0.0));
    lengthened += column * w;
  }
  return sum;
}

}  // namespace

ToolRoom stopping_room(const SerialArm& arm, const ArmJacobian& J_tool, const Vector3& tool_mm,
                       const std::array<JointMotion, kMaxJoints>& last, double period_s) {
  ToolRoom room{tool_mm, tool_mm};
  std::array<double, kMaxJoints> way{};  // at most, either way
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
    way[k] = std::max(high, -low);
  }
  const Vector3 bent = Vector3::Constant(bend(arm, J_tool, way));
  room.min_mm -= bent;
  room.max_mm += bent;
  return room;
}

}  // namespace vergence
