// Forward kinematics and Jacobian against Orocos KDL: the PA-10 and arms nobody has built.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "algo/pa10.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::RandomArm;

KDL::Frame to_kdl(const Transform& T) {
  const Matrix3& R = T.R;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(T.t_mm[0], T.t_mm[1], T.t_mm[2])};
}

// Segment 0 is the base, 1 to n the links, n + 1 the tool.
KDL::Chain to_chain(const SerialArm& arm) {
  KDL::Chain chain;
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), to_kdl(arm.T_W_base)));
  for (std::size_t i = 0; i < static_cast<std::size_t>(arm.joints); ++i) {
    const DhRow& row = arm.dh[i];
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ),
                                  KDL::Frame::DH(row.a_mm, row.alpha_rad, row.d_mm, row.theta_offset_rad)));
  }
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), to_kdl(arm.T_flange_hand)));
  return chain;
}

double largest_difference(const Transform& T, const KDL::Frame& F) {
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    largest = std::max(largest, std::fabs(T.t_mm[i] - F.p(i)));
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::fabs(T.R(i, j) - F.M(i, j)));
  }
  return largest;
}

class Oracle {
 public:
  explicit Oracle(const SerialArm& arm)
      : arm_(arm), chain_(to_chain(arm)), position_(chain_), jacobian_(chain_) {}

  void compare(const JointVector& q) {
    const auto n = static_cast<unsigned>(arm_.joints);
    KDL::JntArray joints(n);
    for (int i = 0; i < arm_.joints; ++i) joints(static_cast<unsigned>(i)) = q[i];
    const ArmFrames frames = forward_kinematics(arm_, q);
    for (unsigned i = 0; i <= n + 1; ++i) {
      KDL::Frame F;
      ASSERT_GE(position_.JntToCart(joints, F, static_cast<int>(i) + 1), 0);
      largest_pose =
          std::max(largest_pose, largest_difference(i <= n ? frames.T_W_joint[i] : frames.T_W_H, F));
    }
    KDL::Jacobian J(n);
    ASSERT_GE(jacobian_.JntToJac(joints, J), 0);
    const ArmJacobian ours = geometric_jacobian(arm_, frames);
    for (int j = 0; j < kMaxJoints; ++j) {
      for (int i = 0; i < 6; ++i) {
        const double theirs = j < arm_.joints ? J(static_cast<unsigned>(i), static_cast<unsigned>(j)) : 0;
        largest_jacobian = std::max(largest_jacobian, std::fabs(ours(i, j) - theirs));
      }
    }
  }

  double largest_pose = 0;      // mm, or of a direction cosine
  double largest_jacobian = 0;  // mm or rad, per rad

 private:
  const SerialArm& arm_;
  KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive position_;
  KDL::ChainJntToJacSolver jacobian_;
};

TEST(ArmKdl, Pa10Agrees) {
  SerialArm arm = pa10();
  arm.held = 0;
  Oracle oracle(arm);
  RandomArm random(1);
  for (int n = 0; n < 100000; ++n) ASSERT_NO_FATAL_FAILURE(oracle.compare(random.angles(arm)));
  EXPECT_LT(oracle.largest_pose, 1e-9);
  EXPECT_LT(oracle.largest_jacobian, 1e-9);
  RecordProperty("worst_pose_fm", std::to_string(oracle.largest_pose * 1e12));
  RecordProperty("worst_jacobian_fm_per_rad", std::to_string(oracle.largest_jacobian * 1e12));
}

TEST(ArmKdl, AnySerialArmAgrees) {
  RandomArm random(2);
  double worst = 0;
  for (int n = 0; n < 5000; ++n) {
    const SerialArm arm = random.arm(4 + n % 4);
    ASSERT_EQ(validate(arm), Status::kOk);
    Oracle oracle(arm);
    for (int k = 0; k < 20; ++k) ASSERT_NO_FATAL_FAILURE(oracle.compare(random.angles(arm)));
    ASSERT_LT(oracle.largest_pose, 1e-9) << n;
    ASSERT_LT(oracle.largest_jacobian, 1e-9) << n;
    worst = std::max({worst, oracle.largest_pose, oracle.largest_jacobian});
  }
  RecordProperty("worst_fm", std::to_string(worst * 1e12));
}

}  // namespace
}  // namespace vergence
