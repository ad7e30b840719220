// The renderer is what accuracy is judged by, so it is held to what can be worked out on paper: where a
// sphere's outline lies, what two eyes triangulate, where the model frame is; and it must render the same
// bytes always.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <type_traits>
#include <utility>

#include "algo/rotation_vector.hpp"
#include "tools/io/input_error.hpp"
#include "tools/render/creatures.hpp"
#include "tools/render/dataset_writer.hpp"
#include "tools/render/random.hpp"
#include "tools/render/rasteriser.hpp"
#include "tools/render/scene.hpp"

namespace vergence::render {
namespace {

std::filesystem::path scratch(const std::string& name) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const auto folder =
      std::filesystem::temp_directory_path() / ("vergence_render_" + std::string(test->name()));
  std::filesystem::create_directories(folder);
  return folder / name;
}

Scene scene_of(const std::string& toml, const SceneOverrides& overrides = {}) {
  const auto file = scratch("scene.toml");
  std::ofstream(file) << toml;
  return load_scene(file, overrides);
}

const char* const kMarker = "[target]\nkind = \"marker\"\n";
const char* const kCrab = "[target]\nkind = \"creature\"\ncreature = \"crab\"\nmesh_mm = 2\n";

Visibility look(const CameraModel& camera, const Transform& T_W_C, const Mesh& mesh, const Transform& T_W_M,
                Sampling sampling = Sampling::k4) {
  LinearImage image(camera.width_px, camera.height_px);
  Visibility visibility;
  const Placed placed{&mesh, T_W_M, true};
  draw(camera, T_W_C, {&placed, 1}, Light{}, sampling, image, &visibility);
  return visibility;
}

struct Blob {
  double area = 0;
  Vector2 centre = Vector2::Zero();
};

Blob blob(const Visibility& visibility, int width) {
  Blob result;
  for (std::size_t i = 0; i < visibility.coverage.size(); ++i) {
    const double share = visibility.coverage[i];
    result.area += share;
    result.centre += share * Vector2(static_cast<double>(i % static_cast<std::size_t>(width)),
                                     static_cast<double>(i / static_cast<std::size_t>(width)));
  }
  result.centre /= result.area;
  return result;
}

TEST(Render, OutlineOfABallIsTheEllipseOfProjectiveGeometry) {
  CameraModel camera;
  for (const Vector3& c :
       {Vector3(0, 0, 500), Vector3(120.3, -60.7, 520), Vector3(-150, 90, 480.5), Vector3(33, 88, 700)}) {
    for (const double radius : {8.0, 20.0}) {
      const Mesh ball = make_ball(Vector3::Zero(), radius, {1, 0, 0});
      const Blob seen = blob(look(camera, {}, ball, {Matrix3::Identity(), c}), camera.width_px);
      // The cone tangent to the sphere, cut by the image plane.
      const double q = c[2] * c[2] - radius * radius;
      const Vector2 centre(camera.fx_px * c[0] * c[2] / q + camera.cx_px,
                           camera.fy_px * c[1] * c[2] / q + camera.cy_px);
      const double area = std::numbers::pi * radius * radius * camera.fx_px * camera.fy_px *
                          std::sqrt(c.squaredNorm() - radius * radius) / std::pow(q, 1.5);
      EXPECT_LT((seen.centre - centre).norm(), 0.05) << c.transpose();
      EXPECT_NEAR(std::sqrt(seen.area / std::numbers::pi), std::sqrt(area / std::numbers::pi), 0.05)
          << c.transpose();
    }
  }
}

TEST(Render, PixelRaysUndoTheCameraModelsDistortion) {
  CameraModel camera;
  camera.distortion = {-0.22, 0.09, 0.0015, -0.001, -0.01};
  const std::vector<Vector2> rays = pixel_rays(camera);
  double worst = 0;
  for (int v = 0; v < camera.height_px; v += 7) {
    for (int u = 0; u < camera.width_px; u += 7) {
      const Vector2& ray = rays[static_cast<std::size_t>(v * camera.width_px + u)];
      Vector2 uv;
      ASSERT_TRUE(project(camera, {ray[0], ray[1], 1}, uv));
      worst = std::max(worst, (uv - Vector2(u, v)).norm());
    }
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(Render, DistortedPictureAgreesWithTheCameraModel) {
  CameraModel camera;
  camera.distortion = {-0.22, 0.09, 0.0015, -0.001, -0.01};
  const Mesh dot = make_ball(Vector3::Zero(), 2, {1, 0, 0});
  for (const Vector3& c : {Vector3(150, 100, 500), Vector3(-170, 60, 500), Vector3(20, -120, 450)}) {
    const Blob seen = blob(look(camera, {}, dot, {Matrix3::Identity(), c}, Sampling::k16), camera.width_px);
    Vector2 expected;
    ASSERT_TRUE(project(camera, c, expected));
    EXPECT_LT((seen.centre - expected).norm(), 0.05) << c.transpose();
  }
}

TEST(Render, TwoTurnedEyesTriangulateAPaintedPoint) {
  Scene scene = scene_of(std::string("[rig]\nkind = \"eyes\"\n") + kMarker);
  const Mesh dot = make_ball(Vector3::Zero(), 2, {1, 0, 0});
  for (const Vector3& truth : {Vector3(0, -100, 545), Vector3(110, -30, 600), Vector3(-90, -160, 480)}) {
    const EyeAngles eyes = gaze_at(scene.rig, truth);
    Vector3 from[2];
    Vector3 along[2];
    for (int k = 0; k < 2; ++k) {
      const CameraModel& camera = k == 0 ? scene.rig.left : scene.rig.right;
      const Transform T_H_C =
          k == 0 ? left_eye_in_hand(camera.T_H_C, eyes) : right_eye_in_hand(camera.T_H_C, eyes);
      const Blob seen =
          blob(look(camera, T_H_C, dot, {Matrix3::Identity(), truth}, Sampling::k16), camera.width_px);
      // Both eyes look straight at it.
      EXPECT_LT((seen.centre - Vector2(camera.cx_px, camera.cy_px)).norm(), 0.05);
      from[k] = T_H_C.t_mm;
      along[k] = T_H_C.R * Vector3((seen.centre[0] - camera.cx_px) / camera.fx_px,
                                   (seen.centre[1] - camera.cy_px) / camera.fy_px, 1);
    }
    // The point nearest to both rays.
    const Vector3 between = from[1] - from[0];
    const double aa = along[0].dot(along[0]);
    const double ab = along[0].dot(along[1]);
    const double bb = along[1].dot(along[1]);
    const double det = aa * bb - ab * ab;
    const double s = (between.dot(along[0]) * bb - between.dot(along[1]) * ab) / det;
    EXPECT_LT((from[0] + s * along[0] - truth).norm(), 0.2) << truth.transpose();
  }
}

TEST(Render, BothEyesSeeTheSameSolid) {
  const Scene scene = scene_of(kCrab);
  const Transform T_W_M = to_transform({{20, -10, 510}, {0.1, -0.12, 0.05}});
  const CameraModel& left = scene.rig.left;
  const CameraModel& right = scene.rig.right;
  const Visibility in_left = look(left, left.T_H_C, scene.target.mesh, T_W_M);
  const Visibility in_right = look(right, right.T_H_C, scene.target.mesh, T_W_M);
  const Transform T_R_L = right.T_H_C.inverse() * left.T_H_C;
  int points = 0;
  int off_outline = 0;
  int behind = 0;
  for (std::size_t i = 0; i < in_left.coverage.size(); ++i) {
    if (in_left.coverage[i] < 1) continue;
    const double z = in_left.depth_mm[i];
    const Vector2& ray = scene.left_rays[i];
    const Vector3 p = T_R_L * Vector3(ray[0] * z, ray[1] * z, z);
    Vector2 uv;
    ASSERT_TRUE(project(right, p, uv));
    const auto k = static_cast<std::size_t>(std::lround(uv[1]) * right.width_px + std::lround(uv[0]));
    ++points;
    // To the next pixel: that is how far an outline's mean depth may mislead.
    off_outline +=
        in_right.coverage[k] <= 0 && in_right.coverage[k - 1] <= 0 && in_right.coverage[k + 1] <= 0;
    // The other eye sees this point, or something nearer.
    behind += in_right.coverage[k] > 0 && in_right.depth_mm[k] > p[2] + 2 ? 1 : 0;
  }
  EXPECT_GT(points, 10000);
  EXPECT_LT(off_outline, points / 1000);
  EXPECT_LT(behind, points / 50);  // at outlines, where a pixel's mean depth is of two surfaces
}

TEST(Render, ModelFrameIsWhereThePhotoSaysItIs) {
  for (const char* target :
       {"kind = \"creature\"\ncreature = \"turtle\"\nmesh_mm = 1.5\n", "kind = \"card\"\n"}) {
    const Scene scene = scene_of(std::string("[target]\n") + target);
    const CameraModel& camera = scene.photo.camera;
    const Rectangle& roi = scene.target.roi;
    const double d = scene.photo.distance_mm;
    const Vector3 origin((roi.x + (roi.width - 1) / 2.0 - camera.cx_px) * d / camera.fx_px,
                         (roi.y + (roi.height - 1) / 2.0 - camera.cy_px) * d / camera.fy_px, d);
    const Visibility seen = look(camera, {}, scene.target.mesh, {Matrix3::Identity(), origin}, Sampling::k16);
    const ModelPhoto photo = take_model_photo(scene);
    double depth = 0;
    int pixels = 0;
    for (std::size_t i = 0; i < seen.coverage.size(); ++i) {
      const int x = static_cast<int>(i) % camera.width_px;
      const int y = static_cast<int>(i) / camera.width_px;
      if (photo.mask.data[i] == 0) continue;
      EXPECT_GE(x, roi.x);
      EXPECT_LT(x, roi.x + roi.width);
      EXPECT_GE(y, roi.y);
      EXPECT_LT(y, roi.y + roi.height);
      depth += seen.depth_mm[i];
      ++pixels;
    }
    ASSERT_GT(pixels, 1000);
    EXPECT_NEAR(depth / pixels, d, 0.05);
  }
}

TEST(Render, CreaturesAreClosedColourfulSolidsOfTheirSize) {
  ASSERT_EQ(creatures().size(), 12U);
  for (const Creature& creature : creatures()) {
    SCOPED_TRACE(creature.name);
    const Mesh mesh = make_creature(creature, 2.5);
    Vector3 low = Vector3::Constant(1e9);
    Vector3 high = -low;
    std::set<int> hues;
    for (const Vertex& vertex : mesh.vertices) {
      low = low.cwiseMin(vertex.position_mm);
      high = high.cwiseMax(vertex.position_mm);
      EXPECT_NEAR(vertex.normal.norm(), 1, 1e-9);
      const auto byte = [](float v) {
        return static_cast<int>(255 * encode_srgb(std::clamp(v, 0.0F, 1.0F)));
      };
      const std::uint8_t code =
          hue_code_rgb(byte(vertex.albedo.r), byte(vertex.albedo.g), byte(vertex.albedo.b), {40, 250, 300});
      if (is_hue(code)) hues.insert(code / 21);
    }
    EXPECT_LT((high - low - creature.size_mm).norm(), 1e-9);
    EXPECT_GE(hues.size(), 3U);
    // Closed: every edge has as many triangles on one side as on the other.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) ++edges[std::minmax(t[i], t[(i + 1) % 3])];
    }
    int open = 0;
    for (const auto& [edge, count] : edges) open += count % 2;
    EXPECT_EQ(open, 0);
  }
}

// A number for the bits of a mesh.
std::uint64_t bits_of(const Mesh& mesh) {
  std::uint64_t all = 0;
  const auto take = [&all](auto value) {
    using Bits = std::conditional_t<sizeof value == 8, std::uint64_t, std::uint32_t>;
    all = hash(all, std::bit_cast<Bits>(value));
  };
  for (const Vertex& vertex : mesh.vertices) {
    for (int i = 0; i < 3; ++i) take(vertex.position_mm[i]);
    for (int i = 0; i < 3; ++i) take(vertex.normal[i]);
    for (const float value : {vertex.albedo.r, vertex.albedo.g, vertex.albedo.b, vertex.openness})
      take(value);
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) take(corner);
  }
  return all;
}

// By any other number all pictures of it are other ones as well.
TEST(Render, CreaturesKeepTheirBits) {
  EXPECT_EQ(bits_of(make_creature(*find_creature("crab"), 2)), 11723365455853638326U);
  EXPECT_EQ(bits_of(make_creature(*find_creature("turtle"), 2)), 18133338990027554076U);
}

TEST(Render, InsidesAreNeverSeen) {
  const CameraModel camera;
  Mesh mesh = make_ball({-20, 0, 0}, 15, {0.5F, 0.4F, 0.3F});
  mesh.append(make_bar({-20, 0, 0}, {30, 5, 10}, 4, {0.1F, 0.4F, 0.8F}));
  mesh.append(make_ball({30, 5, 10}, 20, {0.3F, 0.4F, 0.5F}));
  ASSERT_EQ(mesh.turns.size(), mesh.triangles.size());
  Mesh from_both_sides = mesh;
  from_both_sides.turns.clear();
  for (int k = 0; k < 12; ++k) {
    const Transform T_W_M{rotation_from_vector(Vector3(0.7 * k, 1.3 * k, -0.4 * k)), {3.0 * k - 20, 10, 350}};
    LinearImage seen(640, 480);
    LinearImage expected(640, 480);
    draw(camera, {}, std::array{Placed{&mesh, T_W_M}}, Light{}, Sampling::k8, seen);
    draw(camera, {}, std::array{Placed{&from_both_sides, T_W_M}}, Light{}, Sampling::k8, expected);
    for (std::size_t i = 0; i < seen.data.size(); ++i) {
      ASSERT_TRUE(seen.data[i].r == expected.data[i].r && seen.data[i].g == expected.data[i].g &&
                  seen.data[i].b == expected.data[i].b)
          << "turn " << k << ", pixel " << i;
    }
  }
}

std::map<std::string, std::string> files_in(const std::filesystem::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    std::stringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    files[std::filesystem::relative(entry.path(), directory).string()] = text.str();
  }
  return files;
}

