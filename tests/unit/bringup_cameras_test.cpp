// Cameras: every verdict, and watching cameras in memory, with pictures painted into their buffers.
#include <linux/videodev2.h>

#include <functional>

#include "tests/support/fake_video_system.hpp"
#include "tests/support/findings.hpp"
#include "tools/bringup/camera_checks.hpp"
#include "tools/bringup/light_watch.hpp"
#include "tools/bringup/picture.hpp"
#include "tools/bringup/watch_cameras.hpp"

namespace vergence::tools {
namespace {

using testing::expect_all_pass;
using testing::expect_complete;
using testing::expect_finding;
using testing::FakeVideoDevice;
using testing::FakeVideoSystem;

constexpr auto kExposure = static_cast<std::size_t>(v4l2::ControlRole::kExposure);

// ---- cameras in memory
// --------------------------------------------------------------------------------------

// Lets things happen before each wait, and paints what came by it.
class PaintedSystem final : public v4l2::VideoSystem {
 public:
  FakeVideoSystem fake;
  std::function<void(std::int64_t now_ns)> meanwhile;
  std::function<void(std::int64_t now_ns)> painter;

  int open(const char* path, int& handle) override { return fake.open(path, handle); }
  void close(int handle) override { fake.close(handle); }
  int control(int handle, unsigned long request, void* argument) override {
    return fake.control(handle, request, argument);
  }
  int poll(std::span<v4l2::PollEntry> entries, std::int64_t timeout_ns) override {
    if (meanwhile) meanwhile(fake.now_ns());
    const int error = fake.poll(entries, timeout_ns);
    if (painter) painter(fake.now_ns());
    return error;
  }
  int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) override {
    return fake.map(handle, bytes, offset, memory);
  }
  int map_own(std::size_t bytes, std::uint8_t*& memory) override { return fake.map_own(bytes, memory); }
  void unmap(std::uint8_t* memory, std::size_t bytes) override { fake.unmap(memory, bytes); }
};

// One colour, in YUYV, into the buffers that are to be taken.
void paint(FakeVideoDevice& device, std::uint8_t y, std::uint8_t u, std::uint8_t v) {
  for (FakeVideoDevice::Buffer& buffer : device.buffers) {
    if (!buffer.is_done || !buffer.is_queued) continue;
    std::vector<std::uint8_t>& bytes = *buffer.planes[0];
    for (std::size_t i = 0; i + 3 < bytes.size(); i += 4) {
      bytes[i] = bytes[i + 2] = y;
      bytes[i + 1] = u;
      bytes[i + 3] = v;
    }
  }
}

class WatchedCameras : public ::testing::Test {
 protected:
  WatchedCameras() {
    right.path = "/dev/video1";
    for (FakeVideoDevice* device : {&left, &right}) {
      device->controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY};
      device->controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {
          1, 1000, 100, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, 156, 1};
    }
    system.fake.devices = {&left, &right};
    config.eyes = {testing::config_of(left), testing::config_of(right)};
    for (v4l2::VideoConfig& eye : config.eyes)
      eye.controls[kExposure].mode = v4l2::ControlMode::kAutoThenLock;
    system.painter = [this](std::int64_t) { paint_both(); };
  }
  void paint_both() {
    paint(left, 120, 90, 200);
    paint(right, 120, 90, 200);
  }
  [[nodiscard]] CameraObservation watch(double seconds = 3) {
    CameraObservation seen = watch_cameras(system, config, seconds, [this] { return system.fake.now_ns(); });
    EXPECT_EQ(system.fake.open_handles(), 0U);
    EXPECT_EQ(system.fake.live_maps(), 0U);
    return seen;
  }
  [[nodiscard]] std::vector<Finding> judged(double seconds = 3) {
    const std::vector<Finding> findings = judge(watch(seconds), config);
    expect_complete(findings);
    return findings;
  }

