// One camera's faults, each handled: left out, recovered from by a restart, or reported, within a bounded
// time.
#include <gtest/gtest.h>

#include "hal/v4l2/capture.hpp"
#include "tests/support/fake_video_system.hpp"

namespace vergence::v4l2 {
namespace {

constexpr std::int64_t kMs = 1'000'000;

class V4l2Capture : public ::testing::Test {
 protected:
  V4l2Capture() { system.devices = {&device}; }

  void start(const VideoConfig& config) {
    ASSERT_TRUE(is_ok(capture.configure(system, config)));
    capture.start(system.now_ns());
  }
  void start() { start(config_of(device)); }

  // As the capturing thread does it; every frame is looked at and given back at once.
  void run(std::int64_t span_ns) {
    for (const std::int64_t end_ns = system.now_ns() + span_ns; system.now_ns() < end_ns;) {
      std::array<PollEntry, 1> entries{{{capture.handle_to_poll(), 0}}};
      const std::int64_t until_ns = std::min({capture.deadline_ns(), end_ns, system.now_ns() + kMaxWait_ns});
      ASSERT_EQ(system.poll(entries, std::max<std::int64_t>(until_ns - system.now_ns(), 0)), 0);
      CapturedFrame frame;
      while (entries[0].happened != 0 && capture.next(system.now_ns(), frame)) {
        stamps.push_back(frame.stamp_ns);
        numbers.push_back(frame.number);
        capture.give_back(system.now_ns(), frame.buffer);
      }
      capture.tend(system.now_ns(), entries[0].happened);
    }
  }
  [[nodiscard]] const CaptureCounts& counts() const { return capture.counts(); }

