#include "hal/v4l2/negotiation.hpp"

#include <linux/videodev2.h>

#include <cerrno>
#include <cstdlib>

#include "algo/limits.hpp"
#include "hal/v4l2/pixel_formats.hpp"

namespace vergence::v4l2 {
namespace {

struct Driver {
  VideoSystem& system;
  int handle;

  int ask(unsigned long request, void* argument) { return system.control(handle, request, argument); }
};

VideoError capabilities(Driver driver, bool& multi_planar) {
  v4l2_capability can{};
  if (const int e = driver.ask(VIDIOC_QUERYCAP, &can); e != 0) return {VideoFault::kNotACamera, e};
  const std::uint32_t has =
      (can.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? can.device_caps : can.capabilities;
  multi_planar = (has & V4L2_CAP_VIDEO_CAPTURE) == 0;
  if (multi_planar && (has & V4L2_CAP_VIDEO_CAPTURE_MPLANE) == 0) return {VideoFault::kNotACamera};
  if ((has & V4L2_CAP_STREAMING) == 0) return {VideoFault::kNoStreaming};
  return {};
}

VideoError choose_input(Driver driver, const VideoConfig& config) {
  if (config.input >= 0) {
    int index = config.input;
    if (const int e = driver.ask(VIDIOC_S_INPUT, &index); e != 0)
      return {VideoFault::kInput, e, 0, config.input, -1};
    if (const int e = driver.ask(VIDIOC_G_INPUT, &index); e != 0)
      return {VideoFault::kInput, e, 0, config.input, -1};
    if (index != config.input) return {VideoFault::kInput, 0, 0, config.input, index};
  }
  // Whether there is a signal, where the driver knows.
  int index = 0;
  if (driver.ask(VIDIOC_G_INPUT, &index) != 0 || index < 0) return {};
  v4l2_input input{};
  input.index = static_cast<std::uint32_t>(index);
  if (driver.ask(VIDIOC_ENUMINPUT, &input) != 0) return {};
  if ((input.status & (V4L2_IN_ST_NO_POWER | V4L2_IN_ST_NO_SIGNAL)) != 0)
    return {VideoFault::kNoSignal, ENOLINK, 0, config.input, index};
  return {};
}

std::int64_t interval_of(const v4l2_bt_timings& t) {
  const std::uint64_t columns = std::uint64_t{t.width} + t.hfrontporch + t.hsync + t.hbackporch;
  const std::uint64_t rows = std::uint64_t{t.height} + t.vfrontporch + t.vsync + t.vbackporch;
  constexpr std::uint64_t kMost = 1U << 14;
  if (t.pixelclock == 0 || columns > kMost || rows > kMost) return 0;
  return static_cast<std::int64_t>(columns * rows * 1'000'000'000U / t.pixelclock);
}

VideoError take_over_timings(Driver driver, const VideoConfig& config, std::int64_t& interval_ns) {
  if (!config.dv_timings) return {};
  v4l2_dv_timings timings{};
  if (const int e = driver.ask(VIDIOC_QUERY_DV_TIMINGS, &timings); e != 0) {
    const bool is_signal = e == ENOLINK || e == ENOLCK;
    return {is_signal ? VideoFault::kNoSignal : VideoFault::kTimings, e, 0, config.width_px, 0};
  }
  const v4l2_dv_timings found = timings;
  if (const int e = driver.ask(VIDIOC_S_DV_TIMINGS, &timings); e != 0) return {VideoFault::kTimings, e};
  if (const int e = driver.ask(VIDIOC_G_DV_TIMINGS, &timings); e != 0) return {VideoFault::kTimings, e};
  if (timings.bt.width != found.bt.width || timings.bt.height != found.bt.height)
    return {VideoFault::kTimings, 0, 0, found.bt.width, timings.bt.width};
  if (timings.bt.interlaced != 0) return {VideoFault::kInterlaced};
  interval_ns = interval_of(timings.bt);
  return {};
}

// One answer of S_FMT or G_FMT, the same for both kinds of interface.
struct Answer {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t fourcc = 0;
  std::uint32_t field = 0;
  std::uint32_t planes = 1;
  std::array<std::uint32_t, kMaxVideoPlanes> stride{};
  std::array<std::uint32_t, kMaxVideoPlanes> bytes{};
};

Answer read(const v4l2_format& format, bool multi_planar) {
  if (!multi_planar) {
    const v4l2_pix_format& pix = format.fmt.pix;
    return {pix.width, pix.height, pix.pixelformat, pix.field, 1, {pix.bytesperline, 0}, {pix.sizeimage, 0}};
  }
  const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
  Answer answer{pix.width, pix.height, pix.pixelformat, pix.field, pix.num_planes, {}, {}};
  for (std::size_t i = 0; i < kMaxVideoPlanes; ++i) {
    answer.stride[i] = pix.plane_fmt[i].bytesperline;
    answer.bytes[i] = pix.plane_fmt[i].sizeimage;
  }
  return answer;
}

v4l2_format wish(const VideoConfig& config, const KnownFormat& known, bool multi_planar) {
  v4l2_format format{};
  const auto width = static_cast<std::uint32_t>(config.width_px);
  const auto height = static_cast<std::uint32_t>(config.height_px);
  if (multi_planar) {
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
    format.fmt.pix_mp.width = width;
    format.fmt.pix_mp.height = height;
    format.fmt.pix_mp.pixelformat = config.fourcc;
    format.fmt.pix_mp.field = V4L2_FIELD_NONE;
    format.fmt.pix_mp.num_planes = static_cast<std::uint8_t>(known.planes);
  } else {
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = width;
    format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = config.fourcc;
    format.fmt.pix.field = V4L2_FIELD_NONE;
  }
  return format;
}

// Of a whole image: `rows` rows, the last without its padding.
std::size_t extent(std::size_t stride, std::size_t row, std::size_t rows) {
  return stride * (rows - 1) + row;
}

VideoError judge(const Answer& answer, const VideoConfig& config, const KnownFormat& known,
                 StreamFormat& got) {
  if (answer.fourcc != config.fourcc) return {VideoFault::kPixelFormat, 0, 0, config.fourcc, answer.fourcc};
  if (answer.width != static_cast<std::uint32_t>(config.width_px))
    return {VideoFault::kSize, 0, 0, config.width_px, answer.width};
  if (answer.height != static_cast<std::uint32_t>(config.height_px))
    return {VideoFault::kSize, 0, 0, config.height_px, answer.height};
  if (answer.field != V4L2_FIELD_NONE) return {VideoFault::kInterlaced, 0, 0, V4L2_FIELD_NONE, answer.field};
  if (answer.planes != static_cast<std::uint32_t>(known.planes))
    return {VideoFault::kPixelFormat, 0, 0, config.fourcc, answer.fourcc};

  got.fourcc = answer.fourcc;
  got.format = known.format;
  got.width_px = config.width_px;
  got.height_px = config.height_px;
  got.planes = known.planes;
  const auto width = static_cast<std::size_t>(config.width_px);
  const auto height = static_cast<std::size_t>(config.height_px);
  for (std::size_t i = 0; i < static_cast<std::size_t>(known.planes); ++i) {
    const std::size_t row = width * static_cast<std::size_t>(known.row_bytes_per_px);  // NV12: of both planes
    const std::size_t stride = answer.stride[i];
    if (stride < row || stride > kMaxVideoBufferBytes / height)
      return {VideoFault::kStride, 0, 0, static_cast<std::int64_t>(row), answer.stride[i]};
    std::size_t rows = height;
    if (known.format == PixelFormat::kNv12)
      rows = known.planes == 1 ? height + height / 2 : i == 0 ? height : height / 2;
    got.stride_bytes[i] = stride;
    got.needed_bytes[i] = extent(stride, row, rows);
    got.image_bytes[i] = answer.bytes[i];
    if (got.image_bytes[i] < got.needed_bytes[i] || got.image_bytes[i] > kMaxVideoBufferBytes)
      return {VideoFault::kImageBytes, 0, 0, static_cast<std::int64_t>(got.needed_bytes[i]), answer.bytes[i]};
  }
  return {};
}

VideoError choose_format(Driver driver, const VideoConfig& config, StreamFormat& got) {
  const KnownFormat known = *known_format(config.fourcc);
  v4l2_format format = wish(config, known, got.multi_planar);
  if (const int e = driver.ask(VIDIOC_S_FMT, &format); e != 0)
    return {VideoFault::kPixelFormat, e, 0, config.fourcc, 0};
  // What it answers to the setting and what it then holds have been known to differ.
  const std::uint32_t type = format.type;
  format = {};
  format.type = type;
  if (const int e = driver.ask(VIDIOC_G_FMT, &format); e != 0)
    return {VideoFault::kPixelFormat, e, 0, config.fourcc, 0};
  return judge(read(format, got.multi_planar), config, known, got);
}

std::int64_t to_ns(const v4l2_fract& time) {
  if (time.denominator == 0) return 0;
  return static_cast<std::int64_t>(std::uint64_t{time.numerator} * 1'000'000'000U / time.denominator);
}

VideoError choose_interval(Driver driver, const VideoConfig& config, StreamFormat& got) {
  const v4l2_fract asked = {config.interval.numerator, config.interval.denominator};
  const std::int64_t asked_ns = to_ns(asked);
  v4l2_streamparm parm{};
  parm.type = got.multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  int e = driver.ask(VIDIOC_G_PARM, &parm);
  const bool is_settable = e == 0 && (parm.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  if (asked_ns > 0 && is_settable) {
    parm.parm.capture.timeperframe = asked;
    if (e = driver.ask(VIDIOC_S_PARM, &parm); e != 0) return {VideoFault::kInterval, e, 0, asked_ns, 0};
    if (e = driver.ask(VIDIOC_G_PARM, &parm); e != 0) return {VideoFault::kInterval, e, 0, asked_ns, 0};
  }
  // A receiver has no interval of its own; its source's timings have one.
  if (is_settable && to_ns(parm.parm.capture.timeperframe) > 0)
    got.interval_ns = to_ns(parm.parm.capture.timeperframe);
  if (asked_ns > 0 && std::abs(got.interval_ns - asked_ns) > asked_ns / (1'000'000 / kIntervalTolerancePpm))
    return {VideoFault::kInterval, 0, 0, asked_ns, got.interval_ns};
  return {};
}

}  // namespace

VideoError check(const VideoConfig& config) {
  if (config.path[0] == '\0' || config.path.back() != '\0') return {VideoFault::kConfig};
  if (!known_format(config.fourcc)) return {VideoFault::kPixelFormat, 0, 0, config.fourcc, config.fourcc};
  if (config.width_px < 2 || config.width_px > kMaxImageWidth || config.width_px % 2 != 0)
    return {VideoFault::kSize, 0, 0, config.width_px, kMaxImageWidth};
  if (config.height_px < 2 || config.height_px > kMaxImageHeight || config.height_px % 2 != 0)
    return {VideoFault::kSize, 0, 0, config.height_px, kMaxImageHeight};
  if ((config.interval.numerator == 0) != (config.interval.denominator == 0)) return {VideoFault::kInterval};
  if (config.buffers < kMinVideoBuffers || config.buffers > kMaxVideoBuffers)
    return {VideoFault::kBuffers, 0, 0, config.buffers, kMinVideoBuffers};
  if (config.settle_ns < 0 || config.stall_ns <= 0 || config.first_frame_ns < config.stall_ns ||
      config.give_up_ns < config.first_frame_ns)
    return {VideoFault::kConfig};
  return {};
}

VideoError negotiate(VideoSystem& system, int handle, const VideoConfig& config, StreamFormat& got) {
  if (const VideoError error = check(config); !is_ok(error)) return error;
  const Driver driver{system, handle};
  got = {};
  VideoError error = capabilities(driver, got.multi_planar);
  if (is_ok(error)) error = choose_input(driver, config);
  if (is_ok(error)) error = take_over_timings(driver, config, got.interval_ns);
  if (is_ok(error)) error = choose_format(driver, config, got);
  if (is_ok(error)) error = choose_interval(driver, config, got);
  return error;
}

}  // namespace vergence::v4l2
