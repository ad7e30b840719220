// The fit of a marker's outlines: far below a pixel from rough starts, with balls hidden, under any light and
// in every format; never worse than the guess, and as sure of itself as its scatter says.
#include "algo/refine_marker.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>
#include <cstring>
#include <memory>

#include "tests/differential/every_target.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::Picture;
using testing::World;

const Transform kTruth = to_transform({{12, -8, 460}, {0.08, -0.05, 0.1}});

double turn(const Transform& a, const Transform& b) {
  return quaternion_vector_from_rotation(a.R.transpose() * b.R).norm();
}

class Within {
 public:
  explicit Within(std::uint64_t seed) : random_(seed, 0) {}
  double operator()(double half) { return half * (2 * uniform() - 1); }
  double uniform() { return static_cast<double>(random_.next() >> 11) / 9007199254740992.0; }
  // Nearly normal, of standard deviation 1.
  double normal() {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum - 6;
  }
  Transform near(const Transform& T, double mm, double deep_mm, double e) {
    const Pose pose = to_pose(T);
    const Vector3 off((*this)(mm), (*this)(mm), (*this)(deep_mm));
    const Vector3 turned((*this)(e), (*this)(e), (*this)(e));
    return to_transform({pose.position_mm + off, pose.e + turned});
  }

 private:
  CounterRandom random_;
};

struct Stage {
  explicit Stage(const World& of = World(TargetKind::kMarker)) : world(of) {
    world.make_model(marker);
    hue_table.build({});
  }

  void look(const Transform& T_H_M) {
    picture_left = world.look(world.rig.left, T_H_M);
    picture_right = world.look(world.rig.right, T_H_M);
    see();
  }
  void see() { see(picture_left.view(), picture_right.view()); }
  void see(const ImageView& left, const ImageView& right) {
    ASSERT_EQ(make_raw_colour(left, colour_left), Status::kOk);
    ASSERT_EQ(make_raw_colour(right, colour_right), Status::kOk);
    ASSERT_EQ(make_hue_plane(left, {}, hue_table, hue_left), Status::kOk);
    ASSERT_EQ(make_hue_plane(right, {}, hue_table, hue_right), Status::kOk);
    yuv = left.format != PixelFormat::kRgb24;
  }
  [[nodiscard]] MarkerSight left() const {
    return {&world.rig.left, &hue_left, level_of(colour_left, 0), yuv};
  }
  [[nodiscard]] MarkerSight right() const {
    return {&world.rig.right, &hue_right, level_of(colour_right, 0), yuv};
  }
  [[nodiscard]] MarkerFit fit(const Transform& guess) const {
    return fit_marker(marker, left(), right(), guess);
  }
  [[nodiscard]] double cost(const Transform& T) const {
    return marker_evidence(marker, left(), right(), T).cost;
  }

  World world;
  MarkerModel marker;
  YuvHueTable hue_table;
  Picture picture_left;
  Picture picture_right;
  HuePlane hue_left;
  HuePlane hue_right;
  ColourPyramid colour_left;
  ColourPyramid colour_right;
  bool yuv = false;
};

void expect_near(const Transform& T, double across_mm, double deep_mm, double e) {
  EXPECT_LT((T.t_mm - kTruth.t_mm).head<2>().norm(), across_mm);
  EXPECT_LT(std::abs(T.t_mm[2] - kTruth.t_mm[2]), deep_mm);
  EXPECT_LT(turn(T, kTruth), e);
}

// Paints a rectangle over a picture.
void cover(Picture& picture, int x0, int y0, int x1, int y1, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      std::uint8_t* p = picture.rgb.data() + 3 * (y * picture.width_px + x);
      p[0] = r;
      p[1] = g;
      p[2] = b;
    }
  }
}

void add_noise(Picture& picture, double levels, std::uint64_t seed) {
  Within within(seed);
  for (std::uint8_t& byte : picture.rgb) {
    const double value = byte + levels * within.normal() + 0.5;
    byte = static_cast<std::uint8_t>(value < 0 ? 0 : (value > 255 ? 255 : value));
  }
}

// BT.601, limited range; chroma of the pair's mean.
std::vector<std::uint8_t> yuyv_of(const Picture& picture) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(picture.width_px * picture.height_px) * 2);
  const auto byte = [](double v) { return static_cast<std::uint8_t>(v + 0.5); };
  for (std::size_t i = 0; i < out.size() / 4; ++i) {
    const std::uint8_t* p = picture.rgb.data() + 6 * i;
    double u = 0;
    double v = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const double r = p[3 * k] / 255.0;
      const double g = p[3 * k + 1] / 255.0;
      const double b = p[3 * k + 2] / 255.0;
      const double y = 0.299 * r + 0.587 * g + 0.114 * b;
      out[4 * i + 2 * k] = byte(16 + 219 * y);
      u += 0.5 * 224 * (b - y) / 1.772;
      v += 0.5 * 224 * (r - y) / 1.402;
    }
    out[4 * i + 1] = byte(128 + u);
    out[4 * i + 3] = byte(128 + v);
  }
  return out;
}

TEST(RefineMarker, FindsThePoseFarBelowAPixelFromRoughStarts) {
  const auto stage = std::make_unique<Stage>();
  stage->look(kTruth);
  Within within(1);
  for (int trial = 0; trial < 40; ++trial) {
    const MarkerFit fit = stage->fit(within.near(kTruth, 6, 12, 0.1));
    SCOPED_TRACE(trial);
    expect_near(fit.T_H_M, 0.12, 0.5, 0.004);  // 1 px is 1.15 mm here, and 4.4 mm of depth
    EXPECT_GT(fit.evidence.share, 0.9);
    EXPECT_GT(fit.evidence.least_ball, 0.85);
  }
}

