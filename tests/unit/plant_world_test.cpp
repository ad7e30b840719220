// The simulated world as the controller meets it, through the simulated devices.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "algo/pa10.hpp"
#include "hal/clock.hpp"
#include "tools/plant/world.hpp"
#include "tools/render/random.hpp"

namespace vergence::plant {
namespace {

constexpr std::int64_t kMs = 1'000'000;

const char* const kMarker = R"(
[image]
fps = 25
[rig]
kind = "eyes"
[target]
kind = "marker"
[motion]
kind = "sine"
pose = [0, -100, 545, 0, 0, 0]
amplitude = [80, 0, 0, 0, 0, 0]
omega_rad_s = 3
)";

render::Scene scene_of(const std::string& toml, double scale = 0.125) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const auto folder =
      std::filesystem::temp_directory_path() / ("vergence_plant_" + std::string(test->name()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "scene.toml") << toml;
  render::SceneOverrides overrides;
  overrides.scale = scale;
  return render::load_scene(folder / "scene.toml", overrides);
}

JointVector start_rad() {
  JointVector q;
  q << 0, 0.5, 0, 1.6, 0, -0.5, 0;
  return q;
}

// The scene lies before the arm's hand as it stands at first.
WorldOptions options_with_arm(const render::Scene& scene) {
  WorldOptions options = options_of(scene, pa10(), start_rad());
  options.servo.enable_delay_ns = 0;
  options.T_W_S = forward_kinematics(pa10(), start_rad()).T_W_H;
  return options;
}

struct Rig {
  sim::SimStereoCamera camera;
  sim::SimArm arm;
  sim::SimPanTilt eyes;
  World world;

  Rig(const render::Scene& scene, const WorldOptions& options) : world(scene, options, {camera, arm, eyes}) {}

  void enable() {
    arm.request(ArmRequest::kEnable);
    eyes.enable(true);
  }
};

std::vector<std::uint8_t> bytes_of(const ImageView& image) {
  return {image.data, image.data + image.stride_bytes * static_cast<std::size_t>(image.height_px)};
}

const std::array<double, kMaxJoints> kCommand = {0, 0.3, 0.2, -0.3, 0.5, 0.4, -0.6};
const std::array<double, kPanTiltMotors> kRates = {300, -500, 700};

// Moves arm and eyes; what the controller heard and saw, one after the other.
struct Story {
  std::vector<double> positions;
  std::vector<std::int64_t> steps;
  std::vector<std::uint8_t> pixels;
};

Story story_of(const render::Scene& scene, const WorldOptions& options) {
  Rig rig(scene, options);
  rig.enable();
  Story story;
  for (int ms = 2; ms <= 140; ms += 2) {
    rig.arm.command(kCommand);
    rig.eyes.command(kRates);
    rig.world.advance_to(ms * kMs);
    ArmFeedback arm;
    PanTiltFeedback eyes;
    StereoFrame frame;
    EXPECT_TRUE(rig.arm.read(arm));
    EXPECT_TRUE(rig.eyes.read(eyes));
    EXPECT_EQ(arm.stamp_ns, ms * kMs);
    EXPECT_EQ(eyes.stamp_ns, ms * kMs);
    story.positions.insert(story.positions.end(), arm.position_rad.begin(), arm.position_rad.end());
    story.steps.insert(story.steps.end(), eyes.steps.begin(), eyes.steps.end());
    if (!rig.camera.take(frame)) continue;
    for (const ImageView& image : {frame.left, frame.right}) {
      const std::vector<std::uint8_t> bytes = bytes_of(image);
      story.pixels.insert(story.pixels.end(), bytes.begin(), bytes.end());
    }
  }
  return story;
}

TEST(PlantWorld, SameSeedGivesTheSameBytes) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_with_arm(scene);
  const Story once = story_of(scene, options);
  const Story again = story_of(scene, options);
  EXPECT_EQ(once.pixels.size(), 4U * 2 * 80 * 60 * 3);
  EXPECT_EQ(once.positions, again.positions);
  EXPECT_EQ(once.steps, again.steps);
  EXPECT_EQ(once.pixels, again.pixels);
  EXPECT_NE(once.positions.front(), once.positions[once.positions.size() - 2]);
  options.seed += 1;
  const Story other = story_of(scene, options);
  EXPECT_EQ(once.positions, other.positions);
  EXPECT_NE(once.pixels, other.pixels);
}

// The picture of what was recorded at some instants, made without the world.
std::vector<std::uint8_t> picture_of(const Rig& rig, const WorldOptions& options, double stamp_s,
                                     std::uint64_t sequence, const std::vector<HeadState>& heads) {
  render::SceneState state = render::state_at(rig.world.scene(), stamp_s);
  EXPECT_EQ(state.moments.size(), heads.size());
  for (std::size_t i = 0; i < heads.size(); ++i) {
    state.moments[i].T_W_H = options.T_W_S.inverse() * heads[i].T_W_H;
    state.moments[i].eyes = heads[i].eyes;
  }
  tools::RgbImage left;
  tools::RgbImage right;
  render::render_pair(rig.world.scene(), state, render::hash(options.seed, sequence), left, right);
  left.data.insert(left.data.end(), right.data.begin(), right.data.end());
  return left.data;
}

