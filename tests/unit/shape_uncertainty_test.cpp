// What a shape leaves open of a pose: less the more is known and the better it fits, mostly along the model's
// own axis; and carried into the pose as drawn increments scatter.
#include "algo/shape_uncertainty.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "algo/pose_covariance.hpp"
#include "algo/rotation_vector.hpp"

namespace vergence {
namespace {

constexpr ShapeKnowledge kAll[]{ShapeKnowledge::kNone, ShapeKnowledge::kYoungRelief, ShapeKnowledge::kRelief};

TEST(ShapeUncertainty, GrowsWithTheMisfit) {
  for (const ShapeKnowledge knowledge : kAll) {
    for (double misfit = 0; misfit < 1; misfit += 0.01) {
      const Vector6 less = shape_deviation(knowledge, misfit);
      const Vector6 more = shape_deviation(knowledge, misfit + 0.01);
      EXPECT_TRUE((less.array() >= 0).all()) << misfit;
      EXPECT_TRUE((more.array() >= less.array()).all()) << misfit;
      EXPECT_GT(more[2], less[2]) << misfit;
    }
  }
}

TEST(ShapeUncertainty, IsOfDepthAndTiltMoreThanOfPlaceAndTurn) {
  for (const ShapeKnowledge knowledge : kAll) {
    const Vector6 deviation = shape_deviation(knowledge, 0.25);
    EXPECT_GT(deviation[2], 3 * deviation[0]);
    EXPECT_GT(deviation[3], 3 * deviation[5]);
    EXPECT_EQ(deviation[0], deviation[1]);
    EXPECT_EQ(deviation[3], deviation[4]);
  }
}

TEST(ShapeUncertainty, ShrinksAsTheReliefIsLearned) {
  for (const double misfit : {0.05, 0.15, 0.3, 0.6}) {
    const Vector6 young = shape_deviation(ShapeKnowledge::kYoungRelief, misfit);
    const Vector6 learned = shape_deviation(ShapeKnowledge::kRelief, misfit);
    EXPECT_TRUE((young.array() > learned.array()).all()) << misfit;
  }
}

// A flat target whose eyes agree is known as it is.
TEST(ShapeUncertainty, IsNoneWhereAFlatModelFitsExactly) {
  EXPECT_EQ(shape_deviation(ShapeKnowledge::kNone, 0), Vector6::Zero());
}

TEST(ShapeUncertainty, ScattersThePoseAsDrawnIncrementsDo) {
  const Transform T_H_M = to_transform({{20, -40, 450}, {0.3, -0.2, 0.1}});
  const Vector6 deviation = shape_deviation(ShapeKnowledge::kRelief, 0.2);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 20000;
  Matrix6 scatter = Matrix6::Zero();
  const Pose pose = to_pose(T_H_M);
  for (int draw = 0; draw < kDraws; ++draw) {
    Vector6 increment;
    for (int k = 0; k < 6; ++k) increment[k] = deviation[k] * normal(random);
    const Transform moved = T_H_M * Transform{rotation_from_vector(increment.tail<3>()), increment.head<3>()};
    const Pose there = to_pose(moved);
    Vector6 off;
    off << there.position_mm - pose.position_mm, there.e - pose.e;
    scatter += off * off.transpose() / kDraws;
  }
  const Matrix6 stated = pose_covariance(deviation, T_H_M);
  EXPECT_EQ(stated, stated.transpose());
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const double unit = std::sqrt(stated(i, i) * stated(j, j));
      EXPECT_NEAR(scatter(i, j) / unit, stated(i, j) / unit, 0.05) << i << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace vergence