TEST(RefineMarker, DoesNotMindTheLight) {
  const auto stage = std::make_unique<Stage>();
  for (const double light : {0.15, 0.4, 1.3}) {
    stage->world.light = light;
    stage->look(kTruth);
    SCOPED_TRACE(light);
    expect_near(stage->fit(Within(3).near(kTruth, 4, 8, 0.08)).T_H_M, 0.25, 1.0, 0.008);
  }
}

TEST(RefineMarker, ReadsYuvAsWell) {
  const auto stage = std::make_unique<Stage>();
  stage->look(kTruth);
  const auto left = yuyv_of(stage->picture_left);
  const auto right = yuyv_of(stage->picture_right);
  const auto view = [](const std::vector<std::uint8_t>& bytes) {
    return ImageView{bytes.data(), 320, 240, 640, PixelFormat::kYuyv, nullptr, 0};
  };
  stage->see(view(left), view(right));
  expect_near(stage->fit(Within(3).near(kTruth, 4, 8, 0.08)).T_H_M, 0.3, 1.0, 0.008);
}

TEST(RefineMarker, HoldsThePoseWhileABarHidesBalls) {
  const auto stage = std::make_unique<Stage>();
  Within within(2);
  double worst_share = 1;
  for (int x = 40; x < 280; x += 12) {
    stage->look(kTruth);
    cover(stage->picture_left, x, 0, x + 26, 240, 150, 110, 80);
    cover(stage->picture_right, x - 30, 0, x - 4, 240, 150, 110, 80);
    stage->see();
    const MarkerFit fit = stage->fit(within.near(kTruth, 2, 4, 0.02));
    SCOPED_TRACE(x);
    expect_near(fit.T_H_M, 0.6, 2, 0.015);
    worst_share = std::min(worst_share, fit.evidence.share);
  }
  EXPECT_LT(worst_share, 0.9);  // the bar did hide something
  EXPECT_GT(worst_share, 0.5);
}

TEST(RefineMarker, IsNeverWorseThanTheGuess) {
  const auto stage = std::make_unique<Stage>();
  Within within(4);
  for (const bool present : {true, false}) {
    stage->world.present = present;
    stage->look(kTruth);
    for (int trial = 0; trial < 40; ++trial) {
      const Transform guess = within.near(kTruth, 60, 120, 0.4);
      const MarkerFit fit = stage->fit(guess);
      EXPECT_LE(fit.evidence.cost, stage->cost(guess));
      EXPECT_EQ(fit.evidence.cost, stage->cost(fit.T_H_M));
    }
  }
}

TEST(RefineMarker, StaysFiniteAndFindsNothingWhereThereIsNoMarker) {
  const auto stage = std::make_unique<Stage>();
  stage->world.present = false;
  stage->look(Transform{});
  for (const Vector3& t : {Vector3(0, 0, 400), Vector3(5000, 0, 400), Vector3(0, 0, -300), Vector3(0, 0, 0),
                           Vector3(0, 0, 20), Vector3(300, 0, 30), Vector3(0, 0, 1e7)}) {
    const MarkerFit fit = stage->fit({Matrix3::Identity(), t});
    EXPECT_TRUE(is_valid(to_pose(fit.T_H_M)));
    EXPECT_TRUE(std::isfinite(fit.information.sum()));
    EXPECT_GE(fit.evidence.cost, 0);
    EXPECT_LE(fit.evidence.cost, 1);
    EXPECT_LT(fit.evidence.share, 0.05);
  }
}

TEST(RefineMarker, IsAsSureAsItsScatter) {
  const auto stage = std::make_unique<Stage>();
  constexpr int kSeeds = 40;
  Vector6 mean = Vector6::Zero();
  Vector6 squares = Vector6::Zero();
  Vector6 claimed = Vector6::Zero();
  stage->look(kTruth);
  const Picture left = stage->picture_left;
  const Picture right = stage->picture_right;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    stage->picture_left = left;
    stage->picture_right = right;
    add_noise(stage->picture_left, 5, 2 * seed);
    add_noise(stage->picture_right, 5, 2 * seed + 1);
    stage->see();
    const MarkerFit fit = stage->fit(kTruth);
    const Matrix6 J = pose_jacobian(fit.T_H_M);
    claimed += (J * fit.information.inverse() * J.transpose()).diagonal();
    Vector6 x;
    const Pose pose = to_pose(fit.T_H_M);
    x << pose.position_mm, pose.e;
    mean += x;
    squares += x.cwiseProduct(x);
  }
  mean /= kSeeds;
  claimed /= kSeeds;
  const Vector6 scatter = squares / kSeeds - mean.cwiseProduct(mean);
  for (int i = 0; i < 6; ++i) {
    const double ratio = std::sqrt(claimed[i] / scatter[i]);
    EXPECT_GT(ratio, 0.4) << i;
    EXPECT_LT(ratio, 3.0) << i;
  }
}

TEST(RefineMarker, GivesTheSameBitsOnEveryTarget) {
  const auto stage = std::make_unique<Stage>();
  std::vector<Matrix6> seen;
  for_every_target([&] {
    stage->look(kTruth);
    const MarkerFit fit = stage->fit(Within(5).near(kTruth, 4, 8, 0.08));
    Matrix6 bits = fit.information;
    bits.row(0).head<3>() = fit.T_H_M.t_mm.transpose();
    seen.push_back(bits);
  });
  for (const Matrix6& bits : seen) EXPECT_EQ(std::memcmp(&bits, &seen.front(), sizeof(Matrix6)), 0);
}

}  // namespace
}  // namespace vergence