// Moves hand and eyes and compares the pair stamped at 80 ms with what it should show; `instants_ms` are
// those of its exposure.
void expect_state_at_stamp(const render::Scene& scene, const std::vector<int>& instants_ms) {
  const WorldOptions options = options_with_arm(scene);
  Rig rig(scene, options);
  rig.enable();
  std::vector<HeadState> truth = {{rig.world.T_W_H(), rig.world.eye_angles()}};
  StereoFrame frame;
  for (int ms = 1; ms <= 89; ++ms) {
    rig.arm.command(kCommand);
    rig.eyes.command(kRates);
    rig.world.advance_to(ms * kMs);
    truth.push_back({rig.world.T_W_H(), rig.world.eye_angles()});
    if (ms < 89) (void)rig.camera.take(frame);
  }
  ASSERT_TRUE(rig.camera.take(frame));
  ASSERT_EQ(frame.sequence, 2U);
  ASSERT_EQ(frame.stamp_ns, 80 * kMs);
  std::vector<std::uint8_t> seen = bytes_of(frame.left);
  const std::vector<std::uint8_t> right = bytes_of(frame.right);
  seen.insert(seen.end(), right.begin(), right.end());
  std::vector<HeadState> at_stamp;
  std::vector<HeadState> late;
  for (const int ms : instants_ms) {
    at_stamp.push_back(truth[static_cast<std::size_t>(ms)]);
    late.push_back(truth[89]);
  }
  EXPECT_EQ(seen, picture_of(rig, options, 0.080, 2, at_stamp));
  EXPECT_NE(seen, picture_of(rig, options, 0.080, 2, late));
}

TEST(PlantWorld, PictureShowsWhatWasThereAtItsStamp) {
  expect_state_at_stamp(scene_of(kMarker), {80});
}

TEST(PlantWorld, PictureIsAveragedOverItsExposure) {
  render::Scene scene = scene_of(kMarker);
  scene.shutter_s = 0.012;
  scene.shutter_samples = 3;
  expect_state_at_stamp(scene, {74, 80, 86});
}

TEST(PlantWorld, PairsComeWhenTheyAreDueAndLostOnesLeaveAGap) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_of(scene);
  options.render = false;
  options.camera.fps = 30;
  options.camera.lost_spans_ns = {{60 * kMs, 110 * kMs}};
  Rig rig(scene, options);
  StereoFrame frame;
  std::vector<std::uint64_t> sequences;
  for (std::int64_t t_ns = 0; t_ns <= 200 * kMs; t_ns += kMs / 8) {
    rig.world.advance_to(t_ns);
    if (!rig.camera.take(frame)) continue;
    sequences.push_back(frame.sequence);
    EXPECT_GE(t_ns, frame.stamp_ns + 9 * kMs);
    EXPECT_LT(t_ns - kMs / 8, frame.stamp_ns + 9 * kMs);
    EXPECT_EQ(frame.left.data, nullptr);
    EXPECT_EQ(frame.right.data, nullptr);
  }
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{0, 1, 4, 5}));
  EXPECT_EQ(rig.world.pairs_lost(), 2U);
  EXPECT_EQ(rig.world.pairs_delivered(), 4U);
}

TEST(PlantWorld, PairInUseIsNotOverwritten) {
  const render::Scene scene = scene_of(kMarker);
  Rig rig(scene, options_of(scene));
  StereoFrame frame;
  rig.world.advance_to(10 * kMs);
  ASSERT_TRUE(rig.camera.take(frame));
  const std::vector<std::uint8_t> first = bytes_of(frame.left);
  rig.world.advance_to(50 * kMs);
  rig.world.advance_to(90 * kMs);
  rig.world.advance_to(130 * kMs);
  EXPECT_EQ(bytes_of(frame.left), first);
  ASSERT_TRUE(rig.camera.take(frame));
  EXPECT_EQ(frame.sequence, 3U);
  EXPECT_NE(bytes_of(frame.left), first);
}

TEST(PlantWorld, OneLongStepIsManyShortOnes) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_with_arm(scene);
  options.servo.watchdog_periods = 0;
  Rig one(scene, options);
  Rig many(scene, options);
  for (Rig* rig : {&one, &many}) {
    rig->enable();
    rig->world.advance_to(0);
    rig->arm.command(kCommand);
    rig->eyes.command(kRates);
  }
  one.world.advance_to(300 * kMs);
  for (int part = 1; part <= 900; ++part) many.world.advance_to(part * kMs / 3);
  EXPECT_EQ(one.world.T_W_H().t_mm, many.world.T_W_H().t_mm);
  EXPECT_EQ(one.world.eye_angles().pan_left_rad, many.world.eye_angles().pan_left_rad);
  StereoFrame a;
  StereoFrame b;
  ASSERT_TRUE(one.camera.take(a));
  ASSERT_TRUE(many.camera.take(b));
  EXPECT_EQ(a.sequence, 7U);
  EXPECT_EQ(b.sequence, 7U);
  EXPECT_EQ(bytes_of(a.left), bytes_of(b.left));
}