TEST(Render, SameSceneAndSeedGiveTheSameBytesOnAnyNumberOfThreads) {
  SceneOverrides small;
  small.scale = 0.25;
  const std::string toml = std::string(
                               "[background]\nkind = \"clutter\"\n[motion]\nkind = \"random\"\n"
                               "amplitude = [20, 20, 20, 0.1, 0.1, 0.1]\n[rig]\nkind = \"eyes\"\n") +
                           kMarker;
  const Scene scene = scene_of(toml, small);
  write_dataset(scene, scratch("one"), 5, 1, [] {});
  write_dataset(scene_of(toml, small), scratch("three"), 5, 3, [] {});
  const auto one = files_in(scratch("one"));
  EXPECT_EQ(one, files_in(scratch("three")));
  EXPECT_EQ(one.size(), 15U);  // 10 pictures, rig, model, search, truth, motion

  small.seed = 2;
  write_dataset(scene_of(toml, small), scratch("other"), 5, 1, [] {});
  EXPECT_NE(one.at("left/000000.png"), files_in(scratch("other")).at("left/000000.png"));
}

double brightness(const Scene& scene, double t_s) {
  tools::RgbImage image;
  render_eye(scene, state_at(scene, t_s), Eye::kLeft, 1, image);
  double sum = 0;
  for (const std::uint8_t byte : image.data) sum += byte;
  return sum / static_cast<double>(image.data.size());
}

