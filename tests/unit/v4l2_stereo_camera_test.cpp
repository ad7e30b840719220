// Both eyes together: pairs handed over where the driver put them, recalled when a camera goes, counted.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "hal/v4l2/v4l2_stereo_camera.hpp"
#include "tests/support/fake_video_system.hpp"

namespace vergence::v4l2 {
namespace {

constexpr std::int64_t kMs = 1'000'000;

class V4l2StereoCameraTest : public ::testing::Test {
 protected:
  V4l2StereoCameraTest() {
    right.path = "/dev/video2";
    right.next_frame_ns = 7 * kMs;
    system.devices = {&left, &right};
    config.eyes = {config_of(left), config_of(right)};
  }
  void start() {
    int side = 0;
    ASSERT_TRUE(is_ok(camera.configure(system, config, side)));
    camera.start(system.now_ns());
  }
  // The reader looks each time the capturing thread has run.
  void run(std::int64_t span_ns, bool reads = true) {
    for (const std::int64_t end_ns = system.now_ns() + span_ns; system.now_ns() < end_ns;) {
      const std::int64_t before_ns = system.now_ns();
      camera.run_once(system);
      EXPECT_LE(system.now_ns() - before_ns, kMaxWait_ns);
      if (!reads || !camera.take(frame)) continue;
      ++taken;
      EXPECT_GT(frame.stamp_ns, last_stamp_ns);
      EXPECT_GT(frame.sequence, last_sequence);
      last_stamp_ns = frame.stamp_ns;
      lost += frame.sequence - last_sequence - 1;
      last_sequence = frame.sequence;
    }
  }
  StereoVideoReport report() {
    StereoVideoReport newest;
    EXPECT_TRUE(camera.report(newest));
    return newest;
  }

