// Pyramids and correlation against plain code, on every instruction set; and what correlation promises.
#include "algo/correlation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "algo/colour.hpp"
#include "tests/differential/every_target.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

using testing::World;

std::vector<std::uint8_t> random_bytes(std::size_t count, std::uint64_t seed) {
  CounterRandom random(seed, 0);
  std::vector<std::uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
  return bytes;
}

int channel(ColourPixel pixel, int c) {
  return static_cast<int>((pixel >> (8 * c)) & 0xFF);
}

TEST(Colour, IsWithinOneOfTheStandardForAllColours) {
  for (int r = 0; r < 256; r += 3) {
    for (int g = 0; g < 256; ++g) {
      for (int b = 0; b < 256; ++b) {
        const YCbCr c = ycbcr_from_rgb(r, g, b);
        ASSERT_NEAR(c.luma, 0.299 * r + 0.587 * g + 0.114 * b, 1.0);
        ASSERT_NEAR(c.cb, 128 - 0.168736 * r - 0.331264 * g + 0.5 * b, 1.0);
        ASSERT_NEAR(c.cr, 128 + 0.5 * r - 0.418688 * g - 0.081312 * b, 1.0);
      }
    }
  }
}

TEST(ColourPyramid, EqualsPlainCodeForEveryFormatAndWidth) {
  const auto pyramid = std::make_unique<ColourPyramid>();
  for_every_target([&] {
    for (const int width : {4, 6, 18, 62, 64, 130, 322}) {
      const int height = 10;
      const std::size_t stride = static_cast<std::size_t>(width) * 3 + 7;
      const auto bytes = random_bytes(stride * 20, static_cast<std::uint64_t>(width));
      const std::uint8_t* chroma = bytes.data() + 12 * stride;
      for (const PixelFormat format :
           {PixelFormat::kRgb24, PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12}) {
        const ImageView image{bytes.data(), width, height, stride, format, chroma, stride};
        ASSERT_EQ(make_colour_pyramid(image, *pyramid), Status::kOk);
        for (int y = 0; y < height; ++y) {
          const std::uint8_t* row = bytes.data() + static_cast<std::size_t>(y) * stride;
          for (int x = 0; x < width; ++x) {
            const std::uint8_t* pair = row + 2 * (x & ~1);
            const std::uint8_t* uv = chroma + static_cast<std::size_t>(y / 2) * stride + (x & ~1);
            YCbCr expected{};
            switch (format) {
              case PixelFormat::kRgb24:
                expected = ycbcr_from_rgb(row[3 * x], row[3 * x + 1], row[3 * x + 2]);
                break;
              case PixelFormat::kYuyv: expected = {row[2 * x], pair[1], pair[3]}; break;
              case PixelFormat::kUyvy: expected = {row[2 * x + 1], pair[0], pair[2]}; break;
              case PixelFormat::kNv12: expected = {row[x], uv[0], uv[1]}; break;
            }
            const ColourPixel pixel = pyramid->full.pixel[static_cast<std::size_t>(y * width + x)];
            ASSERT_EQ(channel(pixel, 0), expected.luma) << x << " " << y;
            ASSERT_EQ(channel(pixel, 1), expected.cb) << x << " " << y;
            ASSERT_EQ(channel(pixel, 2), expected.cr) << x << " " << y;
          }
        }
        // Each level: rounded means of the finer one.
        for (int level = 1; level < kColourLevels; ++level) {
          const ColourLevel fine = level_of(*pyramid, level - 1);
          const ColourLevel coarse = level_of(*pyramid, level);
          ASSERT_EQ(coarse.width_px, fine.width_px / 2);
          ASSERT_EQ(coarse.height_px, fine.height_px / 2);
          for (int i = 0; i < coarse.width_px * coarse.height_px; ++i) {
            const int x = i % coarse.width_px;
            const int y = i / coarse.width_px;
            for (int c = 0; c < 3; ++c) {
              int sum = 2;
              for (int k = 0; k < 4; ++k)
                sum += channel(fine.pixel[(2 * y + k / 2) * fine.width_px + 2 * x + k % 2], c);
              ASSERT_EQ(channel(coarse.pixel[i], c), sum / 4);
            }
          }
          ASSERT_EQ(coarse.pixel[coarse.outside_index()], kNeutralPixel);
        }
      }
    }
  });
}

// Whether a point of the model faces the camera.
bool faces(const PhotoModel& photo, unsigned k, const Transform& T_C_M) {
  const Vector3 eye = T_C_M.inverse().t_mm;
  const Vector3 normal(photo.normals.x[k], photo.normals.y[k], photo.normals.z[k]);
  return normal.dot(eye) - static_cast<double>(photo.normals.reach_mm[k]) > 0.1 * eye.norm();
}

