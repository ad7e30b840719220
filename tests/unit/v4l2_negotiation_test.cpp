// What is agreed on with a driver: formats, sizes, intervals, inputs, timings; and what is refused, with the
// reason.
#include <gtest/gtest.h>

#include "hal/v4l2/negotiation.hpp"
#include "tests/support/fake_video_system.hpp"

namespace vergence::v4l2 {
namespace {

using testing::FakeVideoDevice;
using testing::FakeVideoSystem;

class V4l2Negotiation : public ::testing::Test {
 protected:
  VideoError run(const VideoConfig& config) {
    system.devices = {&device};
    int handle = -1;
    EXPECT_EQ(system.open(device.path.c_str(), handle), 0);
    const VideoError error = negotiate(system, handle, config, got);
    system.close(handle);
    return error;
  }
  VideoError run() { return run(config_of(device)); }
  VideoFault fault() { return run().fault; }

  FakeVideoDevice device;
  FakeVideoSystem system;
  StreamFormat got;
};

TEST_F(V4l2Negotiation, TakesEveryFormatOfTheVisionCore) {
  const struct {
    std::uint32_t fourcc;
    PixelFormat format;
    std::size_t stride;
    std::size_t needed;
  } cases[] = {{V4L2_PIX_FMT_YUYV, PixelFormat::kYuyv, 1280, 614400},
               {V4L2_PIX_FMT_UYVY, PixelFormat::kUyvy, 1280, 614400},
               {V4L2_PIX_FMT_NV12, PixelFormat::kNv12, 640, 460800},
               {V4L2_PIX_FMT_RGB24, PixelFormat::kRgb24, 1920, 921600}};
  for (const auto& each : cases) {
    for (const std::uint32_t kind : {V4L2_CAP_VIDEO_CAPTURE, V4L2_CAP_VIDEO_CAPTURE_MPLANE}) {
      device.capabilities = kind | V4L2_CAP_STREAMING;
      device.fourccs = {each.fourcc};
      EXPECT_TRUE(is_ok(run()));
      EXPECT_EQ(got.multi_planar, kind == V4L2_CAP_VIDEO_CAPTURE_MPLANE);
      EXPECT_EQ(got.format, each.format);
      EXPECT_EQ(got.stride_bytes[0], each.stride);
      EXPECT_EQ(got.needed_bytes[0], each.needed);
      EXPECT_EQ(got.interval_ns, 33'333'333);
    }
  }
}

TEST_F(V4l2Negotiation, TakesNv12InTwoPlanes) {
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  device.fourccs = {V4L2_PIX_FMT_NV12M};
  ASSERT_TRUE(is_ok(run()));
  EXPECT_EQ(got.planes, 2);
  EXPECT_EQ(got.stride_bytes[1], 656U);
  EXPECT_EQ(got.needed_bytes[1], 656U * 239U + 640U);
}

TEST_F(V4l2Negotiation, RefusesWhatCarriesNoColourOrIsCompressedWithTheReason) {
  const struct {
    std::uint32_t fourcc;
    const char* reason;
  } cases[] = {{V4L2_PIX_FMT_MJPEG, "compressed"}, {V4L2_PIX_FMT_H264, "compressed"},
               {V4L2_PIX_FMT_GREY, "grey"},        {V4L2_PIX_FMT_Y16, "grey"},
               {V4L2_PIX_FMT_Z16, "depth"},        {V4L2_PIX_FMT_SRGGB8, "Bayer"},
               {V4L2_PIX_FMT_BGR24, "order"},      {v4l2_fourcc('?', 'A', 'B', 'C'), "unknown"}};
  for (const auto& each : cases) {
    device.fourccs = {each.fourcc};
    const VideoError error = run();
    EXPECT_EQ(error.fault, VideoFault::kPixelFormat);
    EXPECT_TRUE(is_permanent(error));
    ASSERT_NE(refusal(each.fourcc), nullptr);
    EXPECT_NE(std::string(refusal(each.fourcc)).find(each.reason), std::string::npos) << refusal(each.fourcc);
  }
  for (const std::uint32_t usable :
       {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_RGB24})
    EXPECT_EQ(refusal(usable), nullptr);
}

TEST_F(V4l2Negotiation, SaysWhatTheDriverGaveInsteadOfTheFormat) {
  device.fourccs = {V4L2_PIX_FMT_MJPEG};
  VideoConfig config = config_of(device);
  config.fourcc = V4L2_PIX_FMT_YUYV;
  const VideoError error = run(config);
  EXPECT_EQ(error.fault, VideoFault::kPixelFormat);
  char text[300];
  EXPECT_GT(write_message(error, text), 0U);
  EXPECT_EQ(std::string(text).find("fourcc: asked YUYV, got MJPG (compressed"), 0U) << text;
  EXPECT_NE(std::string(text).find("choose"), std::string::npos);
}

TEST_F(V4l2Negotiation, MessagesAreCutToTheirRoom) {
  char text[8];
  EXPECT_EQ(write_message({VideoFault::kOpen, ENOENT}, text), 7U);
  EXPECT_STREQ(text, "path: a");
  EXPECT_EQ(write_message({VideoFault::kOpen}, {}), 0U);
}

TEST_F(V4l2Negotiation, EveryFaultHasAFieldAndARemedy) {
  for (int i = 1; i <= static_cast<int>(VideoFault::kAnswer); ++i) {
    EXPECT_STRNE(field(static_cast<VideoFault>(i)), "none") << i;
    EXPECT_STRNE(remedy(static_cast<VideoFault>(i)), "nothing to do") << i;
  }
}

TEST_F(V4l2Negotiation, RefusesAnotherSizeThanAsked) {
  VideoConfig config = config_of(device);
  config.width_px = 800;
  const VideoError error = run(config);
  EXPECT_EQ(error.fault, VideoFault::kSize);
  EXPECT_EQ(error.asked, 800);
  EXPECT_EQ(error.got, 640);
  for (const int width : {0, -2, 641, 1282}) {
    config.width_px = width;
    EXPECT_EQ(check(config).fault, VideoFault::kSize) << width;
  }
}

TEST_F(V4l2Negotiation, KeepsPaddedRowsAndRefusesShortOnes) {
  device.padding_bytes = 64;
  ASSERT_TRUE(is_ok(run()));
  EXPECT_EQ(got.stride_bytes[0], 1344U);
  EXPECT_EQ(got.needed_bytes[0], 1344U * 479U + 1280U);
  device.row_bytes = 1279;
  EXPECT_EQ(fault(), VideoFault::kStride);
  device.row_bytes = 0;
  EXPECT_EQ(fault(), VideoFault::kStride);
  device.row_bytes = 0x7FFFFFFF;
  EXPECT_EQ(fault(), VideoFault::kStride);
}

TEST_F(V4l2Negotiation, RefusesImagesTooSmallOrTooLarge) {
  device.image_bytes = 614399;
  EXPECT_EQ(fault(), VideoFault::kImageBytes);
  device.image_bytes = static_cast<std::int64_t>(kMaxVideoBufferBytes) + 1;
  EXPECT_EQ(fault(), VideoFault::kImageBytes);
}

TEST_F(V4l2Negotiation, RefusesInterlacedPictures) {
  device.field = V4L2_FIELD_INTERLACED;
  EXPECT_EQ(fault(), VideoFault::kInterlaced);
}

TEST_F(V4l2Negotiation, RefusesAnotherIntervalThanAsked) {
  VideoConfig config = config_of(device);
  config.interval = {1, 60};
  EXPECT_TRUE(is_ok(run(config)));
  EXPECT_EQ(got.interval_ns, 16'666'666);
  config.interval = {1, 50};
  const VideoError error = run(config);
  EXPECT_EQ(error.fault, VideoFault::kInterval);
  EXPECT_EQ(error.asked, 20'000'000);
  EXPECT_EQ(error.got, 33'333'333);
  config.interval = {0, 0};  // whatever it is
  EXPECT_TRUE(is_ok(run(config)));
  EXPECT_EQ(got.interval_ns, 33'333'333);
  device.errors[VIDIOC_S_PARM] = EBUSY;
  EXPECT_EQ(run().fault, VideoFault::kInterval);
}

TEST_F(V4l2Negotiation, ADriverWithoutIntervalsIsRefusedOnlyWhereOneIsAskedFor) {
  device.intervals.clear();
  EXPECT_EQ(fault(), VideoFault::kInterval);
  VideoConfig config = config_of(device);
  config.interval = {0, 0};
  EXPECT_TRUE(is_ok(run(config)));
  EXPECT_EQ(got.interval_ns, 0);
}

TEST_F(V4l2Negotiation, ChoosesTheInput) {
  device.inputs = 3;
  VideoConfig config = config_of(device);
  config.input = 2;
  EXPECT_TRUE(is_ok(run(config)));
  EXPECT_EQ(device.input, 2);
  config.input = 3;
  EXPECT_EQ(run(config).fault, VideoFault::kInput);
  EXPECT_TRUE(is_permanent(run(config)));
}

TEST_F(V4l2Negotiation, SaysWhereAnInputHasNoSignal) {
  for (const std::uint32_t status : {V4L2_IN_ST_NO_SIGNAL, V4L2_IN_ST_NO_POWER}) {
    device.input_status = status;
    EXPECT_EQ(fault(), VideoFault::kNoSignal);
    EXPECT_FALSE(is_permanent(run()));  // it may come
  }
}

TEST_F(V4l2Negotiation, TakesOverTheTimingsOfTheSource) {
  device.intervals.clear();
  VideoConfig config = config_of(device);
  config.dv_timings = true;
  config.interval = {1, 60};
  EXPECT_EQ(run(config).fault, VideoFault::kNoSignal);
  v4l2_bt_timings& bt = device.source.bt;
  bt.width = 640;
  bt.height = 480;
  bt.hfrontporch = 16;
  bt.hsync = 96;
  bt.hbackporch = 48;
  bt.vfrontporch = 10;
  bt.vsync = 2;
  bt.vbackporch = 33;
  bt.pixelclock = 25'200'000;
  ASSERT_TRUE(is_ok(run(config)));
  EXPECT_EQ(device.timings.bt.width, 640U);
  EXPECT_EQ(got.interval_ns, 16'666'666);
  bt.interlaced = 1;
  EXPECT_EQ(run(config).fault, VideoFault::kInterlaced);
  bt.interlaced = 0;
  bt.pixelclock = 0;
  EXPECT_EQ(run(config).fault, VideoFault::kInterval);
  device.errors[VIDIOC_QUERY_DV_TIMINGS] = ERANGE;
  EXPECT_EQ(run(config).fault, VideoFault::kTimings);
}

TEST_F(V4l2Negotiation, RefusesWhatIsNoStreamingCamera) {
  device.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_EQ(fault(), VideoFault::kNotACamera);
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  EXPECT_EQ(fault(), VideoFault::kNoStreaming);
  device.errors[VIDIOC_QUERYCAP] = ENOTTY;
  EXPECT_EQ(fault(), VideoFault::kNotACamera);
}

TEST_F(V4l2Negotiation, ChecksTheConfiguration) {
  const VideoConfig good = config_of(device);
  EXPECT_TRUE(is_ok(check(good)));
  VideoConfig config = good;
  config.path = {};
  EXPECT_EQ(check(config).fault, VideoFault::kConfig);
  config.path.fill('x');
  EXPECT_EQ(check(config).fault, VideoFault::kConfig);
  for (const int buffers : {kMinVideoBuffers - 1, kMaxVideoBuffers + 1}) {
    config = good;
    config.buffers = buffers;
    EXPECT_EQ(check(config).fault, VideoFault::kBuffers);
  }
  config = good;
  config.give_up_ns = config.first_frame_ns - 1;
  EXPECT_EQ(check(config).fault, VideoFault::kConfig);
  config = good;
  config.interval = {1, 0};
  EXPECT_EQ(check(config).fault, VideoFault::kInterval);
}

}  // namespace
}  // namespace vergence::v4l2