TEST(Render, MoreLuxIsBrighterAndStepsComeOnTime) {
  SceneOverrides small;
  small.scale = 0.25;
  const Scene scene =
      scene_of(std::string("[light]\nlux = 100\n[[light.step]]\nt_s = 1.0\nlux = 800\n") + kMarker, small);
  EXPECT_LT(brightness(scene, 0.99) + 20, brightness(scene, 1.0));
}

TEST(Render, NoiseHasTheStrengthOfItsElectrons) {
  SceneOverrides small;
  small.scale = 0.25;
  const std::string toml = std::string(
                               "[background]\nkind = \"plain\"\nsaturation = 0\nvalue = 0.5\n"
                               "[motion]\npose = [0, 0, -500, 0, 0, 0]\n[camera]\nvignetting = 0\n"
                               "full_well_e = 1000\nread_noise_e = 0\nblur_px = 0\n") +
                           kMarker;
  tools::RgbImage image;
  const Scene scene = scene_of(toml, small);
  render_eye(scene, state_at(scene, 0), Eye::kLeft, 1, image);
  // Back to linear light; a mean signal s of 1000 s electrons has a standard deviation of sqrt(s / 1000).
  double sum = 0;
  double squares = 0;
  for (const std::uint8_t byte : image.data) {
    const double linear = decode_srgb(static_cast<float>(byte) / 255);
    sum += linear;
    squares += linear * linear;
  }
  const auto n = static_cast<double>(image.data.size());
  const double mean = sum / n;
  const double deviation = std::sqrt(squares / n - mean * mean);
  EXPECT_GT(mean, 0.1);
  EXPECT_NEAR(deviation, std::sqrt(mean / 1000), 0.05 * deviation);
}

