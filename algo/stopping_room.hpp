// The last look before the bus: where can the tool get to if its joints brake from here on, each as its own
// limits allow? What the hand's limits (hand_limits) plan in space, joints that are at their limits may not
// follow; joints that brake one by one leave the line. If the answer is not inside the box, the joints brake
// now, while it still is.
#pragma once

#include <array>

#include "algo/arm_kinematics.hpp"
#include "algo/motion_limits.hpp"

namespace vergence {

struct ToolRoom {
  Vector3 min_mm = Vector3::Zero();
  Vector3 max_mm = Vector3::Zero();
};

// Of the tool's point, in W. `last`: the joints' motions as commanded, the tool being at tool_mm when they
// are at those positions; J_tool: of that point, in W, [mm; rad] a rad. To the second order: how the columns
// of J turn on the way is bounded, not followed.
[[nodiscard]] ToolRoom stopping_room(const SerialArm& arm, const ArmJacobian& J_tool, const Vector3& tool_mm,
                                     const std::array<JointMotion, kMaxJoints>& last, double period_s);

}  // namespace vergence