TEST(PlantWorld, RepeatedCommandsAreNotSilence) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_with_arm(scene);
  options.render = false;
  Rig rig(scene, options);
  rig.enable();
  ArmFeedback feedback;
  for (int ms = 2; ms <= 100; ms += 2) {
    rig.arm.command(kCommand);
    rig.world.advance_to(ms * kMs);
  }
  ASSERT_TRUE(rig.arm.read(feedback));
  EXPECT_EQ(feedback.state, ArmState::kEnabled);
  rig.world.advance_to(118 * kMs);
  ASSERT_TRUE(rig.arm.read(feedback));
  EXPECT_EQ(feedback.state, ArmState::kQuickStop);
  // The drives left on their own; the same request again brings them back.
  rig.arm.request(ArmRequest::kEnable);
  rig.world.advance_to(120 * kMs);
  ASSERT_TRUE(rig.arm.read(feedback));
  EXPECT_EQ(feedback.state, ArmState::kEnabled);
}

TEST(PlantWorld, HandWithoutAnArmStays) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_of(scene);
  options.render = false;
  options.T_W_H.t_mm = {1, 2, 3};
  Rig rig(scene, options);
  rig.enable();
  rig.arm.command(kCommand);
  rig.world.advance_to(100 * kMs);
  ArmFeedback feedback;
  EXPECT_FALSE(rig.arm.read(feedback));
  EXPECT_EQ(rig.world.T_W_H().t_mm, Vector3(1, 2, 3));
  EXPECT_THROW((void)rig.world.arm(), std::logic_error);
  EXPECT_THROW(rig.world.advance_to(99 * kMs), std::invalid_argument);
}

TEST(PlantWorld, TargetFollowsTheSceneOrAnotherPath) {
  const render::Scene scene = scene_of(kMarker);
  const WorldOptions options = options_with_arm(scene);
  Rig rig(scene, options);
  rig.world.advance_to(500 * kMs);
  const Transform T_S_M = to_transform(scene.target_motion.at(0.5));
  EXPECT_LT((rig.world.T_H_M().t_mm - T_S_M.t_mm).norm(), 1e-9);  // the hand stands at S
  StereoFrame frame;
  rig.world.advance_to(530 * kMs);  // stamped at 520 ms
  ASSERT_TRUE(rig.camera.take(frame));
  const std::vector<std::uint8_t> before = bytes_of(frame.left);
  Transform aside = options.T_W_S * T_S_M;
  aside.t_mm += options.T_W_S.R * Vector3(-100, 0, 0);
  rig.world.set_target([aside](double) { return aside; });
  EXPECT_EQ(rig.world.T_W_M(7).t_mm, aside.t_mm);
  rig.world.advance_to(570 * kMs);
  ASSERT_TRUE(rig.camera.take(frame));
  render::SceneState state = render::state_at(rig.world.scene(), 0.560);
  state.moments.front().T_W_H = options.T_W_S.inverse() * rig.world.T_W_H();
  state.moments.front().T_W_M = options.T_W_S.inverse() * aside;
  state.moments.front().eyes = rig.world.eye_angles();
  tools::RgbImage left;
  render::render_eye(rig.world.scene(), state, render::Eye::kLeft, render::hash(options.seed, 14), left);
  EXPECT_EQ(frame.sequence, 14U);
  EXPECT_EQ(bytes_of(frame.left), left.data);
  EXPECT_NE(before, left.data);
}

TEST(PlantWorld, EyesOnTheTargetMeetThere) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_with_arm(scene);
  options.render = false;
  const Vector3 target_H_mm(60, -40, 500);
  options.eyes.start = render::gaze_at(scene.rig, target_H_mm);
  for (StepperOptions& motor : options.eyes.motor) motor.steps_per_rad = 1e7;  // the rounding aside
  const Rig rig(scene, options);
  ASSERT_TRUE(rig.world.gaze_point_W_mm());
  EXPECT_LT((*rig.world.gaze_point_W_mm() - rig.world.T_W_H() * target_H_mm).norm(), 1e-3);
  options.eyes.start = {0, -0.1, -0.1};
  const Rig diverging(scene, options);
  EXPECT_FALSE(diverging.world.gaze_point_W_mm());
}

TEST(PlantWorld, RefusesAnExposureThatEndsAtDelivery) {
  const render::Scene scene = scene_of(kMarker);
  WorldOptions options = options_of(scene);
  options.camera.exposure_ns = 18 * kMs;
  EXPECT_THROW(Rig(scene, options), std::invalid_argument);
}

}  // namespace
}  // namespace vergence::plant
