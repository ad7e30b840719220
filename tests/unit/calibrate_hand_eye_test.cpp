// Hand-eye calibration with known truth: exact, with noise of corners and arm, and where it must refuse.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "algo/rotation_vector.hpp"
#include "tests/support/chessboard.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/calibrate/hand_eye.hpp"
#include "tools/calibrate/slopes.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::test {
namespace {

using calibrate::Board;
using calibrate::HandEye;
using tools::InputError;

constexpr Board kBoard{9, 6, 20};
constexpr double kDegree = std::numbers::pi / 180;

struct Noise {
  double corner_px = 0;
  double hand_mm = 0;
  double hand_deg = 0;
};

// The board lies still in the world; the hand looks at it from all sides.
struct Scene {
  Scene(int count, const Noise& noise, std::uint64_t seed) {
    for (const Transform& T_H_B : board_poses(rig, kBoard, count, seed))
      T_W_H.push_back(T_W_B * T_H_B.inverse());
    see(noise, seed);
  }

  // Fills in what is seen and measured, with T_W_H as it is.
  void see(const Noise& noise, std::uint64_t seed) {
    testing::Random random(seed);
    sightings = {640, 480, {}, {}};
    measured.clear();
    for (std::size_t i = 0; i < T_W_H.size(); ++i) {
      calibrate::Sighting sighting;
      sighting.pair.number = static_cast<int>(i);
      for (const std::size_t side : {0U, 1U}) {
        const CameraModel& camera = side == 0 ? rig.left : rig.right;
        for (std::size_t k = 0; k < kBoard.corners(); ++k) {
          Vector2 uv;
          EXPECT_TRUE(project(camera, (T_W_H[i] * camera.T_H_C).inverse() * T_W_B * kBoard.corner_mm(k), uv));
          sighting.corners[side].push_back(uv + noise.corner_px * normal3(random).head<2>());
        }
      }
      sightings.seen.push_back(sighting);
      Vector6 error;
      error << noise.hand_mm * normal3(random), noise.hand_deg * kDegree * normal3(random);
      measured[static_cast<int>(i)] = calibrate::moved(T_W_H[i], error);
    }
  }

  // From a rig that knows the cameras, but not where they sit in the hand.
  [[nodiscard]] HandEye calibrate(const calibrate::HandEyeOptions& options = {}) const {
    StereoRig unplaced = rig;
    const Transform elsewhere{turn_deg(30, {1, 2, 3}), {40, 50, 60}};
    unplaced.left.T_H_C = elsewhere * rig.left.T_H_C;
    unplaced.right.T_H_C = elsewhere * rig.right.T_H_C;
    return calibrate_hand_eye("hand.csv", measured, sightings, kBoard, unplaced, options);
  }

  StereoRig rig = true_rig();
  Transform T_W_B{turn_deg(170, {1, 0.1, 0.2}), {600, -200, 50}};
  std::vector<Transform> T_W_H;
  calibrate::Sightings sightings;
  std::map<int, Transform> measured;
};

Vector6 error_of(const Transform& found, const Transform& truth) {
  const Transform off = truth.inverse() * found;
  Vector6 error;
  error << off.t_mm, vector_from_rotation(off.R);
  return error;
}

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CalibrateHandEye, IsExactOnExactPoses) {
  for (const bool keep_stereo : {false, true}) {
    const Scene scene(8, {}, 1);
    const HandEye result = scene.calibrate({keep_stereo});
    EXPECT_LT(error_of(result.rig.left.T_H_C, scene.rig.left.T_H_C).norm(), 1e-5);
    EXPECT_LT(error_of(result.rig.right.T_H_C, scene.rig.right.T_H_C).norm(), 1e-5);
    EXPECT_LT(error_of(result.T_W_B, scene.T_W_B).norm(), 1e-5);
    EXPECT_LT(result.rms_mm, 1e-5);
    EXPECT_EQ(result.methods.size(), 5U);
  }
}

// Corners as good pictures have them (0.05 px), an arm that repeats to 0.1 mm and 0.01 deg: within 0.2 mm and
// 0.02 deg, which are about two of the stated deviations. deg.
TEST(CalibrateHandEye, IsWithinItsLimitsOnNoise) {
  const Scene scene(24, {0.05, 0.1, 0.01}, 2);
  const HandEye result = scene.calibrate();
  for (const bool left : {true, false}) {
    const Vector6 error = left ? error_of(result.rig.left.T_H_C, scene.rig.left.T_H_C)
                               : error_of(result.rig.right.T_H_C, scene.rig.right.T_H_C);
    EXPECT_LT(error.head<3>().norm(), 0.2) << left;
    EXPECT_LT(error.tail<3>().norm() / kDegree, 0.02) << left;
  }
  EXPECT_NEAR(result.hand_mm, 0.1, 0.04);
  EXPECT_NEAR(result.hand_deg, 0.01, 0.004);
}

