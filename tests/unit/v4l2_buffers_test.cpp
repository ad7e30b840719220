// Buffers of every kind: whose they are, where the picture is, and that all goes back.
#include <gtest/gtest.h>

#include "hal/v4l2/buffer_ring.hpp"
#include "tests/support/fake_video_system.hpp"

namespace vergence::v4l2 {
namespace {

class V4l2Buffers : public ::testing::Test {
 protected:
  VideoError open(BufferMemory memory, int wanted = kMaxVideoBuffers) {
    system.devices = {&device};
    EXPECT_EQ(system.open("/dev/video0", handle), 0);
    EXPECT_TRUE(is_ok(negotiate(system, handle, config_of(device), format)));
    const VideoError error = ring.allocate(system, handle, format, memory, wanted);
    return is_ok(error) ? ring.start() : error;
  }
  void next_frame() {
    std::array<PollEntry, 1> entries{{{handle, 0}}};
    EXPECT_EQ(system.poll(entries, 100'000'000), 0);
  }
  void multi_planar(std::uint32_t fourcc) {
    device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
    device.fourccs = {fourcc};
  }

  testing::FakeVideoDevice device;
  testing::FakeVideoSystem system;
  int handle = -1;
  StreamFormat format;
  BufferRing ring;
};

TEST_F(V4l2Buffers, EveryKindOfMemoryAndPlanesGivesThePicture) {
  const struct {
    std::uint32_t fourcc;
    bool multi;
  } formats[] = {{V4L2_PIX_FMT_YUYV, false},
                 {V4L2_PIX_FMT_RGB24, true},
                 {V4L2_PIX_FMT_NV12, false},
                 {V4L2_PIX_FMT_NV12, true},
                 {V4L2_PIX_FMT_NV12M, true}};
  for (const BufferMemory memory :
       {BufferMemory::kMapped, BufferMemory::kExported, BufferMemory::kUserPointer}) {
    for (const auto& each : formats) {
      device = {};
      device.fourccs = {each.fourcc};
      device.padding_bytes = 32;
      if (each.multi) multi_planar(each.fourcc);
      device.next_frame_ns += system.now_ns();
      ASSERT_TRUE(is_ok(open(memory)));
      EXPECT_EQ(ring.queued(), kMaxVideoBuffers);
      for (int i = 0; i < 20; ++i) {
        next_frame();
        DequeuedBuffer got;
        ASSERT_EQ(ring.dequeue(got), 0);
        EXPECT_EQ(ring.held(), 1);
        EXPECT_EQ(got.sequence, static_cast<std::uint32_t>(i));
        ASSERT_TRUE(got.is_whole);
        EXPECT_EQ(got.image.width_px, 640);
        EXPECT_EQ(got.image.stride_bytes, format.stride_bytes[0]);
        EXPECT_EQ(got.image.data[0], i);
        EXPECT_EQ(got.image.data[479 * got.image.stride_bytes + 639], i);
        if (got.image.format == PixelFormat::kNv12) {
          EXPECT_EQ(got.image.chroma[239 * got.image.chroma_stride_bytes + 639], i);
          if (format.planes == 1) {
            EXPECT_EQ(got.image.chroma, got.image.data + 480 * got.image.stride_bytes);
          }
        }
        EXPECT_EQ(ring.dequeue(got), EAGAIN);
        ASSERT_EQ(ring.give_back(got.index), 0);
      }
      ring.release();
      system.close(handle);
      EXPECT_EQ(system.open_handles(), 0U);
      EXPECT_EQ(system.live_maps(), 0U);
      EXPECT_EQ(device.requests, (std::vector<std::uint32_t>{8, 0}));
    }
  }
  EXPECT_EQ(system.syncs_begun, system.syncs_ended);
  EXPECT_EQ(system.syncs_begun, 20 * 6);  // five formats, one of two planes
}

TEST_F(V4l2Buffers, WhatIsHeldStaysOverAStopAndStart) {
  ASSERT_TRUE(is_ok(open(BufferMemory::kMapped)));
  next_frame();
  DequeuedBuffer held;
  ASSERT_EQ(ring.dequeue(held), 0);
  ring.stop();
  EXPECT_EQ(ring.queued(), 0);
  ASSERT_TRUE(is_ok(ring.start()));
  EXPECT_EQ(ring.queued(), kMaxVideoBuffers - 1);
  for (int i = 0; i < 30; ++i) {
    next_frame();
    DequeuedBuffer got;
    ASSERT_EQ(ring.dequeue(got), 0);
    EXPECT_NE(got.index, held.index);
    ASSERT_EQ(ring.give_back(got.index), 0);
  }
  EXPECT_EQ(held.image.data[0], 0);  // not written since
  EXPECT_EQ(ring.give_back(held.index), 0);
  EXPECT_EQ(ring.give_back(held.index), EINVAL);
  EXPECT_EQ(ring.give_back(-1), EINVAL);
  EXPECT_EQ(ring.give_back(kMaxVideoBuffers), EINVAL);
  ring.release();
}

TEST_F(V4l2Buffers, TakesFewerThanAskedButNotTooFew) {
  device.most_buffers = 5;
  ASSERT_TRUE(is_ok(open(BufferMemory::kMapped)));
  EXPECT_EQ(ring.count(), 5);
  ring.release();
  device.most_buffers = 4;
  const VideoError error = open(BufferMemory::kMapped);
  EXPECT_EQ(error.fault, VideoFault::kBuffers);
  EXPECT_EQ(error.got, 4);
  EXPECT_EQ(system.live_maps(), 0U);
  EXPECT_EQ(device.requests.back(), 0U);
}

TEST_F(V4l2Buffers, RefusesBuffersTooSmallForAnImage) {
  device.buffer_shrinks_by = 1;
  EXPECT_EQ(open(BufferMemory::kMapped).fault, VideoFault::kBufferBytes);
  EXPECT_EQ(system.live_maps(), 0U);
}

TEST_F(V4l2Buffers, SaysWhyMemoryIsNotThere) {
  system.map_error = ENOMEM;
  for (const BufferMemory memory :
       {BufferMemory::kMapped, BufferMemory::kExported, BufferMemory::kUserPointer}) {
    const VideoError error = open(memory);
    EXPECT_EQ(error.fault, VideoFault::kMapping);
    EXPECT_EQ(error.error_number, ENOMEM);
    system.close(handle);
    EXPECT_EQ(system.open_handles(), 0U);  // exported ones too
  }
  system.map_error = 0;
  device.errors[VIDIOC_EXPBUF] = ENOTTY;
  EXPECT_EQ(open(BufferMemory::kExported).error_number, ENOTTY);
  device.errors[VIDIOC_REQBUFS] = EINVAL;
  const VideoError error = open(BufferMemory::kUserPointer);
  EXPECT_EQ(error.fault, VideoFault::kBuffers);
  EXPECT_TRUE(is_permanent(error));
}

TEST_F(V4l2Buffers, APictureBeginsAfterTheDriversHeader) {
  multi_planar(V4L2_PIX_FMT_UYVY);
  device.data_offset = 64;
  ASSERT_TRUE(is_ok(open(BufferMemory::kMapped)));
  next_frame();
  DequeuedBuffer got;
  ASSERT_EQ(ring.dequeue(got), 0);
  ASSERT_TRUE(got.is_whole);
  EXPECT_EQ(got.image.data[0], 0);
  ring.release();
  // Header and picture no longer fit together.
  device.image_bytes = 614400;
  device.next_frame_ns = system.now_ns() + 1;
  ASSERT_TRUE(is_ok(open(BufferMemory::kMapped)));
  next_frame();
  ASSERT_EQ(ring.dequeue(got), 0);
  EXPECT_FALSE(got.is_whole);
  EXPECT_EQ(got.image.data, nullptr);
  ring.release();
}

}  // namespace
}  // namespace vergence::v4l2
