// Arms of any make: what is refused, joint velocities by damped least squares, singular poses.
#include "algo/arm_kinematics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <numbers>

#include "algo/damped_velocity.hpp"
#include "algo/pa10.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

using testing::RandomArm;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vector6 any_twist(RandomArm& random) {
  Vector6 twist;
  twist << random.vector(200), random.vector(1);
  return twist;
}

TEST(ArmKinematics, ValidationRefusesWhatIsNoArm) {
  EXPECT_EQ(validate(pa10()), Status::kOk);
  const auto refused = [](auto spoil) {
    SerialArm arm = pa10();
    spoil(arm);
    return validate(arm) == Status::kBadArm;
  };
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.joints = 0; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.joints = 8; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.held = 0x7F; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.held = 0x80; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.dh[6].d_mm = kNaN; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.dh[3].a_mm = kInfinity; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.dh[0].alpha_rad = 11; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.limits[1].min_rad = 2; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.limits[1].max_rad = 51; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.limits[2].velocity_rad_per_s = 0; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.limits[2].acceleration_rad_per_s2 = kNaN; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.limits[2].jerk_rad_per_s3 = -1; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.T_W_base.R(0, 0) = 1; }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.T_W_base.R = -Matrix3::Identity(); }));
  EXPECT_TRUE(refused([](SerialArm& arm) { arm.T_flange_hand.t_mm[2] = kNaN; }));
}

TEST(ArmKinematics, AnglesOutOfRangeAreTold) {
  const SerialArm arm = pa10();
  JointVector q = JointVector::Zero();
  EXPECT_TRUE(are_joint_angles(arm, q));
  for (const double angle : {kNaN, kInfinity, -kInfinity, 50.1}) {
    q[4] = angle;
    EXPECT_FALSE(are_joint_angles(arm, q)) << angle;
  }
  q[4] = 1e300;  // defined, though it is not an angle
  EXPECT_TRUE(std::isnan(forward_kinematics(arm, q).T_W_H.t_mm[0]));
}

TEST(ArmKinematics, NearestTurnKeepsToLimits) {
  const JointLimits wide{-4.5, 4.5, 1, 1, 1};
  EXPECT_NEAR(nearest_turn(3, -3, wide), 3 - 2 * kPi, 1e-15);
  EXPECT_NEAR(nearest_turn(-3, 4, wide), -3 + 2 * kPi, 1e-15);
  EXPECT_NEAR(nearest_turn(1, 4.4, wide), 1, 1e-15);       // 1 + 2 pi is out
  EXPECT_NEAR(nearest_turn(0.5, -4.4, wide), 0.5, 1e-15);  // so is 0.5 - 2 pi
  EXPECT_NEAR(nearest_turn(3, 20, wide), 3, 1e-14);        // from far out
  EXPECT_NEAR(nearest_turn(3, -20, wide), 3 - 2 * kPi, 1e-14);
  const JointLimits narrow{-1, 1, 1, 1, 1};
  EXPECT_NEAR(nearest_turn(2, 2.5, narrow), 2, 1e-15);  // nothing within: the nearest
  EXPECT_FALSE(is_within(nearest_turn(2, 2.5, narrow), narrow));
}

TEST(SymmetricEigen, AgreesWithEigen) {
  RandomArm random(1);
  for (int n = 0; n < 20000; ++n) {
    // Of every rank, and of magnitudes as different as those of an arm.
    Matrix6 B = Matrix6::Zero();
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < n % 7; ++j) B(i, j) = random.between(-1, 1) * (i < 3 ? 1.0 : 1e-3);
    }
    const Matrix6 A = B * B.transpose();
    const auto [values, V] = symmetric_eigen(A);
    ASSERT_LT((V * values.asDiagonal() * V.transpose() - A).cwiseAbs().maxCoeff(), 1e-13);
    ASSERT_LT((V * V.transpose() - Matrix6::Identity()).cwiseAbs().maxCoeff(), 1e-13);
    Vector6 sorted = values;
    std::sort(sorted.data(), sorted.data() + 6);
    const Vector6 oracle = Eigen::SelfAdjointEigenSolver<Matrix6>(A).eigenvalues();
    ASSERT_LT((sorted - oracle).cwiseAbs().maxCoeff(), 1e-13);
  }
}

