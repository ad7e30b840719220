// Which points of a target an eye sees: against a sphere, of which the eye sees a point where nothing of the
// sphere lies on the way to it.
#include "algo/facing-inl.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "algo/relief.hpp"
#include "algo/rm_ga.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

constexpr double kRadius_mm = 40;

// How much of a say the first four points have in a camera that stands at the origin.
HWY_ATTR std::array<float, kLanes> faces(const SurfaceNormals& normals, const Transform& T_C_M) {
  alignas(16) std::array<float, kLanes> result;
  hn::Store(Facing(T_C_M).of(normals, 0), d4, result.data());
  return result;
}

double within(CounterRandom& random, double half) {
  return half * (2 * static_cast<double>(random.next() >> 11) / 9007199254740992.0 - 1);
}

Vector3 direction(CounterRandom& random) {
  Vector3 v;
  do {
    v = {within(random, 1), within(random, 1), within(random, 1)};
  } while (v.squaredNorm() > 1 || v.squaredNorm() < 0.01);
  return v.normalized();
}

// Whether the way from a point of the sphere to an eye leads through the sphere.
bool is_hidden(const Vector3& point_mm, const Vector3& eye_mm) {
  const Vector3 nearer_eye = point_mm + 0.01 * (eye_mm - point_mm);
  return nearer_eye.norm() < kRadius_mm;
}

void set_point(const Vector3& point_mm, unsigned i, SurfaceNormals& normals) {
  const Vector3 n = point_mm.normalized();
  normals.x[i] = static_cast<float>(n[0]);
  normals.y[i] = static_cast<float>(n[1]);
  normals.z[i] = static_cast<float>(n[2]);
  normals.reach_mm[i] = static_cast<float>(n.dot(point_mm));
}

TEST(Facing, IsWhatAnEyeSeesOfASphere) {
  const auto normals = std::make_unique<SurfaceNormals>();
  CounterRandom random(1, 2);
  int hidden = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3 point = kRadius_mm * direction(random);
    for (unsigned k = 0; k < kLanes; ++k) set_point(point, k, *normals);
    const Pose pose{{within(random, 100), within(random, 100), 500 + within(random, 200)},
                    0.7 * direction(random)};
    const Transform T_C_M = to_transform(pose);
    const Vector3 eye = T_C_M.inverse().t_mm;
    const double cosine = point.normalized().dot((eye - point).normalized());
    const float say = faces(*normals, T_C_M)[static_cast<unsigned>(i) % kLanes];
    if (is_hidden(point, eye)) {
      EXPECT_LT(say, 0.05) << i;
      ++hidden;
    } else if (cosine > 0.25) {
      EXPECT_EQ(say, 1) << i;
    }
    EXPECT_NEAR(static_cast<double>(say), std::min(std::max(5 * cosine, 0.0), 1.0), 0.15) << i;
  }
  EXPECT_GT(hidden, 500);
}

TEST(Facing, TakesAllOfAFlatTargetThatIsNotSeenEdgeOn) {
  const auto model = std::make_unique<PhotoModel>();
  testing::World(TargetKind::kPhoto).make_model(*model);
  for (const double tilt_e : {0.0, 0.2, 0.35, 0.55}) {
    const Transform T_C_M = to_transform({{0, 0, 500}, {tilt_e, 0, 0}});
    for (const float say : faces(model->normals, T_C_M)) EXPECT_EQ(say, 1) << tilt_e;
  }
  const Transform from_behind = to_transform({{0, 0, 500}, {0.9, 0, 0}});
  for (const float say : faces(model->normals, from_behind)) EXPECT_EQ(say, 0);
}

// A disc inflated to a hemisphere faces where a sphere does.
TEST(Facing, KnowsTheNormalsOfAnInflatedDisc) {
  const auto model = std::make_unique<PhotoModel>();
  testing::World(TargetKind::kPhoto).make_model(*model, 1000);
  constexpr double kDisc_mm = 30;
  model->masked = true;
  for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
    model->weight[i] = std::hypot(model->x_mm[i], model->y_mm[i]) < kDisc_mm ? 1 : 0;
  }
  const auto flat = std::make_unique<PhotoModel>(*model);
  const auto relief = std::make_unique<Relief>();
  relief->start(*flat);
  relief->inflate_model(1, *model);
  for (unsigned i = 0; i < static_cast<unsigned>(model->inner); ++i) {
    const double from_middle = std::hypot(flat->x_mm[i], flat->y_mm[i]);
    if (from_middle > 0.8 * kDisc_mm) continue;  // steep, and between points
    const Vector3 sphere =
        Vector3(flat->x_mm[i], flat->y_mm[i], -std::sqrt(kDisc_mm * kDisc_mm - from_middle * from_middle))
            .normalized();
    const Vector3 normal(model->normals.x[i], model->normals.y[i], model->normals.z[i]);
    EXPECT_GT(normal.dot(sphere), 0.98) << i;
    const Vector3 point(model->x_mm[i], model->y_mm[i], model->z_mm[i]);
    EXPECT_NEAR(static_cast<double>(model->normals.reach_mm[i]), normal.dot(point), 1e-3) << i;
  }
}

}  // namespace
}  // namespace vergence
