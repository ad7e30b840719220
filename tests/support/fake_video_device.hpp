// A camera as the V4L2 specification describes it, in memory, with faults to order. Single-planar as USB
// cameras are, or multi-planar as those of embedded processors are.
#pragma once

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "hal/v4l2/pixel_formats.hpp"

namespace vergence::testing {

using Memory = std::shared_ptr<std::vector<std::uint8_t>>;

struct FakeControl {
  std::int32_t minimum = 0;
  std::int32_t maximum = 255;
  std::int32_t value = 100;
  std::uint32_t automatic = 0;  // the control that takes it over, if any
  std::int32_t manual = 0;      // and its value that does not
  std::int32_t found = 0;       // what the automatic arrives at
  std::int32_t step = 1;        // values in between become the one below
};

class FakeVideoDevice {
 public:
  // What it is.
  std::string path = "/dev/video0";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> fourccs = {V4L2_PIX_FMT_YUYV};  // the first is what it gives instead of others
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes = {{640, 480}, {320, 240}};
  std::vector<v4l2_fract> intervals = {{1, 30}, {1, 60}};
  int inputs = 1;
  std::uint32_t input_status = 0;
  v4l2_dv_timings source{};
  std::map<std::uint32_t, FakeControl> controls;
  std::uint32_t most_buffers = 32;
  std::int64_t period_ns = 33'333'333;
  std::int64_t next_frame_ns = 5'000'000;

  // What is wrong with it.
  std::map<unsigned long, int> errors;       // of a request, from now on
  std::map<unsigned long, int> errors_once;  // of the next such request
  std::uint32_t padding_bytes = 0;           // of a row
  std::int64_t row_bytes = -1;               // whatever the format needs
  std::int64_t image_bytes = -1;
  std::uint32_t field = V4L2_FIELD_NONE;
  std::uint32_t buffer_shrinks_by = 0;  // in QUERYBUF
  std::uint32_t data_offset = 0;        // of a plane, multi-planar only
  bool stalls = false;
  int flagged = 0;  // of the frames to come
  int incomplete = 0;
  std::uint32_t skips = 0;  // sequence numbers before the next frame
  std::int64_t stamp_offset_ns = 0;
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  bool has_error_state = false;  // poll() says POLLERR, DQBUF has nothing, until the stream is off

  // What became of it.
  bool is_present = true;
  int generation = 0;  // rises with each unplugging
  bool is_streaming = false;
  int input = 0;
  v4l2_dv_timings timings{};
  std::uint32_t fourcc = V4L2_PIX_FMT_YUYV;
  std::uint32_t width = 640;
  std::uint32_t height = 480;
  v4l2_fract interval = {1, 30};
  std::uint32_t memory_kind = 0;
  std::uint32_t sequence = 0;
  std::vector<std::uint32_t> requests;  // counts asked of REQBUFS
  int streams_begun = 0;

  struct Buffer {
    std::vector<Memory> planes;       // the driver's own
    std::vector<std::uint8_t*> user;  // or the user's
    bool is_queued = false;
    bool is_done = false;
    v4l2_buffer result{};
  };
  std::vector<Buffer> buffers;
  std::deque<std::uint32_t> queue;
  std::deque<std::uint32_t> done;
  int mapped = 0;  // planes that somebody has mapped

  [[nodiscard]] bool is_multi_planar() const { return (capabilities & V4L2_CAP_VIDEO_CAPTURE) == 0; }
  [[nodiscard]] std::uint32_t type() const {
    return is_multi_planar() ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  }
  [[nodiscard]] std::size_t plane_count() const { return fourcc == V4L2_PIX_FMT_NV12M ? 2 : 1; }

  void unplug() {
    is_present = false;
    ++generation;
    let_go();
    mapped = 0;
  }
  // The last handle is closed.
  void let_go() {
    is_streaming = false;
    has_error_state = false;
    buffers.clear();
    queue.clear();
    done.clear();
  }
  // As another one of the same make: nothing that was set is left.
  void plug() {
    is_present = true;
    for (auto& [id, control] : controls) control.value = control.minimum;
  }

  [[nodiscard]] std::uint32_t stride(std::size_t plane) const {
    if (row_bytes >= 0) return static_cast<std::uint32_t>(row_bytes);
    const auto known = v4l2::known_format(fourcc);
    const int bytes = known ? known->row_bytes_per_px : 1;
    return width * static_cast<std::uint32_t>(bytes) + padding_bytes + (plane == 0 ? 0 : 16);
  }
  [[nodiscard]] std::uint32_t bytes(std::size_t plane) const {
    if (image_bytes >= 0) return static_cast<std::uint32_t>(image_bytes);
    std::uint32_t rows = height;
    if (fourcc == V4L2_PIX_FMT_NV12) rows = height * 3 / 2;
    if (fourcc == V4L2_PIX_FMT_NV12M && plane == 1) rows = height / 2;
    return stride(plane) * rows + data_offset;
  }

  // Frames whose time has come.
  void run_until(std::int64_t now_ns) {
    for (; next_frame_ns <= now_ns; next_frame_ns += period_ns) {
      if (!is_present || !is_streaming || stalls) continue;
      sequence += skips;
      skips = 0;
      if (!queue.empty()) deliver();
      ++sequence;
    }
  }

  [[nodiscard]] short events() const {
    if (!is_present) return POLLERR | POLLHUP;
    if (!is_streaming || has_error_state) return POLLERR;
    return done.empty() ? short{0} : short{POLLIN};
  }

  int control(unsigned long request, void* argument);

 private:
  void deliver() {
    const std::uint32_t index = queue.front();
    queue.pop_front();
    Buffer& buffer = buffers[index];
    buffer.is_done = true;
    v4l2_buffer& result = buffer.result;
    result = {};
    result.sequence = sequence;
    result.flags = stamp_flags | (flagged > 0 ? V4L2_BUF_FLAG_ERROR : 0U);
    if (flagged > 0) --flagged;
    const std::int64_t stamp_ns = next_frame_ns + stamp_offset_ns;
    result.timestamp = {stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000 / 1000};
    result.bytesused = incomplete > 0 ? 1000 : 0;  // 0: all of it
    if (incomplete > 0) --incomplete;
    for (std::size_t i = 0; i < plane_count(); ++i) {
      std::uint8_t* memory = buffer.user.empty() ? buffer.planes[i]->data() : buffer.user[i];
      std::memset(memory, static_cast<int>(sequence & 0xFFU), bytes(i));
    }
    done.push_back(index);
  }

  int set_format(v4l2_format& format);
  void answer_format(v4l2_format& format) const;
  int set_control(v4l2_control& wish);
  int get_control(v4l2_control& wish) const;
  int request_buffers(v4l2_requestbuffers& wish);
  int query_buffer(v4l2_buffer& wish);
  int queue_buffer(v4l2_buffer& wish);
  int dequeue_buffer(v4l2_buffer& wish);
  int stream(bool on);
};

}  // namespace vergence::testing