// Where no singular value is below the floor, nothing is damped: the pseudo-inverse, to rounding.
TEST(DampedVelocity, IsThePseudoInverseAwayFromSingularPoses) {
  RandomArm random(2);
  int compared = 0;
  for (int n = 0; n < 20000; ++n) {
    const SerialArm arm = n % 2 == 0 ? pa10() : random.arm(4 + n / 2 % 4);
    const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, random.angles(arm)));
    const Vector6 twist = any_twist(random);
    const VelocityStep step = damped_joint_velocity(arm, J, twist);
    ASSERT_EQ(step.status, Status::kOk);
    ArmJacobian S = J;
    S.topRows<3>() /= Damping{}.length_mm;
    Vector6 scaled = twist;
    scaled.head<3>() /= Damping{}.length_mm;
    if (arm.held != 0) S.col(0).setZero();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(S, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const int rank = std::min(arm.held != 0 ? arm.joints - 1 : arm.joints, 6);
    ASSERT_NEAR(step.smallest_singular_value, svd.singularValues()[rank - 1], 1e-7) << n;
    double product = 1;
    for (int i = 0; i < rank; ++i) product *= svd.singularValues()[i];
    ASSERT_NEAR(manipulability(scale(arm, J, arm.held, Damping{}.length_mm)), product, 1e-6 * (1 + product));
    if (step.smallest_singular_value < Damping{}.singular_value_floor) continue;
    ++compared;
    Eigen::VectorXd oracle = Eigen::VectorXd::Zero(kMaxJoints);
    for (int i = 0; i < rank; ++i) {
      oracle += svd.matrixV().col(i) * svd.matrixU().col(i).dot(scaled) / svd.singularValues()[i];
    }
    ASSERT_LT((step.velocity_rad_per_s - oracle).cwiseAbs().maxCoeff(), 1e-9) << n;
    if (rank == 6) {
      ASSERT_LT((J * step.velocity_rad_per_s - twist).norm(), 1e-9) << n;
    }
  }
  EXPECT_GT(compared, 10000);
}

TEST(DampedVelocity, NeverExceedsTheTwistOverTheFloor) {
  const SerialArm arm = pa10();
  RandomArm random(3);
  for (int n = 0; n < 20000; ++n) {
    JointVector q = random.angles(arm);
    const double near_zero = std::ldexp(random.between(-1, 1), -n % 60);
    if (n % 3 != 0) q[3] = near_zero;  // elbow straight
    if (n % 3 != 1) q[5] = near_zero;  // wrist aligned
    if (n % 7 == 0) q[1] = q[2] = near_zero;
    const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
    const Vector6 twist = any_twist(random);
    const Damping damping;
    const VelocityStep step = damped_joint_velocity(arm, J, twist, damping);
    Vector6 scaled = twist;
    scaled.head<3>() /= damping.length_mm;
    ASSERT_EQ(step.velocity_rad_per_s[0], 0);
    ASSERT_LE(step.velocity_rad_per_s.norm(), scaled.norm() / damping.singular_value_floor * (1 + 1e-9));
  }
}

// Through a straight elbow and an aligned wrist, the answer changes no faster than the arm moves.
TEST(DampedVelocity, IsContinuousThroughSingularPoses) {
  const SerialArm arm = pa10();
  Vector6 twist;
  twist << 30, -20, 50, 0.1, 0.2, -0.1;
  for (const int joint : {3, 5}) {
    JointVector q;
    q << 0, 0.4, 0.3, 1.2, 0.5, 0.7, -0.2;
    JointVector before = JointVector::Zero();
    constexpr double kStep_rad = 1e-5;
    for (int n = -30000; n <= 30000; ++n) {
      q[joint] = n * kStep_rad;
      const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
      const JointVector now = damped_joint_velocity(arm, J, twist).velocity_rad_per_s;
      if (n > -30000) {
        ASSERT_LT((now - before).norm(), 2e-3) << joint << " " << q[joint];
      }
      before = now;
    }
  }
}

// A direction that is lost does not spoil the others: at a straight elbow the hand still turns as asked.
TEST(DampedVelocity, FollowsExactlyWhatTheArmCanDo) {
  const SerialArm arm = pa10();
  JointVector q;
  q << 0, 0.4, 0.3, 0, 0.5, 0.7, -0.2;
  const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, q));
  JointVector possible;
  possible << 0, 0.2, -0.1, 0.3, 0.1, 0.2, 0.3;
  const Vector6 twist = J * possible;
  const VelocityStep step = damped_joint_velocity(arm, J, twist);
  EXPECT_LT(step.smallest_singular_value, 1e-7);
  EXPECT_LT((J * step.velocity_rad_per_s - twist).norm(), 1e-9);
}

TEST(DampedVelocity, RefusesWhatIsNotFinite) {
  const SerialArm arm = pa10();
  const ArmJacobian J = geometric_jacobian(arm, forward_kinematics(arm, JointVector::Zero()));
  for (const double bad : {kNaN, kInfinity, -kInfinity, 1e10}) {
    for (int i = 0; i < 6; ++i) {
      Vector6 twist = Vector6::Ones();
      twist[i] = bad;
      const VelocityStep step = damped_joint_velocity(arm, J, twist);
      EXPECT_EQ(step.status, Status::kBadNumber);
      EXPECT_EQ(step.velocity_rad_per_s, JointVector::Zero());
      ArmJacobian spoilt = J;
      spoilt(i, 3) = bad;
      EXPECT_EQ(damped_joint_velocity(arm, spoilt, Vector6::Ones()).status, Status::kBadNumber);
    }
    EXPECT_EQ(damped_joint_velocity(arm, J, Vector6::Ones(), {300, bad}).status, Status::kBadNumber);
    EXPECT_EQ(damped_joint_velocity(arm, J, Vector6::Ones(), {bad, 0.05}).status, Status::kBadNumber);
  }
}

}  // namespace
}  // namespace vergence
