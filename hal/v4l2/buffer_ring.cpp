#include "hal/v4l2/buffer_ring.hpp"

#include <fcntl.h>
#include <linux/dma-buf.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>

namespace vergence::v4l2 {
namespace {

std::uint32_t type_of(const StreamFormat& format) {
  return format.multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

std::uint32_t kind_of(BufferMemory memory) {
  return memory == BufferMemory::kUserPointer ? V4L2_MEMORY_USERPTR : V4L2_MEMORY_MMAP;
}

constexpr std::int64_t kMaxStampSeconds = 4'000'000'000;

bool is_sane(const timeval& time) {
  return time.tv_sec >= 0 && time.tv_sec < kMaxStampSeconds && time.tv_usec >= 0 && time.tv_usec < 1'000'000;
}

}  // namespace

// A v4l2_buffer with the planes it points to.
struct BufferRing::Message {
  v4l2_buffer buffer{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes{};  // as many as any driver may write

  Message(const StreamFormat& format, BufferMemory memory, int index) {
    buffer.index = static_cast<std::uint32_t>(index);
    buffer.type = type_of(format);
    buffer.memory = kind_of(memory);
    if (format.multi_planar) {
      buffer.m.planes = planes.data();
      buffer.length = static_cast<std::uint32_t>(format.planes);
    }
  }
  Message(const Message&) = delete;
  Message& operator=(const Message&) = delete;
};

VideoError BufferRing::allocate(VideoSystem& system, int handle, const StreamFormat& format,
                                BufferMemory memory, int wanted) {
  system_ = &system;
  handle_ = handle;
  format_ = format;
  memory_ = memory;
  buffers_ = {};
  count_ = 0;
  std::uint32_t granted = 0;
  VideoError error = request(static_cast<std::uint32_t>(wanted), granted);
  if (!is_ok(error)) return error;
  // A driver may give more than was asked for; those are left alone.
  count_ = static_cast<int>(std::min<std::uint32_t>(granted, static_cast<std::uint32_t>(wanted)));
  if (count_ < kMinVideoBuffers) error = {VideoFault::kBuffers, 0, 0, wanted, granted};
  for (int i = 0; i < count_ && is_ok(error); ++i) error = prepare(i);
  if (!is_ok(error)) release();
  return error;
}

VideoError BufferRing::request(std::uint32_t wanted, std::uint32_t& granted) {
  v4l2_requestbuffers asked{};
  asked.count = wanted;
  asked.type = type_of(format_);
  asked.memory = kind_of(memory_);
  const int e = system_->control(handle_, VIDIOC_REQBUFS, &asked);
  granted = asked.count;
  if (e != 0) return {VideoFault::kBuffers, e, 0, wanted, 0};
  return {};
}

VideoError BufferRing::prepare(int index) {
  Message message(format_, memory_, index);
  if (memory_ != BufferMemory::kUserPointer) {
    if (const int e = system_->control(handle_, VIDIOC_QUERYBUF, &message.buffer); e != 0)
      return {VideoFault::kBuffers, e, 0, index, 0};
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(format_.planes); ++i) {
    std::size_t bytes = format_.image_bytes[i];
    std::int64_t offset = 0;
    if (memory_ != BufferMemory::kUserPointer) {
      bytes = format_.multi_planar ? message.planes[i].length : message.buffer.length;
      offset = format_.multi_planar ? message.planes[i].m.mem_offset : message.buffer.m.offset;
    }
    if (bytes < format_.needed_bytes[i] || bytes > 2 * kMaxVideoBufferBytes)
      return {VideoFault::kBufferBytes, 0, 0, static_cast<std::int64_t>(format_.needed_bytes[i]),
              static_cast<std::int64_t>(bytes)};
    if (const VideoError error = prepare_plane(index, static_cast<int>(i), bytes, offset); !is_ok(error))
      return error;
  }
  return {};
}

VideoError BufferRing::prepare_plane(int index, int number, std::size_t bytes, std::int64_t offset) {
  Plane& plane = buffers_[static_cast<std::size_t>(index)].planes[static_cast<std::size_t>(number)];
  int e = 0;
  if (memory_ == BufferMemory::kUserPointer) {
    e = system_->map_own(bytes, plane.memory);
  } else if (memory_ == BufferMemory::kExported) {
    v4l2_exportbuffer wish{};
    wish.type = type_of(format_);
    wish.index = static_cast<std::uint32_t>(index);
    wish.plane = static_cast<std::uint32_t>(number);
    wish.flags = O_RDWR | O_CLOEXEC;
    wish.fd = -1;
    e = system_->control(handle_, VIDIOC_EXPBUF, &wish);
    if (e != 0 || wish.fd < 0) return {VideoFault::kMapping, e == 0 ? EBADMSG : e, 0, index, number};
    plane.exported = wish.fd;
    e = system_->map(plane.exported, bytes, 0, plane.memory);
  } else {
    e = system_->map(handle_, bytes, offset, plane.memory);
  }
  if (e != 0) {
    plane.memory = nullptr;
    return {VideoFault::kMapping, e, 0, index, number};
  }
  plane.bytes = bytes;
  return {};
}

void BufferRing::release() {
  if (system_ == nullptr) return;
  stop();
  for (Buffer& buffer : buffers_) {
    for (Plane& plane : buffer.planes) {
      if (plane.memory != nullptr) system_->unmap(plane.memory, plane.bytes);
      if (plane.exported >= 0) system_->close(plane.exported);
    }
  }
  buffers_ = {};
  count_ = 0;
  std::uint32_t granted = 0;
  (void)request(0, granted);  // a driver that is gone has nothing to give back
  system_ = nullptr;
}

VideoError BufferRing::start() {
  for (int i = 0; i < count_; ++i) {
    if (buffers_[static_cast<std::size_t>(i)].owner != Owner::kIdle) continue;
    if (const int e = queue(i); e != 0) return {VideoFault::kQueue, e, 0, i, 0};
  }
  int type = static_cast<int>(type_of(format_));
  if (const int e = system_->control(handle_, VIDIOC_STREAMON, &type); e != 0)
    return {VideoFault::kStreamOn, e};
  is_streaming_ = true;
  return {};
}

void BufferRing::stop() {
  if (system_ == nullptr) return;
  int type = static_cast<int>(type_of(format_));
  // Also where it never began: this takes back what was queued. One that is gone has let go by itself.
  if (is_streaming_ || owned_by(Owner::kDriver) > 0) (void)system_->control(handle_, VIDIOC_STREAMOFF, &type);
  is_streaming_ = false;
  for (Buffer& buffer : buffers_)
    if (buffer.owner == Owner::kDriver) buffer.owner = Owner::kIdle;
}

int BufferRing::dequeue(DequeuedBuffer& got) {
  if (!is_streaming_) return EAGAIN;
  Message message(format_, memory_, 0);
  if (const int e = system_->control(handle_, VIDIOC_DQBUF, &message.buffer); e != 0) return e;
  const v4l2_buffer& buffer = message.buffer;
  if (buffer.index >= static_cast<std::uint32_t>(count_)) return EBADMSG;
  if (buffers_[buffer.index].owner != Owner::kDriver) return EBADMSG;
  buffers_[buffer.index].owner = Owner::kUser;

  got = {};
  got.index = static_cast<int>(buffer.index);
  got.sequence = buffer.sequence;
  got.is_flagged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  got.has_monotonic_stamp =
      (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  if (is_sane(buffer.timestamp))
    got.stamp_ns =
        std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + std::int64_t{buffer.timestamp.tv_usec} * 1000;
  locate(message, got);
  if (memory_ != BufferMemory::kExported) return 0;
  const int e = sync(got.index, DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ);
  if (e != 0) buffers_[buffer.index].owner = Owner::kIdle;
  return e;
}

// Where the picture lies, if all of it is there and inside the buffer.
void BufferRing::locate(const Message& message, DequeuedBuffer& got) const {
  const Buffer& buffer = buffers_[static_cast<std::size_t>(got.index)];
  std::array<const std::uint8_t*, kMaxVideoPlanes> at{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(format_.planes); ++i) {
    const v4l2_plane& said = message.planes[i];
    const std::size_t used = format_.multi_planar ? said.bytesused : message.buffer.bytesused;
    const std::size_t offset = format_.multi_planar ? said.data_offset : 0;  // included in the bytes used
    if (used > buffer.planes[i].bytes || offset > used || used - offset < format_.needed_bytes[i]) return;
    at[i] = buffer.planes[i].memory + offset;
  }
  got.is_whole = true;
  got.image.data = at[0];
  got.image.width_px = format_.width_px;
  got.image.height_px = format_.height_px;
  got.image.stride_bytes = format_.stride_bytes[0];
  got.image.format = format_.format;
  if (format_.format != PixelFormat::kNv12) return;
  const bool is_apart = format_.planes == 2;
  got.image.chroma =
      is_apart ? at[1] : at[0] + format_.stride_bytes[0] * static_cast<std::size_t>(format_.height_px);
  got.image.chroma_stride_bytes = format_.stride_bytes[is_apart ? 1 : 0];
}

int BufferRing::give_back(int index) {
  if (index < 0 || index >= count_) return EINVAL;
  Buffer& buffer = buffers_[static_cast<std::size_t>(index)];
  if (buffer.owner != Owner::kUser) return EINVAL;
  buffer.owner = Owner::kIdle;
  int e = 0;
  if (memory_ == BufferMemory::kExported) e = sync(index, DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ);
  if (is_streaming_ && e == 0) e = queue(index);
  return e;
}

int BufferRing::queue(int index) {
  Message message(format_, memory_, index);
  Buffer& buffer = buffers_[static_cast<std::size_t>(index)];
  if (memory_ == BufferMemory::kUserPointer) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(format_.planes); ++i) {
      const auto address = reinterpret_cast<unsigned long>(buffer.planes[i].memory);
      const auto length = static_cast<std::uint32_t>(buffer.planes[i].bytes);
      if (format_.multi_planar) {
        message.planes[i].m.userptr = address;
        message.planes[i].length = length;
      } else {
        message.buffer.m.userptr = address;
        message.buffer.length = length;
      }
    }
  }
  const int e = system_->control(handle_, VIDIOC_QBUF, &message.buffer);
  if (e == 0) buffer.owner = Owner::kDriver;
  return e;
}

int BufferRing::sync(int index, std::uint64_t flags) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(format_.planes); ++i) {
    dma_buf_sync what{flags};
    const int handle = buffers_[static_cast<std::size_t>(index)].planes[i].exported;
    if (const int e = system_->control(handle, DMA_BUF_IOCTL_SYNC, &what); e != 0) return e;
  }
  return 0;
}

int BufferRing::owned_by(Owner owner) const {
  int n = 0;
  for (int i = 0; i < count_; ++i)
    if (buffers_[static_cast<std::size_t>(i)].owner == owner) ++n;
  return n;
}

int BufferRing::held() const {
  return owned_by(Owner::kUser);
}

int BufferRing::queued() const {
  return owned_by(Owner::kDriver);
}

}  // namespace vergence::v4l2
