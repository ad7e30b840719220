#include "algo/pa10.hpp"

#include <numbers>

namespace vergence {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180;
constexpr double kQuarterTurn_rad = std::numbers::pi / 2;

constexpr double kBaseToShoulder_mm = 317;
constexpr double kShoulderToElbow_mm = 450;
constexpr double kElbowToWrist_mm = 480;
constexpr double kWristToFlange_mm = 70;

// The maker gives no acceleration or jerk. Ours: full speed in a quarter of a second, full acceleration in a
// tenth.
JointLimits limits(double position_deg, double velocity_rad_per_s) {
  const double acceleration_rad_s2 = velocity_rad_per_s / 0.25;
  return {-position_deg * kDegree_rad, position_deg * kDegree_rad, velocity_rad_per_s, acceleration_rad_s2,
          acceleration_rad_s2 / 0.1};
}

}  // namespace

SerialArm pa10() {
  constexpr double kWristSpeed_rad_s = 2 * std::numbers::pi;
  SerialArm arm;
  arm.joints = 7;
  arm.dh = {{{0, -kQuarterTurn_rad, kBaseToShoulder_mm, 0},
             {0, kQuarterTurn_rad, 0, 0},
             {0, -kQuarterTurn_rad, kShoulderToElbow_mm, 0},
             {0, kQuarterTurn_rad, 0, 0},
             {0, -kQuarterTurn_rad, kElbowToWrist_mm, 0},
             {0, kQuarterTurn_rad, 0, 0},
             {0, 0, kWristToFlange_mm, 0}}};
  arm.limits = {limits(177, 1),
                limits(91, 1),
                limits(174, 2),
                limits(137, 2),
                limits(255, kWristSpeed_rad_s),
                limits(165, kWristSpeed_rad_s),
                limits(255, kWristSpeed_rad_s)};
  arm.held = 1;
  arm.T_W_base.R << -1, 0, 0,  //
      0, -1, 0,                //
      0, 0, 1;
  arm.T_flange_hand.R << 0, 1, 0,  //
      -1, 0, 0,                    //
      0, 0, 1;
  return arm;
}

}  // namespace vergence