TEST(Render, TwentyStepsKeepTheirSpeedsAndComeHome) {
  const Scene scene = scene_of(
      std::string("[motion]\nkind = \"steps20\"\npose = [0, 0, 500, 0, 0, 0]\nrest_s = 1\n") + kMarker);
  const Motion& motion = scene.target_motion;
  double fastest = 0;
  double quickest = 0;
  Vector3 reach = Vector3::Zero();
  for (double t = 0; t < motion.keys.back().t_s; t += 0.05) {
    const Pose a = motion.at(t);
    const Pose b = motion.at(t + 0.05);
    fastest = std::max(fastest, (b.position_mm - a.position_mm).norm() / 0.05);
    quickest = std::max(quickest, 2 * (b.e - a.e).norm() / 0.05);
    reach = reach.cwiseMax(a.e.cwiseAbs());
  }
  EXPECT_NEAR(fastest, 50, 0.1);
  EXPECT_NEAR(quickest * 180 / std::numbers::pi, 10, 0.3);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(reach[i], 0.174, 0.001);
  EXPECT_LT((motion.at(1e6).position_mm - Vector3(0, 0, 500)).norm(), 1e-9);
}

TEST(Render, SwingIsATriangleOfTheAngle) {
  const Scene scene =
      scene_of(std::string("[motion]\nkind = \"swing\"\npose = [0, 0, 500, 0, 0, 0]\n") + kMarker);
  const auto degrees = [&](double t_s) {
    return 2 * std::asin(scene.target_motion.at(t_s).e[1]) * 180 / std::numbers::pi;
  };
  EXPECT_NEAR(degrees(0), 0, 1e-9);
  EXPECT_NEAR(degrees(2), 9, 1e-6);  // 4.5 deg/s
  EXPECT_NEAR(degrees(40 / 9.0), 20, 1e-6);
  EXPECT_NEAR(degrees(3 * 40 / 9.0), -20, 1e-6);
  EXPECT_NEAR(degrees(4 * 40 / 9.0), 0, 1e-6);
}