  testing::FakeVideoDevice left;
  testing::FakeVideoDevice right;
  testing::FakeVideoSystem system;
  StereoVideoConfig config;
  V4l2StereoCamera camera;
  StereoFrame frame;
  int taken = 0;
  std::uint64_t lost = 0;
  std::int64_t last_stamp_ns = 0;
  std::uint64_t last_sequence = 0;
};

TEST_F(V4l2StereoCameraTest, GivesEveryPairOfHealthyCameras) {
  start();
  EXPECT_EQ(camera.state(), CameraState::kRestarting);
  run(1000 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kOk);
  EXPECT_EQ(taken, 30);
  EXPECT_EQ(lost, 0U);
  EXPECT_EQ(frame.left.width_px, 640);
  EXPECT_EQ(frame.left.data[0], 29);
  EXPECT_EQ(frame.right.data[0], 29);
  EXPECT_EQ(frame.stamp_ns, 6 * kMs + 966'666'000);  // between both
  const StereoVideoReport said = report();
  EXPECT_EQ(said.pairing.pairs, 30U);
  EXPECT_EQ(said.formats[1].interval_ns, 33'333'333);
  EXPECT_LE(system.longest_poll_ns, kMaxWait_ns);
  EXPECT_FALSE(camera.take(frame));
}

TEST_F(V4l2StereoCameraTest, AFrameStaysUntilTheNextTake) {
  start();
  run(500 * kMs);
  const std::uint8_t number = frame.left.data[0];
  run(1000 * kMs, false);
  for (std::size_t i = 0; i < 480 * frame.left.stride_bytes; ++i) {
    ASSERT_EQ(frame.left.data[i], number);
    ASSERT_EQ(frame.right.data[i], number);
  }
  const std::uint64_t passed_over = report().pairs_passed_over;
  EXPECT_GT(passed_over, 25U);
  ASSERT_TRUE(camera.take(frame));  // the newest, not the oldest
  EXPECT_EQ(frame.left.data[0], number + passed_over + 1);
  EXPECT_EQ(camera.state(), CameraState::kOk);
}

TEST_F(V4l2StereoCameraTest, FramesFurtherApartThanTheSkewMakeNoPair) {
  right.next_frame_ns = 16 * kMs;
  start();
  run(1000 * kMs);
  EXPECT_EQ(taken, 0);
  const StereoVideoReport said = report();
  EXPECT_GT(said.pairing.unpaired[0], 25U);
  EXPECT_EQ(said.eyes[0].restarts, 0U);
}

TEST_F(V4l2StereoCameraTest, WhatOneEyeLosesIsAPairLost) {
  start();
  run(500 * kMs);
  left.flagged = 2;
  run(300 * kMs);
  EXPECT_EQ(lost, 2U);
  EXPECT_EQ(report().pairing.unpaired[1], 2U);
}

TEST_F(V4l2StereoCameraTest, AnUnpluggedEyeComesBackAndTheReaderKeepsNothingOfIt) {
  start();
  run(500 * kMs);
  ASSERT_GT(taken, 0);
  left.unplug();
  const int before = taken;
  run(60 * kMs, false);
  // The reader still looks at its pair: the memory stays.
  EXPECT_EQ(frame.left.data[100], frame.left.data[0]);
  EXPECT_GT(system.live_maps(), 8U);
  EXPECT_EQ(camera.state(), CameraState::kRestarting);
  run(500 * kMs);
  EXPECT_EQ(system.live_maps(), 8U);  // the right eye's
  left.plug();
  run(1500 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kOk);
  EXPECT_GT(taken, before + 20);
  EXPECT_GT(lost, 15U);
  const StereoVideoReport said = report();
  EXPECT_EQ(said.eyes[0].openings, 2U);
  EXPECT_EQ(said.eyes[1].openings, 1U);
}

TEST_F(V4l2StereoCameraTest, AReaderThatNeverLooksAgainIsReportedInBoundedTime) {
  start();
  run(500 * kMs);
  left.unplug();
  run(100 * kMs, false);
  left.plug();
  run(5000 * kMs, false);
  EXPECT_EQ(camera.state(), CameraState::kFault);
  EXPECT_FALSE(camera.take(frame));
  camera.start(system.now_ns());  // and then it did
  run(1000 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kOk);
}

TEST_F(V4l2StereoCameraTest, ARestartedStreamKeepsTheReadersPair) {
  start();
  run(500 * kMs);
  const std::uint8_t number = frame.right.data[0];
  right.errors_once[VIDIOC_DQBUF] = EIO;
  run(500 * kMs, false);
  EXPECT_EQ(camera.state(), CameraState::kOk);
  EXPECT_EQ(frame.right.data[0], number);
  EXPECT_EQ(frame.right.data[600'000], number);
  run(500 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kOk);
}

TEST_F(V4l2StereoCameraTest, OneEyesFaultIsTheCameras) {
  right.sizes = {{320, 240}};
  start();
  run(100 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kFault);
  const StereoVideoReport said = report();
  EXPECT_EQ(said.errors[1].fault, VideoFault::kSize);
  EXPECT_TRUE(is_ok(said.errors[0]));
}

TEST_F(V4l2StereoCameraTest, LivesWithTheFewestBuffers) {
  left.most_buffers = kMinVideoBuffers;
  right.most_buffers = kMinVideoBuffers;
  start();
  run(1000 * kMs);
  EXPECT_EQ(taken, 30);
  EXPECT_EQ(lost, 0U);
  EXPECT_GE(camera.capture(0).ring().queued(), kDriverBuffers);
}

// However slow the reader and silent an eye, drivers always have buffers to fill.
TEST_F(V4l2StereoCameraTest, DriversAlwaysHaveBuffers) {
  start();
  run(200 * kMs);
  for (int i = 0; i < 300; ++i) {
    right.stalls = i % 7 < 3;
    run(20 * kMs, i % 5 == 0);
    for (int side = 0; side < 2; ++side)
      if (camera.capture(side).is_running()) {
        ASSERT_GE(camera.capture(side).ring().queued(), kDriverBuffers);
      }
  }
}

TEST_F(V4l2StereoCameraTest, ChecksTheConfigurationAndNamesTheEye) {
  int side = -1;
  config.eyes[1].width_px = 1;
  EXPECT_EQ(camera.configure(system, config, side).fault, VideoFault::kSize);
  EXPECT_EQ(side, 1);
  config.eyes[1].width_px = 640;
  config.max_skew_ns = 17 * kMs;  // more than half an interval
  EXPECT_EQ(camera.configure(system, config, side).fault, VideoFault::kConfig);
  config.max_skew_ns = -1;
  EXPECT_EQ(camera.configure(system, config, side).fault, VideoFault::kConfig);
}

TEST_F(V4l2StereoCameraTest, StopLeavesNothingOpen) {
  start();
  run(500 * kMs);
  camera.stop();
  EXPECT_EQ(system.open_handles(), 0U);
  EXPECT_EQ(system.live_maps(), 0U);
  EXPECT_FALSE(camera.take(frame));
  camera.start(system.now_ns());
  run(500 * kMs);
  EXPECT_EQ(camera.state(), CameraState::kOk);
}

// Two threads; a pair never changes under the reader's eyes. For the thread sanitizer as well.
TEST_F(V4l2StereoCameraTest, HandsOverBetweenThreads) {
  start();
  std::atomic<bool> stop{false};
  std::atomic<int> seen{0};
  std::thread capturing([&] {
    for (int i = 0; i < 100'000 && (i < 3500 || seen < 200); ++i) {
      camera.run_once(system);
      std::this_thread::yield();  // both may have to share one processor
      // Virtual time does not wait for a reader that the machine keeps waiting.
      if (camera.state() == CameraState::kFault) camera.start(system.now_ns());
      if (i == 3000) left.unplug();
      if (i == 3050) left.plug();
    }
    stop = true;
  });
  int changed = 0;
  while (!stop) {
    StereoFrame pair;
    if (!camera.take(pair)) {
      std::this_thread::yield();
      continue;
    }
    ++seen;
    const std::uint8_t first = pair.left.data[0];
    for (std::size_t i = 0; i < 480 * pair.left.stride_bytes; i += 64)
      if (pair.left.data[i] != first) ++changed;
  }
  capturing.join();
  EXPECT_EQ(changed, 0);
  EXPECT_GE(seen, 200);
}

}  // namespace
}  // namespace vergence::v4l2