  FakeVideoDevice left;
  FakeVideoDevice right;
  PaintedSystem system;
  v4l2::StereoVideoConfig config;
};

TEST_F(WatchedCameras, PassWhereBothAreWell) {
  const CameraObservation seen = watch();
  ASSERT_NEAR(static_cast<double>(seen.eyes[0].frames.size()), 90, 2);
  EXPECT_EQ(seen.eyes[1].picture.width_px, 640);
  const auto rgb = seen.eyes[1].picture.at(320, 240);
  EXPECT_GT(rgb[0], 200);  // red, as painted
  EXPECT_LT(rgb[1], 100);
  const auto findings = judge(seen, config);
  expect_complete(findings);
  expect_finding(findings, "left opens", Outcome::kPass, "/dev/video0");
  expect_finding(findings, "right format", Outcome::kPass, "YUYV 640 x 480");
  expect_finding(findings, "left rate", Outcome::kPass, "30.00 /s of 30.00, jitter 0.00 ms");
  expect_finding(findings, "left frames", Outcome::kPass, "0 lost");
  expect_finding(findings, "left exposure", Outcome::kPass, "held at 156");
  expect_finding(findings, "left gain", Outcome::kSkipped, "", "no such control");
  expect_finding(findings, "left brightness", Outcome::kPass, "drift +0.0 %");
  expect_finding(findings, "right hue", Outcome::kPass, "noise 0.0 deg");
  expect_finding(findings, "skew of the pair", Outcome::kPass, "median 0.00 ms");
}