TEST(Render, PatchesStandInPlaceOfWhatTheSceneSays) {
  SceneOverrides overrides;
  overrides.patch = "light.lux = 80\n[motion]\npose = [1, 2, 600, 0, 0, 0]\n";
  const Scene scene = scene_of(std::string(kMarker) + "[light]\nlux = 500\nambient = 0.2\n", overrides);
  EXPECT_DOUBLE_EQ(scene.lights.front().light.lux, 80);
  EXPECT_DOUBLE_EQ(scene.lights.front().light.ambient, 0.2) << "what is not named stays";
  EXPECT_DOUBLE_EQ(scene.target_motion.at(0).position_mm[2], 600);
  overrides.patch = "light.lux = bright";
  EXPECT_THROW((void)scene_of(kMarker, overrides), tools::InputError);
  overrides.patch = "light.luxx = 3";
  EXPECT_THROW((void)scene_of(kMarker, overrides), tools::InputError);
}

TEST(Render, HiddenTargetsLeaveNeitherPictureNorTruth) {
  const std::string small =
      "[image]\nwidth = 160\nheight = 120\nfps = 10\n[rig]\nfx = 200\n[camera]\nnoise = false\n";
  const Scene scene = scene_of(small + kMarker + "hidden_s = [0.1, 0.3]\n");
  const Scene empty = scene_of(small + kMarker + "absent = true\n");
  const auto picture = [](const Scene& from, double t_s) {
    tools::RgbImage image;
    render_eye(from, state_at(from, t_s), Eye::kLeft, 1, image);
    return image.data;
  };
  const auto bare = picture(empty, 0);
  EXPECT_NE(picture(scene, 0.0), bare);
  EXPECT_EQ(picture(scene, 0.1), bare);
  EXPECT_EQ(picture(scene, 0.2), bare);
  EXPECT_NE(picture(scene, 0.3), bare);
  write_dataset(scene, scratch("set"), 4, 1, [] {});
  std::ifstream truth(scratch("set") / "truth.csv");
  std::string line;
  std::set<std::string> frames;
  std::getline(truth, line);
  while (std::getline(truth, line)) frames.insert(line.substr(0, line.find(',')));
  EXPECT_EQ(frames, (std::set<std::string>{"0", "3"}));
}

