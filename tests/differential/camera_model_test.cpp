// Projection with lens distortion against OpenCV's projectPoints.
#include "algo/camera_model.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <opencv2/calib3d.hpp>
#include <vector>

#include "algo/colour_pyramid.hpp"

namespace vergence {
namespace {

double within(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1000001) / 1e6;
}

TEST(CameraModel, ProjectsAsOpenCvDoes) {
  ASSERT_TRUE(rc::check([] {
    CameraModel camera;
    camera.fx_px = within(100, 2000);
    camera.fy_px = within(100, 2000);
    camera.cx_px = within(0, 1280);
    camera.cy_px = within(0, 1024);
    for (double& k : camera.distortion) k = within(-0.4, 0.4);
    const Vector3 p{within(-300, 300), within(-300, 300), within(200, 2000)};
    Vector2 uv;
    RC_ASSERT(project(camera, p, uv));
    const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
    const std::vector<double> k(camera.distortion.begin(), camera.distortion.end());
    std::vector<cv::Point2d> oracle;
    cv::projectPoints(std::vector<cv::Point3d>{{p[0], p[1], p[2]}}, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K,
                      k, oracle);
    RC_ASSERT(std::abs(uv[0] - oracle[0].x) < 1e-6 * (1 + std::abs(oracle[0].x)));
    RC_ASSERT(std::abs(uv[1] - oracle[0].y) < 1e-6 * (1 + std::abs(oracle[0].y)));
  }));
}

TEST(CameraModel, RefusesWhatIsBehindIt) {
  Vector2 uv{1, 2};
  EXPECT_FALSE(project({}, {0, 0, 0.5}, uv));
  EXPECT_FALSE(project({}, {0, 0, -100}, uv));
  EXPECT_FALSE(project({}, {0, 0, std::nan("")}, uv));
  EXPECT_EQ(uv, Vector2(1, 2));
}

TEST(CameraModel, ACoarseLevelsPixelIsTheMiddleOfTheFinerOnes) {
  ASSERT_TRUE(rc::check([] {
    const CameraModel camera;
    const Vector3 p{within(-200, 200), within(-150, 150), within(300, 900)};
    Vector2 fine;
    RC_ASSERT(project(camera, p, fine));
    for (int level = 1; level < kColourLevels; ++level) {
      Vector2 coarse;
      RC_ASSERT(project(camera_at_level(camera, level), p, coarse));
      // Pixel k of a level covers 2^level pixels from 2^level k on; centres are whole numbers.
      const double scale = 1 << level;
      RC_ASSERT(std::abs(coarse[0] * scale + 0.5 * (scale - 1) - fine[0]) < 1e-9);
      RC_ASSERT(std::abs(coarse[1] * scale + 0.5 * (scale - 1) - fine[1]) < 1e-9);
    }
  }));
}

}  // namespace
}  // namespace vergence
