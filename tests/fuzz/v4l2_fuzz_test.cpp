// Whatever a driver answers: no crash, nothing outside a buffer, nothing left open, and the state machine's
// bounds.
#include <gtest/gtest.h>

#include <memory>

#include "hal/v4l2/v4l2_stereo_camera.hpp"
#include "tests/support/fake_video_system.hpp"
#include "tests/support/random.hpp"

namespace vergence::v4l2 {
namespace {

// A sound driver whose answers are damaged on the way: error numbers, and bytes of what it wrote.
class DamagedSystem final : public VideoSystem {
 public:
  DamagedSystem(testing::FakeVideoSystem& sound, std::uint64_t seed) : sound_(sound), random_(seed) {}

  int one_in = 50;

  [[nodiscard]] std::int64_t now_ns() const { return sound_.now_ns(); }
  int open(const char* path, int& handle) override { return strikes() ? error() : sound_.open(path, handle); }
  void close(int handle) override { sound_.close(handle); }
  int control(int handle, unsigned long request, void* argument) override {
    if (strikes()) return error();
    const int e = sound_.control(handle, request, argument);
    const bool is_export = request == VIDIOC_EXPBUF;  // its handles would be the fake's own to lose
    if (e == 0 && strikes() && !is_export && (_IOC_DIR(request) & _IOC_READ) != 0) damage(request, argument);
    return e;
  }
  int poll(std::span<PollEntry> entries, std::int64_t timeout_ns) override {
    const int e = sound_.poll(entries, timeout_ns);
    for (PollEntry& entry : entries)
      if (strikes()) entry.happened = static_cast<short>(random_.bits() & 0x3F);
    return e;
  }
  int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) override {
    return strikes() ? ENOMEM : sound_.map(handle, bytes, offset, memory);
  }
  int map_own(std::size_t bytes, std::uint8_t*& memory) override {
    return strikes() ? ENOMEM : sound_.map_own(bytes, memory);
  }
  void unmap(std::uint8_t* memory, std::size_t bytes) override { sound_.unmap(memory, bytes); }

 private:
  bool strikes() { return random_.below(one_in) == 0; }
  int error() {
    static constexpr int kErrors[] = {EIO,    ENODEV, EINVAL, EBUSY,  ENOTTY,
                                      EAGAIN, ENOMEM, EPIPE,  ERANGE, ENOLINK};
    return kErrors[random_.below(static_cast<int>(std::size(kErrors)))];
  }
  // Bytes anywhere but in the pointer to the planes, which is ours; of the planes as well.
  void damage(unsigned long request, void* argument) {
    if (request == VIDIOC_DQBUF || request == VIDIOC_QUERYBUF || request == VIDIOC_QBUF) {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      const bool is_multi = buffer.type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
      v4l2_plane* planes = is_multi ? buffer.m.planes : nullptr;
      v4l2_buffer damaged = buffer;
      scatter(&damaged, sizeof damaged);
      if (is_multi) damaged.m.planes = planes;
      if (is_multi) scatter(planes, 2 * sizeof(v4l2_plane));
      buffer = damaged;
      return;
    }
    scatter(argument, _IOC_SIZE(request));
  }
  void scatter(void* at, std::size_t bytes) {
    for (int n = 1 + random_.below(4); n > 0; --n) {
      auto* byte = static_cast<std::uint8_t*>(at) + random_.bits() % bytes;
      *byte = random_.below(2) == 0 ? static_cast<std::uint8_t>(random_.bits()) : std::uint8_t{0xFF};
    }
  }

  testing::FakeVideoSystem& sound_;
  testing::Random random_;
};

// Reads the corners of what it was given: the address sanitizer judges whether they are there.
unsigned corners(const ImageView& image) {
  const auto rows = static_cast<std::size_t>(image.height_px);
  const auto width = static_cast<std::size_t>(image.width_px);
  const std::size_t row = image.format == PixelFormat::kRgb24  ? 3 * width
                          : image.format == PixelFormat::kNv12 ? width
                                                               : 2 * width;
  unsigned sum = image.data[0] + image.data[(rows - 1) * image.stride_bytes + row - 1];
  if (image.chroma != nullptr) sum += image.chroma[(rows / 2 - 1) * image.chroma_stride_bytes + width - 1];
  return sum;
}

TEST(V4l2Fuzz, AnyAnswerOfADriver) {
  std::uint64_t pairs = 0;
  std::uint64_t restarts = 0;
  int faults = 0;
  std::uint64_t sum = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    testing::Random random(seed);
    testing::FakeVideoDevice left;
    testing::FakeVideoDevice right;
    right.path = "/dev/video2";
    right.next_frame_ns += 1'000'000;
    StereoVideoConfig config;
    const int kind = random.below(3);
    for (testing::FakeVideoDevice* device : {&left, &right}) {
      if (kind > 0) device->capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
      if (kind > 0) device->fourccs = {kind == 1 ? V4L2_PIX_FMT_NV12 : V4L2_PIX_FMT_NV12M};
      device->sizes = {{64, 48}};
      device->controls[V4L2_CID_AUTOGAIN] = {0, 1, 1};
      device->controls[V4L2_CID_GAIN] = {0, 64, 0, V4L2_CID_AUTOGAIN, 0, 23};
    }
    config.eyes = {config_of(left), config_of(right)};
    for (VideoConfig& eye : config.eyes) {
      eye.width_px = 64;
      eye.height_px = 48;
      eye.memory = static_cast<BufferMemory>(random.below(3));
      eye.controls[static_cast<std::size_t>(ControlRole::kGain)] = {ControlMode::kAutoThenLock, 0};
      eye.settle_ns = 50'000'000;
    }
    testing::FakeVideoSystem sound;
    sound.devices = {&left, &right};
    DamagedSystem system(sound, seed);
    system.one_in = 20 << random.below(7);
    {
      V4l2StereoCamera camera;
      int side = 0;
      ASSERT_TRUE(is_ok(camera.configure(system, config, side)));
      camera.start(0);
      StereoFrame frame;
      bool holds = false;
      for (int i = 0; i < 600; ++i) {
        camera.run_once(system);
        if (holds) sum += corners(frame.left) + corners(frame.right);
        if (random.below(3) == 0) holds = camera.take(frame);
        if (random.below(200) == 0) left.unplug();
        if (!left.is_present && random.below(10) == 0) left.plug();
        for (int s = 0; s < 2; ++s)
          ASSERT_LE(camera.capture(s).ring().held() + camera.capture(s).ring().queued(), kMaxVideoBuffers);
        if (camera.state() == CameraState::kFault) {
          ++faults;
          camera.start(system.now_ns());
        }
      }
      StereoVideoReport report;
      ASSERT_TRUE(camera.report(report));
      pairs += report.pairing.pairs;
      restarts += report.eyes[0].restarts + report.eyes[1].restarts;
      ASSERT_LE(report.longest_wait_ns, kMaxWait_ns);
    }
    ASSERT_EQ(sound.live_maps(), 0U) << seed;
    ASSERT_EQ(sound.open_handles(), 0U) << seed;
  }
  // All of it was reached.
  EXPECT_GT(sum, 0U);
  EXPECT_GT(pairs, 10'000U);
  EXPECT_GT(restarts, 1'000U);
  EXPECT_GT(faults, 100);
}

}  // namespace
}  // namespace vergence::v4l2