TEST(Render, RandomPosesInViewAreSeenWholeByBothEyes) {
  const std::string random =
      "[motion]\nkind = \"random\"\npose = [0, 0, 500, 0, 0, 0]\namplitude = [180, 180, 180, 0.35, 0.35, "
      "0.35]\n";
  const Scene any = scene_of(kMarker + random);
  const Scene scene = scene_of(kMarker + random + "in_view = true\n");
  int beside = 0;
  int kept = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const Pose pose = scene.target_motion.at(frame / 30.0);
    const auto seen = [&](const CameraModel& camera, const Pose& at, double margin_px) {
      const Transform T_C_M = target_in_camera(camera, to_transform(at));
      for (const Vertex& vertex : scene.target.mesh.vertices) {
        Vector2 uv;
        if (!project(camera, T_C_M * vertex.position_mm, uv) || uv[0] < margin_px || uv[1] < margin_px ||
            uv[0] > camera.width_px - margin_px || uv[1] > camera.height_px - margin_px) {
          return false;
        }
      }
      return true;
    };
    EXPECT_TRUE(seen(scene.rig.left, pose, 1) && seen(scene.rig.right, pose, 1)) << frame;
    const Pose free = any.target_motion.at(frame / 30.0);
    const bool whole = seen(scene.rig.left, free, 5) && seen(scene.rig.right, free, 5);
    beside += whole ? 0 : 1;
    // A pose that was in view from the first draw stays what it was.
    if (whole && free.position_mm == pose.position_mm) ++kept;
  }
  EXPECT_GT(beside, 10);
  EXPECT_EQ(kept, 60 - beside);
}

TEST(Render, BoardsAreAsThinAsTheySay) {
  const Scene scene =
      scene_of(std::string(kMarker) + "[[occluder]]\nwidth_mm = 300\ndepth_mm = 4\nlength_mm = 200\n");
  double depth_mm = 0;
  double width_mm = 0;
  for (const Vertex& vertex : scene.occluders.front().mesh.vertices) {
    depth_mm = std::max(depth_mm, 2 * std::abs(vertex.position_mm[2]));
    width_mm = std::max(width_mm, 2 * std::abs(vertex.position_mm[0]));
    EXPECT_NEAR(vertex.normal.norm(), 1, 1e-9);
  }
  EXPECT_NEAR(depth_mm, 4, 0.1);
  EXPECT_NEAR(width_mm, 300, 1);
}

TEST(Render, BadScenesAreRefusedByFileAndKey) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "target: missing"},
      {"[target]\nkind = \"whale\"\n", "target.kind"},
      {"[target]\nkind = \"creature\"\ncreature = \"C13\"\n", "target.creature"},
      {"[target]\nkind = \"marker\"\ncolour = 3\n", "target.colour"},
      {"[target]\nkind = \"marker\"\n[motion]\nkind = \"sine\"\namplitude = [nan, 0, 0, 0, 0, 0]\n",
       "motion.amplitude"},
      {"[target]\nkind = \"marker\"\n[motion]\npose = [0, 0, 500, 1, 1, 0]\n", "motion.pose"},
      {"[target]\nkind = \"marker\"\n[light]\nlux = nan\n", "light.lux"},
      {"[target]\nkind = \"marker\"\n[light]\nlux = inf\n", "light.lux"},
      {"[target]\nkind = \"marker\"\n[light]\npreset = \"noon\"\n", "light.preset"},
      {"[target]\nkind = \"marker\"\n[rig]\nkind = \"photo\"\ngaze = \"target\"\n", "rig.gaze"},
      {"[target]\nkind = \"marker\"\n[camera]\nsamples = 5\n", "camera.samples"},
      {"[target]\nkind = \"marker\"\n[image]\nwidth = 100000\n", "image.width"},
      {"[target]\nkind = \"marker\"\n[background]\ndistance_mm = -5\n", "background.distance_mm"},
      {"[target]\nkind = \"marker\"\n[motion]\nkind = \"keys\"\n", "motion.key"},
      {"[target]\nkind = \"marker\"\n[[occluder]]\ndirection = [0, 0, 0]\n", "occluder[0].direction"},
      {"[target]\nkind = \"marker\"\n[wind]\nspeed = 3\n", "wind"},
      {"[target]\nkind = \"card\"\nsize_mm = [900, 900]\n", "target.kind"},
      {"[target\n", "line 1"},
  };
  for (const auto& [toml, key] : cases) {
    try {
      (void)scene_of(toml);
      ADD_FAILURE() << "accepted: " << toml;
    } catch (const tools::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("scene.toml"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(key), std::string::npos)
          << error.what() << "\nexpected " << key;
    }
  }
}

}  // namespace
}  // namespace vergence::render