TEST_F(WatchedCameras, AMissingCameraFailsAndTheOtherIsStillWatched) {
  system.fake.devices = {&right};
  const std::int64_t begun_ns = system.fake.now_ns();
  const auto findings = judged();
  expect_finding(findings, "left opens", Outcome::kFail, "No such file", "by-path");
  expect_finding(findings, "left hue", Outcome::kSkipped);
  expect_finding(findings, "right rate", Outcome::kPass);
  expect_finding(findings, "skew of the pair", Outcome::kSkipped);
  EXPECT_LT(system.fake.now_ns() - begun_ns, 10'000'000'000);
}

TEST_F(WatchedCameras, NoCameraAtAllEndsSoon) {
  system.fake.devices.clear();
  const auto findings = judged(3600);
  expect_finding(findings, "left opens", Outcome::kFail);
  expect_finding(findings, "right opens", Outcome::kFail);
  EXPECT_LT(system.fake.now_ns(), 10'000'000'000);
}

TEST_F(WatchedCameras, AFormatTheCameraLacksIsNamed) {
  left.fourccs = {V4L2_PIX_FMT_MJPEG};
  expect_finding(judged(), "left opens", Outcome::kFail, "asked YUYV, got MJPG", "choose YUYV");
}

TEST_F(WatchedCameras, BadConfigurationIsNamed) {
  config.eyes[1].buffers = 1;
  expect_finding(judged(), "right opens", Outcome::kFail, "buffers: asked 1, got 5", "5 to 8");
}

TEST_F(WatchedCameras, ASlowCameraIsSeenByItsStamps) {
  left.period_ns = 40'000'000;
  const auto findings = judged();
  expect_finding(findings, "left rate", Outcome::kFail, "25.00 /s of 30.00", "exposure");
  expect_finding(findings, "right rate", Outcome::kPass);
}

TEST_F(WatchedCameras, LostAndDamagedFramesAreCounted) {
  system.meanwhile = [this, done = false](std::int64_t now_ns) mutable {
    if (done || now_ns < 4'000'000'000) return;
    done = true;
    left.skips = 2;
    right.flagged = 1;
  };
  const auto findings = judged(8);
  expect_finding(findings, "left frames", Outcome::kWarn, "2 lost, 0 damaged", "cable");
  expect_finding(findings, "right frames", Outcome::kWarn, "1 damaged");
}

TEST_F(WatchedCameras, AnUnpluggedCameraFails) {
  system.meanwhile = [this, done = false](std::int64_t now_ns) mutable {
    if (done || now_ns < 4'000'000'000) return;
    done = true;
    right.unplug();
  };
  const auto findings = judged(5);
  expect_finding(findings, "right frames", Outcome::kFail, "", "No such");
  expect_finding(findings, "left frames", Outcome::kPass);
}

TEST_F(WatchedCameras, SkewIsMeasured) {
  right.next_frame_ns += 12'000'000;
  expect_finding(judged(), "skew of the pair", Outcome::kFail, "median 12.00 ms", "trigger");
}

TEST_F(WatchedCameras, DriftOfFreeCamerasIsMeasured) {
  right.period_ns = 33'340'000;  // 0.2 ms more each second
  expect_finding(judged(10), "skew of the pair", Outcome::kWarn, "drift -20", "drift apart");
}

TEST_F(WatchedCameras, AControlThatDoesNotStayIsSeen) {
  system.meanwhile = [this](std::int64_t now_ns) {
    if (now_ns < 4'000'000'000) return;
    left.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_APERTURE_PRIORITY;
    right.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value = 157;
  };
  const auto findings = judged(5);
  expect_finding(findings, "left exposure", Outcome::kFail, "automatic again", "another program");
  expect_finding(findings, "right exposure", Outcome::kFail, "held at 156, now 157");
}

TEST_F(WatchedCameras, AnAutomaticThatIsLeftOnIsAWarning) {
  for (v4l2::VideoConfig& eye : config.eyes) eye.controls[kExposure].mode = v4l2::ControlMode::kLeave;
  expect_finding(judged(), "left exposure", Outcome::kWarn, "automatic, now 156", "auto_then_lock");
}

TEST_F(WatchedCameras, DriftingLightAndHueAreSeen) {
  system.painter = [this](std::int64_t now_ns) {
    const auto tenths = static_cast<int>(now_ns / 100'000'000);
    paint(left, static_cast<std::uint8_t>(100 + tenths / 5), 90, 200);
    paint(right, 120, static_cast<std::uint8_t>(90 + tenths / 4), 200);
  };
  const auto findings = judged(8);
  expect_finding(findings, "left brightness", Outcome::kWarn, "", "automatic exposure");
  expect_finding(findings, "right hue", Outcome::kWarn, "", "white balance");
}

TEST_F(WatchedCameras, AGreySceneTellsNothingOfHue) {
  system.painter = [this](std::int64_t) {
    paint(left, 120, 128, 128);
    paint(right, 120, 128, 128);
  };
  expect_finding(judged(), "left hue", Outcome::kWarn, "0.00 % of the picture", "put the target");
}

// ---- verdicts on what was made up
// ---------------------------------------------------------------------------

v4l2::StereoVideoConfig config_of_pair() {
  v4l2::StereoVideoConfig config;
  for (v4l2::VideoConfig& eye : config.eyes) eye = testing::config_of(FakeVideoDevice{});
  return config;
}

CameraObservation sound_pair() {
  CameraObservation seen;
  for (EyeObservation& eye : seen.eyes) {
    eye.streamed = true;
    eye.format.fourcc = V4L2_PIX_FMT_YUYV;
    eye.format.width_px = 640;
    eye.format.height_px = 480;
    eye.counts.frames = 100;
    for (std::uint64_t i = 0; i < 100; ++i)
      eye.frames.push_back({i, static_cast<std::int64_t>(i) * 33'333'333});
    for (const v4l2::ControlRole role :
         {v4l2::ControlRole::kExposure, v4l2::ControlRole::kGain, v4l2::ControlRole::kWhiteBalance}) {
      const auto i = static_cast<std::size_t>(role);
      eye.first[i] = eye.last[i] = {true, 50, true, false};
    }
    eye.light = {100, 120, 0, 0.001, 0, 0.3, 1, 0};
  }
  return seen;
}

struct Case {
  const char* name;
  std::function<void(EyeObservation&)> change;  // of the left eye
  const char* check;
  Outcome outcome;
  const char* remedy;
};

const Case kCases[] = {
    {"OtherSize", [](auto& e) { e.format.width_px = 320; }, "left format", Outcome::kFail, "list-formats"},
    {"FewFrames", [](auto& e) { e.frames.resize(9); }, "left rate", Outcome::kFail, "--seconds"},
    {"StampsStandStill",
     [](auto& e) {
       for (SeenFrame& f : e.frames) f.stamp_ns = 5;
     },
     "left rate", Outcome::kFail, "exposure"},
    {"SlightlySlow",
     [](auto& e) {
       for (SeenFrame& f : e.frames) f.stamp_ns = static_cast<std::int64_t>(f.number) * 34'500'000;
     },
     "left rate", Outcome::kWarn, "frames_per_s"},
    {"Jitter",
     [](auto& e) {
       for (SeenFrame& f : e.frames) f.stamp_ns += f.number % 2 == 0 ? 0 : 3'000'000;
     },
     "left rate", Outcome::kWarn, "uneven"},
    {"ManyLost", [](auto& e) { e.counts.lost = 5; }, "left frames", Outcome::kFail, "cable"},
    {"Restarted", [](auto& e) { e.counts.restarts = 1; }, "left frames", Outcome::kFail, "cable"},
    {"LeftAloneButChanged", [](auto& e) { e.last[kExposure].value = 51; }, "left exposure", Outcome::kWarn,
     "auto_then_lock"},
    {"Dark", [](auto& e) { e.light.mean_luma = 20; }, "left brightness", Outcome::kWarn, "too dark"},
    {"Bright", [](auto& e) { e.light.mean_luma = 230; }, "left brightness", Outcome::kWarn, "too bright"},
    {"Clipped", [](auto& e) { e.light.clipped_share = 0.2; }, "left brightness", Outcome::kWarn, "no lamp"},
    {"Flicker", [](auto& e) { e.light.luma_flicker = 0.05; }, "left brightness", Outcome::kWarn, "mains"},
    {"Drift", [](auto& e) { e.light.luma_drift = -0.05; }, "left brightness", Outcome::kWarn,
     "automatic exposure"},
    {"HueNoise", [](auto& e) { e.light.hue_noise_deg = 15; }, "left hue", Outcome::kWarn, "less gain"},
    {"HueDrift", [](auto& e) { e.light.hue_drift_deg = -5; }, "left hue", Outcome::kWarn, "white balance"},
};

void PrintTo(const Case& its, std::ostream* out) {
  *out << its.name;
}

class CameraVerdicts : public ::testing::TestWithParam<Case> {};

TEST_P(CameraVerdicts, AreAsTheyShouldBe) {
  const v4l2::StereoVideoConfig config = config_of_pair();
  CameraObservation seen = sound_pair();
  expect_all_pass(judge(seen, config));
  GetParam().change(seen.eyes[0]);
  const auto findings = judge(seen, config);
  expect_complete(findings);
  expect_finding(findings, GetParam().check, GetParam().outcome, "", GetParam().remedy);
}

INSTANTIATE_TEST_SUITE_P(Cases, CameraVerdicts, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(CameraVerdictsOfControls, AValueThatWasSetMustBeHeld) {
  v4l2::StereoVideoConfig config = config_of_pair();
  config.eyes[0].controls[kExposure] = {v4l2::ControlMode::kSet, 50};
  CameraObservation seen = sound_pair();
  expect_finding(judge(seen, config), "left exposure", Outcome::kPass, "held at 50");
  config.eyes[0].controls[kExposure].value = 60;
  expect_finding(judge(seen, config), "left exposure", Outcome::kFail, "held at 60, now 50");
  seen.eyes[0].last[kExposure].exists = false;
  expect_finding(judge(seen, config), "left exposure", Outcome::kFail, "does not answer");
}

TEST(SkewOf, TakesTheNearestPartner) {
  std::vector<SeenFrame> left;
  std::vector<SeenFrame> right;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const auto t_ns = static_cast<std::int64_t>(i) * 33'000'000;
    if (i != 20) left.push_back({i, t_ns});  // one is lost
    right.push_back({i, t_ns - 3'000'000 + (i == 30 ? 2'000'000 : 0)});
  }
  const Skew skew = skew_of(left, right);
  EXPECT_EQ(skew.pairs, 38U);  // the last has no later partner
  EXPECT_DOUBLE_EQ(skew.median_ms, 3);
  EXPECT_DOUBLE_EQ(skew.largest_ms, 3);
  EXPECT_DOUBLE_EQ(skew.drift_us_per_s, 0);
  EXPECT_EQ(skew_of(left, {}).pairs, 0U);
  EXPECT_EQ(skew_of({}, right).pairs, 0U);
}

TEST(LightWatchTest, MeasuresBrightnessAndHue) {
  RgbImage image(64, 64);
  const auto fill = [&](std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    for (std::size_t i = 0; i < image.data.size(); i += 3) {
      image.data[i] = r;
      image.data[i + 1] = g;
      image.data[i + 2] = b;
    }
  };
  LightWatch watch;
  EXPECT_EQ(watch.summary().frames, 0U);
  fill(200, 50, 50);
  watch.look(image.view());
  fill(200, 75, 50);  // 10 degrees on
  watch.look(image.view());
  fill(200, 50, 75);  // 10 degrees back, across zero
  watch.look(image.view());
  const LightSummary summary = watch.summary();
  EXPECT_EQ(summary.frames, 3U);
  EXPECT_NEAR(summary.mean_luma, 0.299 * 200 + 0.587 * 58.3 + 0.114 * 58.3, 0.1);
  EXPECT_DOUBLE_EQ(summary.coloured_share, 1);
  EXPECT_NEAR(summary.hue_noise_deg, 10, 0.2);
  EXPECT_NEAR(summary.hue_drift_deg, -10, 0.2);
  EXPECT_DOUBLE_EQ(summary.clipped_share, 0);
  fill(255, 255, 255);
  watch.look(image.view());
  EXPECT_DOUBLE_EQ(watch.summary().clipped_share, 0.25);
  EXPECT_GT(watch.summary().luma_drift, 1);
}

TEST(Picture, IsInTheSameColoursInEveryFormat) {
  const std::array<std::uint8_t, 4> yuyv = {100, 90, 140, 200};
  const std::array<std::uint8_t, 4> uyvy = {90, 100, 200, 140};
  const std::array<std::uint8_t, 4> luma = {100, 140, 100, 140};
  const std::array<std::uint8_t, 2> chroma = {90, 200};
  const ImageView as_yuyv{yuyv.data(), 2, 1, 4, PixelFormat::kYuyv, nullptr, 0};
  const ImageView as_uyvy{uyvy.data(), 2, 1, 4, PixelFormat::kUyvy, nullptr, 0};
  const ImageView as_nv12{luma.data(), 2, 2, 2, PixelFormat::kNv12, chroma.data(), 2};
  const std::array<std::uint8_t, 3> expected = {201, 62, 33};  // 100 + 1.402 * 72, ...
  EXPECT_EQ(rgb_at(as_yuyv, 0, 0), expected);
  for (int x = 0; x < 2; ++x) {
    EXPECT_EQ(rgb_at(as_yuyv, x, 0), rgb_at(as_uyvy, x, 0));
    EXPECT_EQ(rgb_at(as_yuyv, x, 0), rgb_at(as_nv12, x, 1));
  }
  EXPECT_EQ(rgb_of(as_yuyv).data.size(), 6U);
}

}  // namespace
}  // namespace vergence::tools
