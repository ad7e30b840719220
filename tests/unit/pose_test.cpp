// Pose algebra: the quaternion-vector parametrisation, transforms and their inverses.
#include "algo/pose.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>

namespace vergence {
namespace {

// A random rotation's quaternion vector, uniform direction, any angle up to a half turn.
Vector3 any_quaternion_vector() {
  const auto component = [] { return static_cast<double>(*rc::gen::inRange(-1000000, 1000001)) / 1e6; };
  Vector3 e{component(), component(), component()};
  const double limit = static_cast<double>(*rc::gen::inRange(0, 1000001)) / 1e6;
  const double norm = e.norm();
  return norm > 0 ? Vector3(e / norm * limit) : e;
}

Vector3 any_position() {
  const auto component = [] { return static_cast<double>(*rc::gen::inRange(-1000000, 1000001)) / 1e3; };
  return {component(), component(), component()};
}

TEST(Pose, RotationAgreesWithEigenGeometry) {
  ASSERT_TRUE(rc::check([] {
    const Vector3 e = any_quaternion_vector();
    const double eta = std::sqrt(std::fmax(0.0, 1 - e.squaredNorm()));
    const Matrix3 oracle = Eigen::Quaterniond(eta, e[0], e[1], e[2]).normalized().toRotationMatrix();
    RC_ASSERT((rotation_from_quaternion_vector(e) - oracle).norm() < 1e-9);
  }));
}

TEST(Pose, RotationIsOrthonormal) {
  ASSERT_TRUE(rc::check([] {
    const Matrix3 R = rotation_from_quaternion_vector(any_quaternion_vector() * 2);  // also beyond length 1
    RC_ASSERT((R * R.transpose() - Matrix3::Identity()).norm() < 1e-12);
    RC_ASSERT(std::abs(R.determinant() - 1) < 1e-12);
  }));
}

TEST(Pose, QuaternionVectorRoundTrip) {
  ASSERT_TRUE(rc::check([] {
    const Matrix3 R = rotation_from_quaternion_vector(any_quaternion_vector());
    // A half turn has two vectors of opposite sign, so rotations are compared, not vectors.
    RC_ASSERT((rotation_from_quaternion_vector(quaternion_vector_from_rotation(R)) - R).norm() < 1e-7);
  }));
}

TEST(Pose, ProductOfQuaternionVectorsIsProductOfRotations) {
  ASSERT_TRUE(rc::check([] {
    const Vector3 a = any_quaternion_vector();
    const Vector3 b = any_quaternion_vector();
    const Matrix3 product = rotation_from_quaternion_vector(a) * rotation_from_quaternion_vector(b);
    RC_ASSERT((rotation_from_quaternion_vector(multiply_quaternion_vectors(a, b)) - product).norm() < 1e-6);
  }));
}

TEST(Pose, TransformTimesInverseIsIdentity) {
  ASSERT_TRUE(rc::check([] {
    const Transform T = to_transform({any_position(), any_quaternion_vector()});
    const Transform I = T * T.inverse();
    RC_ASSERT((I.R - Matrix3::Identity()).norm() < 1e-12);
    RC_ASSERT(I.t_mm.norm() < 1e-8);
    const Vector3 p = any_position();
    RC_ASSERT((T.inverse() * (T * p) - p).norm() < 1e-8);
  }));
}

TEST(Pose, JacobianIsThatOfSmallIncrements) {
  ASSERT_TRUE(rc::check([] {
    const Transform T = to_transform({any_position(), any_quaternion_vector() * 0.9});
    const Matrix6 J = pose_jacobian(T);
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 6; ++k) {
      Vector6 d = Vector6::Zero();
      d[k] = kStep;
      const Transform moved = T * Transform{rotation_from_quaternion_vector(d.tail<3>() / 2), d.head<3>()};
      const Pose a = to_pose(T);
      const Pose b = to_pose(moved);
      Vector6 change;
      change << b.position_mm - a.position_mm, b.e - a.e;
      RC_ASSERT((change / kStep - J.col(k)).norm() < 1e-3);
    }
  }));
}

TEST(Pose, ValidityRejectsWhatIsNotAPose) {
  EXPECT_TRUE(is_valid({{1, 2, 3}, {0.1, 0.2, 0.3}}));
  EXPECT_FALSE(is_valid({{1, 2, 3}, {0.9, 0.9, 0.3}}));
  EXPECT_FALSE(is_valid({{std::nan(""), 2, 3}, {0, 0, 0}}));
  EXPECT_FALSE(is_valid({{1, 2, 3}, {0, INFINITY, 0}}));
}

}  // namespace
}  // namespace vergence
