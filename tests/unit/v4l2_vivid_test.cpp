// The same against the kernel's own test driver, where it is there: modprobe vivid n_devs=2.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstring>
#include <ctime>
#include <memory>

#include "hal/v4l2/linux_video_device.hpp"
#include "hal/v4l2/v4l2_stereo_camera.hpp"

namespace vergence::v4l2 {
namespace {

struct MonotonicClock {
  [[nodiscard]] std::int64_t now_ns() const {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * kNsPerSecond + now.tv_nsec;
  }
};

bool is_vivid(LinuxVideoSystem& system, const char* path) {
  int handle = -1;
  if (system.open(path, handle) != 0) return false;
  v4l2_capability can{};
  const int e = system.control(handle, VIDIOC_QUERYCAP, &can);
  system.close(handle);
  return e == 0 && std::strcmp(reinterpret_cast<const char*>(can.driver), "vivid") == 0 &&
         (can.device_caps & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0;
}

// Otherwise vivid stamps the end of a frame when it begins: in the future, where no frame is believed.
void stamp_start_of_exposure(LinuxVideoSystem& system, const char* path) {
  int handle = -1;
  ASSERT_EQ(system.open(path, handle), 0);
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  bool is_found = false;
  while (!is_found && system.control(handle, VIDIOC_QUERYCTRL, &query) == 0) {
    is_found = std::strcmp(reinterpret_cast<const char*>(query.name), "Timestamp Source") == 0;
    if (!is_found) query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  v4l2_control control{query.id, 1};
  EXPECT_TRUE(is_found);
  EXPECT_EQ(system.control(handle, VIDIOC_S_CTRL, &control), 0);
  system.close(handle);
}

TEST(V4l2Vivid, CapturesWithEveryKindOfMemory) {
  LinuxVideoSystem system;
  if (!is_vivid(system, "/dev/video0")) GTEST_SKIP() << "/dev/video0 is not there, or not of vivid";
  stamp_start_of_exposure(system, "/dev/video0");
  for (const BufferMemory memory :
       {BufferMemory::kMapped, BufferMemory::kExported, BufferMemory::kUserPointer}) {
    VideoConfig config;
    std::strcpy(config.path.data(), "/dev/video0");
    config.input = 0;
    config.fourcc = V4L2_PIX_FMT_YUYV;
    config.width_px = 640;
    config.height_px = 360;
    config.memory = memory;
    config.stall_ns = kNsPerSecond;
    Capture capture;
    ASSERT_TRUE(is_ok(capture.configure(system, config)));
    MonotonicClock clock;
    capture.start(clock.now_ns());
    int frames = 0;
    const std::int64_t end_ns = clock.now_ns() + 10 * kNsPerSecond;
    while (frames < 20 && capture.state() != CaptureState::kFault && clock.now_ns() < end_ns) {
      std::array<PollEntry, 1> entries{{{capture.handle_to_poll(), 0}}};
      ASSERT_EQ(system.poll(entries, kMaxWait_ns), 0);
      CapturedFrame frame;
      while (entries[0].happened != 0 && capture.next(clock.now_ns(), frame)) {
        ++frames;
        capture.give_back(clock.now_ns(), frame.buffer);
      }
      capture.tend(clock.now_ns(), entries[0].happened);
    }
    char text[300];
    write_message(capture.error(), text);
    EXPECT_GE(frames, 20) << text;
    capture.stop();
  }
}

TEST(V4l2Linux, AnswersErrorNumbers) {
  LinuxVideoSystem system;
  int handle = -1;
  EXPECT_EQ(system.open("/nowhere/video", handle), ENOENT);
  ASSERT_EQ(system.open("/dev/null", handle), 0);
  v4l2_capability can{};
  // An emulator that does not know the call says so of every file.
  const int refused = system.control(handle, VIDIOC_QUERYCAP, &can);
  EXPECT_TRUE(refused == ENOTTY || refused == ENOSYS) << refused;
  EXPECT_EQ(system.control(-1, VIDIOC_QUERYCAP, &can), refused == ENOSYS ? ENOSYS : EBADF);
  std::uint8_t* memory = nullptr;
  EXPECT_EQ(system.map(handle, 4096, 0, memory), ENODEV);
  ASSERT_EQ(system.map_own(10'000, memory), 0);
  memory[9'999] = 1;
  system.unmap(memory, 10'000);
  std::array<PollEntry, 2> entries{{{handle, 0}, {-1, 7}}};
  EXPECT_EQ(system.poll(entries, 0), 0);
  EXPECT_NE(entries[0].happened, 0);  // /dev/null always has something to say
  EXPECT_EQ(entries[1].happened, 0);
  std::array<PollEntry, 9> too_many{};
  EXPECT_EQ(system.poll(too_many, 0), EINVAL);
  system.close(handle);
}

}  // namespace
}  // namespace vergence::v4l2