// Correlation written plainly, in double precision, with the mean put in where nothing is seen, by the
// share that is; hidden points are none, but for the variance of the model.
double plain_correlation(const CorrelationModel& model, const PhotoModel& photo, const CameraModel& camera,
                         const ColourLevel& image, const Transform& T_C_M) {
  const PointColours& colours = photo.colour[static_cast<unsigned>(model.level)];
  const auto points = static_cast<unsigned>(model.points);
  std::vector<Vector3> image_colours(points);
  std::vector<bool> is_seen(points);
  Vector3 mean = Vector3::Zero();
  double seen = 0;
  double facing = 0;
  for (unsigned k = 0; k < points; ++k) {
    if (model.hidden == HiddenPoints::kLeftOut && !faces(photo, k, T_C_M)) continue;
    ++facing;
    Vector2 uv;
    if (!project(camera, T_C_M * Vector3(photo.x_mm[k], photo.y_mm[k], photo.z_mm[k]), uv)) continue;
    const double u = std::nearbyint(uv[0]);
    const double v = std::nearbyint(uv[1]);
    if (u < 0 || v < 0 || u >= image.width_px || v >= image.height_px) continue;
    const ColourPixel pixel = image.pixel[static_cast<int>(v) * image.width_px + static_cast<int>(u)];
    image_colours[k] = {channel(pixel, 0) - 128.0, 2 * (channel(pixel, 1) - 128.0),
                        2 * (channel(pixel, 2) - 128.0)};
    is_seen[k] = true;
    mean += image_colours[k];
    ++seen;
  }
  if (seen == 0) return 0;
  mean /= seen;
  Vector3 model_mean = Vector3::Zero();
  std::vector<Vector3> model_colours(points);
  for (unsigned k = 0; k < points; ++k) {
    model_colours[k] = {colours.luma[k] - 128.0, 2 * (colours.cb[k] - 128.0), 2 * (colours.cr[k] - 128.0)};
    model_mean += model_colours[k] / points;
  }
  double ii = 20 * facing;
  double mm = 20.0 * points;
  double im = 0;
  for (unsigned k = 0; k < points; ++k) {
    const Vector3 a = is_seen[k] ? Vector3(image_colours[k] - mean) : Vector3(Vector3::Zero());
    const Vector3 b = model_colours[k] - model_mean;
    ii += a.squaredNorm();
    mm += b.squaredNorm();
    im += a.dot(b);
  }
  return seen / facing * im / std::sqrt(ii * mm * facing / points);
}

TEST(Correlation, EqualsPlainCodeAndIsOneBitPatternOnEveryInstructionSet) {
  const World world(TargetKind::kPhoto);
  const auto photo = std::make_unique<PhotoModel>();
  const auto model = std::make_unique<CorrelationModel>();
  const auto pyramid = std::make_unique<ColourPyramid>();
  world.make_model(*photo);
  CounterRandom turns(4, 0);
  for (unsigned k = 0; k < static_cast<unsigned>(photo->inner); ++k) {
    const double x = 2 * static_cast<double>(turns.below(1000)) / 1000 - 1;
    const double y = 2 * static_cast<double>(turns.below(1000)) / 1000 - 1;
    const Vector3 normal = Vector3(2 * x, 2 * y, -1).normalized();
    photo->normals.x[k] = static_cast<float>(normal[0]);
    photo->normals.y[k] = static_cast<float>(normal[1]);
    photo->normals.z[k] = static_cast<float>(normal[2]);
    photo->normals.reach_mm[k] = static_cast<float>(normal.dot(Vector3(photo->x_mm[k], photo->y_mm[k], 0)));
  }
  std::vector<std::vector<std::int64_t>> results;
  for_every_target([&] {
    results.emplace_back();
    CounterRandom random(3, 0);
    const auto picture = world.look(world.rig.left, {Matrix3::Identity(), {5, -3, 450}});
    ASSERT_EQ(make_colour_pyramid(picture.view(), *pyramid), Status::kOk);
    for (int level = 0; level < kColourLevels; ++level) {
      for (const int points : {16, 160, 400, 5000}) {
        const CameraModel camera = camera_at_level(world.rig.left, level);
        for (int k = 0; k < 120; ++k) {
          build_correlation_model(*photo, level, points,
                                  k % 2 == 0 ? HiddenPoints::kTakenAlong : HiddenPoints::kLeftOut, *model);
          SearchBox box{{0, 0, 450, 0, 0, 0}, {150, 150, 200, 0.4, 0.4, 0.4}};
          const Transform T = target_in_camera(
              camera, to_transform(decode(random_chromosome(random), box, GeneCoding::kGray)));
          const ColourLevel image = level_of(*pyramid, level);
          const std::int64_t got = correlation(*model, *photo, camera, image, T);
          results.back().push_back(got);
          // A sample on the border of two pixels may fall to either side in single precision.
          ASSERT_NEAR(static_cast<double>(got) * 1e-6, plain_correlation(*model, *photo, camera, image, T),
                      points == 16 ? 0.15 : 0.02);
        }
      }
    }
  });
  for (const auto& result : results) EXPECT_EQ(result, results.front());
}

TEST(Correlation, PeaksAtTheTruthAndDoesNotMindTheLight) {
  for (const double light : {0.35, 1.0}) {
    World world(TargetKind::kPhoto);
    world.light = light;
    const auto photo = std::make_unique<PhotoModel>();
    const auto model = std::make_unique<CorrelationModel>();
    const auto pyramid = std::make_unique<ColourPyramid>();
    world.make_model(*photo);
    const Transform truth{Matrix3::Identity(), {10, 5, 430}};
    const auto picture = world.look(world.rig.left, truth);
    ASSERT_EQ(make_colour_pyramid(picture.view(), *pyramid), Status::kOk);
    build_correlation_model(*photo, 1, 400, HiddenPoints::kLeftOut, *model);
    const CameraModel camera = camera_at_level(world.rig.left, 1);
    const auto at = [&](const Vector3& shift) {
      Transform T = truth;
      T.t_mm += shift;
      return correlation(*model, *photo, camera, level_of(*pyramid, 1), target_in_camera(camera, T));
    };
    EXPECT_GT(at({0, 0, 0}), 850'000) << light;
    for (const Vector3& shift :
         {Vector3(15, 0, 0), Vector3(-15, 0, 0), Vector3(0, 15, 0), Vector3(0, 0, 120)}) {
      EXPECT_LT(at(shift), at({0, 0, 0}) - 200'000) << light;
    }
    EXPECT_LT(at({2000, 0, 0}), 1000);  // nothing to see there
  }
}

}  // namespace
}  // namespace vergence