  testing::FakeVideoDevice device;
  testing::FakeVideoSystem system;
  Capture capture;
  std::vector<std::int64_t> stamps;
  std::vector<std::uint64_t> numbers;
};

TEST_F(V4l2Capture, GivesEveryFrameOfAHealthyCamera) {
  VideoConfig config = config_of(device);
  config.stamp_to_mid_exposure_ns = -7 * kMs;
  start(config);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
  run(1000 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_EQ(stamps.size(), 30U);
  EXPECT_EQ(stamps[0], -2 * kMs);
  EXPECT_EQ(stamps[1] - stamps[0], 33'333'000);  // the kernel stamps in microseconds
  EXPECT_EQ(numbers.back() - numbers.front(), 29U);
  EXPECT_EQ(counts().restarts, 0U);
  EXPECT_EQ(counts().recoveries, 0U);
  EXPECT_LT(system.polls, 40);  // it sleeps in between
  capture.stop();
  EXPECT_EQ(system.open_handles(), 0U);
  EXPECT_EQ(system.live_maps(), 0U);
}

TEST_F(V4l2Capture, LeavesFlaggedFramesOut) {
  start();
  run(200 * kMs);
  device.flagged = 3;
  run(300 * kMs);
  EXPECT_EQ(counts().flagged, 3U);
  EXPECT_EQ(counts().frames, 12U);
  EXPECT_EQ(counts().restarts, 0U);
  EXPECT_EQ(numbers.back() - numbers.front(), 14U);  // they are frames that were lost
}

TEST_F(V4l2Capture, FlaggedFramesWithoutEndAreAStall) {
  start();
  run(200 * kMs);
  device.flagged = 1000;
  run(300 * kMs);
  EXPECT_EQ(counts().stalls, 1U);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
}

TEST_F(V4l2Capture, LeavesIncompleteFramesOut) {
  start();
  run(200 * kMs);
  device.incomplete = 2;
  run(300 * kMs);
  EXPECT_EQ(counts().incomplete, 2U);
  EXPECT_EQ(counts().frames, 13U);
}

TEST_F(V4l2Capture, CountsGapsOfTheSequence) {
  device.sequence = 0xFFFFFFFE;
  start();
  run(200 * kMs);
  device.skips = 4;
  run(100 * kMs);
  EXPECT_EQ(counts().gaps, 1U);
  EXPECT_EQ(counts().lost, 4U);
  EXPECT_EQ(numbers.back() - numbers.front(), numbers.size() - 1 + 4);
  device.skips = 0U - 3U;  // back: a driver's fault, not four thousand million lost frames
  run(100 * kMs);
  EXPECT_EQ(counts().gaps, 2U);
  EXPECT_EQ(counts().lost, 4U);
}

TEST_F(V4l2Capture, SequenceNumbersMayComeRoundToZero) {
  start();
  run(50 * kMs);
  device.sequence = 0xFFFFFFFE;
  run(50 * kMs);  // one gap, of that jump
  const std::uint64_t gaps = counts().gaps;
  run(200 * kMs);
  EXPECT_EQ(counts().gaps, gaps);
}

TEST_F(V4l2Capture, LeavesFramesWithImpossibleStampsOut) {
  start();
  run(200 * kMs);
  const std::size_t before = stamps.size();
  for (const std::int64_t wrong_ns : {3'600'000 * kMs, -11'000 * kMs}) {
    device.stamp_offset_ns = wrong_ns;
    run(66 * kMs);
  }
  EXPECT_EQ(counts().bad_stamps, 4U);
  EXPECT_EQ(stamps.size(), before);
  EXPECT_EQ(counts().restarts, 0U);
}

TEST_F(V4l2Capture, GivesUpADriverThatStampsByAnotherClock) {
  device.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_COPY;
  start();
  run(50 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kFault);
  EXPECT_EQ(capture.error().fault, VideoFault::kStampClock);
}

TEST_F(V4l2Capture, RestartsTheStreamAfterEio) {
  start();
  run(500 * kMs);
  device.errors_once[VIDIOC_DQBUF] = EIO;
  run(100 * kMs);
  EXPECT_EQ(counts().stream_errors, 1U);
  EXPECT_EQ(device.streams_begun, 2);
  EXPECT_EQ(counts().openings, 1U);  // the device stays open
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_EQ(capture.error().fault, VideoFault::kStream);
  run(500 * kMs);
  EXPECT_EQ(counts().recoveries, 1U);
}

TEST_F(V4l2Capture, RestartsWherePollReportsAnErrorAndNothingElse) {
  start();
  run(500 * kMs);
  device.has_error_state = true;
  run(500 * kMs);
  EXPECT_EQ(counts().stream_errors, 1U);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_LT(system.polls, 60);  // not asked again and again
}

TEST_F(V4l2Capture, RestartsAStreamThatStalls) {
  start();
  run(500 * kMs);
  device.stalls = true;
  run(230 * kMs);
  EXPECT_EQ(counts().stalls, 1U);
  EXPECT_EQ(device.streams_begun, 2);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
  device.stalls = false;
  run(100 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
}

TEST_F(V4l2Capture, OpensTheDeviceAnewWhereRestartingTheStreamDidNotHelp) {
  start();
  run(500 * kMs);
  device.stalls = true;
  run(1500 * kMs);  // 200 ms, then 1 s for the first frame
  EXPECT_EQ(counts().stalls, 2U);
  EXPECT_EQ(counts().openings, 2U);
}

TEST_F(V4l2Capture, GivesUpWithinItsTime) {
  start();
  run(500 * kMs);
  const std::int64_t last_ns = stamps.back();
  device.stalls = true;
  std::int64_t fault_ns = 0;
  while (capture.state() != CaptureState::kFault && system.now_ns() < 20'000 * kMs) run(kMs);
  fault_ns = system.now_ns();
  EXPECT_EQ(capture.camera_state(), CameraState::kFault);
  EXPECT_EQ(capture.error().fault, VideoFault::kStalled);
  // The stall is seen after 200 ms; from then on, 5 s.
  EXPECT_NEAR(static_cast<double>(fault_ns - last_ns), 5200e6, 5e6);
  EXPECT_EQ(capture.handle_to_poll(), -1);
  device.stalls = false;
  run(1000 * kMs);
  EXPECT_EQ(capture.state(), CaptureState::kFault);  // until it is told to
  capture.start(system.now_ns());
  run(500 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
}

// A frame now and then between stalls is no recovery: without that, it would go on for ever.
TEST_F(V4l2Capture, GivesUpAStreamThatComesAndGoes) {
  start();
  run(1000 * kMs);
  for (int i = 0; i < 40; ++i) {
    device.stalls = true;
    run(250 * kMs);
    device.stalls = false;
    run(70 * kMs);
  }
  EXPECT_EQ(capture.state(), CaptureState::kFault);
  EXPECT_EQ(counts().recoveries, 0U);
}

TEST_F(V4l2Capture, ComesBackAfterUnplugging) {
  device.controls[V4L2_CID_GAIN] = {0, 64, 0};
  VideoConfig config = config_of(device);
  config.controls[static_cast<std::size_t>(ControlRole::kGain)] = {ControlMode::kSet, 16};
  start(config);
  run(500 * kMs);
  device.unplug();
  run(1000 * kMs);
  EXPECT_GE(counts().unplugged, 1U);
  EXPECT_EQ(capture.error().fault, VideoFault::kOpen);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
  EXPECT_EQ(system.open_handles(), 0U);
  device.plug();
  run(1000 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_EQ(counts().openings, 2U);
  EXPECT_EQ(counts().recoveries, 1U);
  EXPECT_EQ(device.controls[V4L2_CID_GAIN].value, 16);
  for (std::size_t i = 1; i < numbers.size(); ++i) EXPECT_GT(numbers[i], numbers[i - 1]);
}

TEST_F(V4l2Capture, EnodevOfAnyCallIsUnplugging) {
  for (const unsigned long request : {VIDIOC_DQBUF, VIDIOC_QBUF}) {
    capture.stop();
    start();
    run(500 * kMs);
    device.errors_once[request] = ENODEV;
    run(100 * kMs);
    EXPECT_EQ(counts().unplugged, 1U);
    EXPECT_EQ(counts().openings, 2U);
  }
}

TEST_F(V4l2Capture, ReportsACameraThatNeverComes) {
  device.is_present = false;
  start();
  run(4900 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
  EXPECT_LT(system.polls, 100);  // it backs off
  run(200 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kFault);
  EXPECT_EQ(capture.error().fault, VideoFault::kOpen);
  EXPECT_EQ(capture.error().error_number, ENOENT);
}

TEST_F(V4l2Capture, WaitsForACameraThatComesLate) {
  device.is_present = false;
  start();
  run(3000 * kMs);
  device.is_present = true;
  run(1000 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
}

TEST_F(V4l2Capture, ReportsAtOnceWhatTryingAgainDoesNotMend) {
  device.sizes = {{320, 240}};
  start();
  run(kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kFault);
  EXPECT_EQ(capture.error().fault, VideoFault::kSize);
  EXPECT_EQ(system.open_handles(), 0U);
}

TEST_F(V4l2Capture, TriesAgainWhereTheBusWasFullOrTheDriverBusy) {
  for (const unsigned long request : {VIDIOC_STREAMON, VIDIOC_QBUF, VIDIOC_REQBUFS, VIDIOC_S_FMT}) {
    capture.stop();
    device.errors_once[request] = EBUSY;
    start();
    run(500 * kMs);
    EXPECT_EQ(capture.camera_state(), CameraState::kOk);
    EXPECT_EQ(counts().restarts, 1U);
  }
}

TEST_F(V4l2Capture, RestartsWhereABufferIsNotTakenBack) {
  start();
  run(500 * kMs);
  device.errors_once[VIDIOC_QBUF] = EIO;
  run(500 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_EQ(counts().stream_errors, 1U);
  EXPECT_EQ(capture.error().fault, VideoFault::kQueue);
  EXPECT_EQ(capture.ring().queued(), kMaxVideoBuffers);  // none is lost
}

TEST_F(V4l2Capture, SettlesOnceThenLocks) {
  device.controls[V4L2_CID_AUTOGAIN] = {0, 1, 0};
  device.controls[V4L2_CID_GAIN] = {0, 64, 0, V4L2_CID_AUTOGAIN, 0, 23};
  VideoConfig config = config_of(device);
  config.controls[static_cast<std::size_t>(ControlRole::kGain)] = {ControlMode::kAutoThenLock, 0};
  config.settle_ns = 1000 * kMs;
  start(config);
  run(990 * kMs);
  EXPECT_EQ(capture.state(), CaptureState::kSettling);
  EXPECT_EQ(capture.camera_state(), CameraState::kRestarting);
  EXPECT_TRUE(stamps.empty());
  EXPECT_EQ(device.controls[V4L2_CID_AUTOGAIN].value, 1);
  run(100 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
  EXPECT_EQ(counts().settling, 30U);
  EXPECT_EQ(device.controls[V4L2_CID_AUTOGAIN].value, 0);
  EXPECT_EQ(device.controls[V4L2_CID_GAIN].value, 23);
  device.unplug();
  run(100 * kMs);
  device.plug();
  run(300 * kMs);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);  // without settling again
  EXPECT_EQ(device.controls[V4L2_CID_GAIN].value, 23);
}

TEST_F(V4l2Capture, DoesNotOpenAnewWhileABufferIsHeld) {
  start();
  std::array<PollEntry, 1> entries{};
  capture.tend(0, 0);
  entries[0].handle = capture.handle_to_poll();
  ASSERT_EQ(system.poll(entries, 100 * kMs), 0);
  CapturedFrame held;
  ASSERT_TRUE(capture.next(system.now_ns(), held));
  const std::uint8_t first = held.image.data[0];
  device.unplug();
  run(100 * kMs);
  device.plug();
  run(500 * kMs);
  EXPECT_TRUE(capture.wants_buffers_back());
  EXPECT_EQ(counts().openings, 1U);
  EXPECT_EQ(held.image.data[0], first);  // still there to be read
  capture.give_back(system.now_ns(), held.buffer);
  run(500 * kMs);
  EXPECT_EQ(counts().openings, 2U);
  EXPECT_EQ(capture.camera_state(), CameraState::kOk);
}

}  // namespace
}  // namespace vergence::v4l2