// Squared errors over stated variances, over many calibrations: near one, whichever noise rules.
TEST(CalibrateHandEye, StatesItsUncertaintyRight) {
  constexpr int kRuns = 20;
  for (const Noise& noise : {Noise{0.1, 0.3, 0.05}, Noise{0.3, 0, 0}, Noise{0.05, 1, 0}}) {
    for (const bool keep_stereo : {false, true}) {
      double squares = 0;
      for (int run = 0; run < kRuns; ++run) {
        const Scene scene(12, noise, 10 + static_cast<std::uint64_t>(run));
        const HandEye result = scene.calibrate({keep_stereo});
        const Vector6 left = error_of(result.rig.left.T_H_C, scene.rig.left.T_H_C);
        const Vector6 right = error_of(result.rig.right.T_H_C, scene.rig.right.T_H_C);
        squares += left.cwiseAbs2().cwiseQuotient(result.covariance[0].diagonal()).sum() / 12;
        squares += right.cwiseAbs2().cwiseQuotient(result.covariance[1].diagonal()).sum() / 12;
      }
      EXPECT_GT(squares / kRuns, 0.5);
      EXPECT_LT(squares / kRuns, 1.7);
    }
  }
}

TEST(CalibrateHandEye, KeepsThePoseBetweenTheCamerasIfTold) {
  const Scene scene(12, {0.1, 0.5, 0.1}, 3);
  EXPECT_LT(scene.calibrate({true}).moved_mm, 1e-9);
  EXPECT_GT(scene.calibrate({false}).moved_mm, 1e-3);
}

TEST(CalibrateHandEye, PointsAtTheWrongRow) {
  Scene scene(14, {0.05, 0.05, 0.01}, 4);
  scene.measured[5].t_mm.x() += 20;
  bool named = false;
  for (const std::string& warning : scene.calibrate().warnings)
    named = named || warning.rfind("view 5", 0) == 0;
  EXPECT_TRUE(named);
}

TEST(CalibrateHandEye, RefusesAHandThatTurnsAboutOneAxis) {
  Scene scene(8, {}, 1);
  const Transform first = scene.T_W_H.front();
  for (std::size_t i = 0; i < scene.T_W_H.size(); ++i) {
    const Transform T_H_B = first.inverse() * scene.T_W_B;
    const Vector3 centre = T_H_B * kBoard.centre_mm();
    // About the axis through the board's middle, so that it stays in view.
    Transform turn{turn_deg(4.0 * static_cast<double>(i) - 14, {0, 0, 1}), {}};
    turn.t_mm = centre - turn.R * centre;
    scene.T_W_H[i] = first * turn;
  }
  scene.see({}, 1);
  const std::string message = refusal([&] { (void)scene.calibrate(); });
  EXPECT_NE(message.find("hand.csv: e1, e2, e3: the hand turned about one axis only"), std::string::npos)
      << message;
}

TEST(CalibrateHandEye, RefusesAHandThatDoesNotTurn) {
  Scene scene(8, {}, 1);
  const Transform first = scene.T_W_H.front();
  for (std::size_t i = 0; i < scene.T_W_H.size(); ++i) {
    scene.T_W_H[i] = first;
    scene.T_W_H[i].t_mm.x() += static_cast<double>(i);
  }
  scene.see({}, 1);
  const std::string message = refusal([&] { (void)scene.calibrate(); });
  EXPECT_NE(message.find("the hand turned by only"), std::string::npos) << message;
}

TEST(CalibrateHandEye, RefusesTooFewAndMissingPoses) {
  Scene scene(5, {}, 1);
  EXPECT_EQ(refusal([&] { (void)scene.calibrate(); }), "");
  scene.measured.erase(2);
  EXPECT_NE(refusal([&] { (void)scene.calibrate(); }).find("hand.csv: frame: no row for"), std::string::npos);
  const Scene few(4, {}, 1);
  EXPECT_NE(refusal([&] { (void)few.calibrate(); }).find("at least 5"), std::string::npos);
}

}  // namespace
}  // namespace vergence::test
