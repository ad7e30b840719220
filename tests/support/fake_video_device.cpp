#include "tests/support/fake_video_device.hpp"

namespace vergence::testing {

int FakeVideoDevice::control(unsigned long request, void* argument) {
  if (!is_present) return ENODEV;
  if (const auto found = errors_once.find(request); found != errors_once.end()) {
    const int e = found->second;
    errors_once.erase(found);
    return e;
  }
  if (const auto found = errors.find(request); found != errors.end()) return found->second;
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& can = *static_cast<v4l2_capability*>(argument);
      can.device_caps = capabilities;
      can.capabilities = capabilities | V4L2_CAP_DEVICE_CAPS | V4L2_CAP_META_CAPTURE;  // of all its nodes
      return 0;
    }
    case VIDIOC_ENUMINPUT: {
      auto& wish = *static_cast<v4l2_input*>(argument);
      if (wish.index >= static_cast<std::uint32_t>(inputs)) return EINVAL;
      wish.status = input_status;
      return 0;
    }
    case VIDIOC_S_INPUT:
      if (*static_cast<int*>(argument) < 0 || *static_cast<int*>(argument) >= inputs) return EINVAL;
      input = *static_cast<int*>(argument);
      return 0;
    case VIDIOC_G_INPUT: *static_cast<int*>(argument) = input; return 0;
    case VIDIOC_QUERY_DV_TIMINGS:
      if (source.bt.width == 0) return ENOLINK;
      *static_cast<v4l2_dv_timings*>(argument) = source;
      return 0;
    case VIDIOC_S_DV_TIMINGS: timings = *static_cast<v4l2_dv_timings*>(argument); return 0;
    case VIDIOC_G_DV_TIMINGS: *static_cast<v4l2_dv_timings*>(argument) = timings; return 0;
    case VIDIOC_S_FMT: return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_FMT:
      if (static_cast<v4l2_format*>(argument)->type != type()) return EINVAL;
      answer_format(*static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_S_PARM: {
      auto& time = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe;
      const bool is_known = std::any_of(intervals.begin(), intervals.end(), [&](const v4l2_fract& each) {
        return each.numerator == time.numerator && each.denominator == time.denominator;
      });
      interval = is_known ? time : intervals.front();
      time = interval;
      return 0;
    }
    case VIDIOC_G_PARM: {
      if (intervals.empty()) return ENOTTY;
      auto& parm = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      parm.capability = V4L2_CAP_TIMEPERFRAME;
      parm.timeperframe = interval;
      return 0;
    }
    case VIDIOC_QUERYCTRL: {
      auto& range = *static_cast<v4l2_queryctrl*>(argument);
      const auto found = controls.find(range.id);
      if (found == controls.end()) return EINVAL;
      range.minimum = found->second.minimum;
      range.maximum = found->second.maximum;
      return 0;
    }
    case VIDIOC_S_CTRL: return set_control(*static_cast<v4l2_control*>(argument));
    case VIDIOC_G_CTRL: return get_control(*static_cast<v4l2_control*>(argument));
    case VIDIOC_REQBUFS: return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: return query_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF: return queue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF: return dequeue_buffer(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON: return stream(true);
    case VIDIOC_STREAMOFF: return stream(false);
    default: return ENOTTY;
  }
}

// What it cannot do becomes the nearest it can.
int FakeVideoDevice::set_format(v4l2_format& format) {
  if (format.type != type()) return EINVAL;
  if (!buffers.empty()) return EBUSY;
  const bool is_multi = is_multi_planar();
  const std::uint32_t asked = is_multi ? format.fmt.pix_mp.pixelformat : format.fmt.pix.pixelformat;
  const std::uint32_t asked_width = is_multi ? format.fmt.pix_mp.width : format.fmt.pix.width;
  const std::uint32_t asked_height = is_multi ? format.fmt.pix_mp.height : format.fmt.pix.height;
  fourcc = std::find(fourccs.begin(), fourccs.end(), asked) != fourccs.end() ? asked : fourccs.front();
  const auto size = std::find(sizes.begin(), sizes.end(), std::pair{asked_width, asked_height});
  std::tie(width, height) = size != sizes.end() ? *size : sizes.front();
  answer_format(format);
  return 0;
}

void FakeVideoDevice::answer_format(v4l2_format& format) const {
  if (is_multi_planar()) {
    v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    pix.width = width;
    pix.height = height;
    pix.pixelformat = fourcc;
    pix.field = field;
    pix.num_planes = static_cast<std::uint8_t>(plane_count());
    for (std::size_t i = 0; i < plane_count(); ++i) {
      pix.plane_fmt[i].bytesperline = stride(i);
      pix.plane_fmt[i].sizeimage = bytes(i);
    }
  } else {
    v4l2_pix_format& pix = format.fmt.pix;
    pix.width = width;
    pix.height = height;
    pix.pixelformat = fourcc;
    pix.field = field;
    pix.bytesperline = stride(0);
    pix.sizeimage = bytes(0);
  }
}

int FakeVideoDevice::set_control(v4l2_control& wish) {
  const auto found = controls.find(wish.id);
  if (found == controls.end()) return EINVAL;
  FakeControl& control = found->second;
  if (wish.value < control.minimum || wish.value > control.maximum) return ERANGE;
  // Inactive while the automatic has it.
  if (control.automatic != 0 && controls[control.automatic].value != control.manual) return EACCES;
  control.value = wish.value - (wish.value - control.minimum) % control.step;
  return 0;
}

int FakeVideoDevice::get_control(v4l2_control& wish) const {
  const auto found = controls.find(wish.id);
  if (found == controls.end()) return EINVAL;
  const FakeControl& control = found->second;
  const bool is_automatic = control.automatic != 0 && controls.at(control.automatic).value != control.manual;
  wish.value = is_automatic ? control.found : control.value;
  return 0;
}

int FakeVideoDevice::request_buffers(v4l2_requestbuffers& wish) {
  if (wish.type != type()) return EINVAL;
  if (is_streaming || mapped > 0) return EBUSY;
  requests.push_back(wish.count);
  memory_kind = wish.memory;
  wish.count = std::min(wish.count, most_buffers);
  queue.clear();
  done.clear();
  buffers.assign(wish.count, {});
  for (Buffer& buffer : buffers)
    for (std::size_t i = 0; i < plane_count() && memory_kind == V4L2_MEMORY_MMAP; ++i)
      buffer.planes.push_back(std::make_shared<std::vector<std::uint8_t>>(bytes(i)));
  return 0;
}

int FakeVideoDevice::query_buffer(v4l2_buffer& wish) {
  if (wish.type != type() || wish.index >= buffers.size()) return EINVAL;
  const auto offset = [&](std::size_t plane) {
    return static_cast<std::uint32_t>((wish.index * 2 + plane) << 12U);
  };
  if (!is_multi_planar()) {
    wish.length = bytes(0) - buffer_shrinks_by;
    wish.m.offset = offset(0);
    return 0;
  }
  if (wish.length < plane_count()) return EINVAL;
  for (std::size_t i = 0; i < plane_count(); ++i) {
    wish.m.planes[i].length = bytes(i) - buffer_shrinks_by;
    wish.m.planes[i].m.mem_offset = offset(i);
  }
  return 0;
}

int FakeVideoDevice::queue_buffer(v4l2_buffer& wish) {
  if (wish.type != type() || wish.index >= buffers.size() || wish.memory != memory_kind) return EINVAL;
  Buffer& buffer = buffers[wish.index];
  if (buffer.is_queued) return EINVAL;
  if (memory_kind == V4L2_MEMORY_USERPTR) {
    buffer.user.clear();
    for (std::size_t i = 0; i < plane_count(); ++i) {
      const unsigned long address = is_multi_planar() ? wish.m.planes[i].m.userptr : wish.m.userptr;
      const std::uint32_t length = is_multi_planar() ? wish.m.planes[i].length : wish.length;
      if (address == 0 || length < bytes(i)) return EINVAL;
      buffer.user.push_back(reinterpret_cast<std::uint8_t*>(address));
    }
  }
  buffer.is_queued = true;
  buffer.is_done = false;
  queue.push_back(wish.index);
  return 0;
}

int FakeVideoDevice::dequeue_buffer(v4l2_buffer& wish) {
  if (wish.type != type() || wish.memory != memory_kind || !is_streaming) return EINVAL;
  if (has_error_state || done.empty()) return EAGAIN;
  const std::uint32_t index = done.front();
  done.pop_front();
  Buffer& buffer = buffers[index];
  buffer.is_queued = false;
  wish.index = index;
  wish.flags = buffer.result.flags;
  wish.sequence = buffer.result.sequence;
  wish.timestamp = buffer.result.timestamp;
  const auto used = [&](std::size_t plane) {
    return buffer.result.bytesused != 0 ? buffer.result.bytesused : bytes(plane);
  };
  if (!is_multi_planar()) {
    wish.bytesused = used(0);
    wish.length = bytes(0);
    return 0;
  }
  for (std::size_t i = 0; i < plane_count(); ++i) {
    wish.m.planes[i].bytesused = used(i);
    wish.m.planes[i].data_offset = data_offset;
    wish.m.planes[i].length = bytes(i);
  }
  return 0;
}

int FakeVideoDevice::stream(bool on) {
  if (on && buffers.empty()) return EINVAL;
  if (on) {
    ++streams_begun;
    sequence = 0;
  } else {
    for (Buffer& buffer : buffers) buffer.is_queued = buffer.is_done = false;
    queue.clear();
    done.clear();
    has_error_state = false;
  }
  is_streaming = on;
  return 0;
}

}  // namespace vergence::testing
