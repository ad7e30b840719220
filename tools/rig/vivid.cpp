#include "tools/rig/vivid.hpp"

#include <fcntl.h>
#include <linux/v4l2-dv-timings.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

#include "tools/rig/rig_devices.hpp"
#include "tools/rig/rig_error.hpp"

namespace vergence::rig {
namespace {

constexpr std::string_view kLoop = "Loop Video";

template <typename T>
void ask(const FileHandle& device, unsigned long request, T& argument, const std::string& what) {
  if (ioctl(device.get(), request, &argument) != 0) fail_with_errno(what);
}

FileHandle open_vivid(const char* path) {
  FileHandle device(::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!device.is_open()) fail_with_errno(path);
  v4l2_capability can{};
  ask(device, VIDIOC_QUERYCAP, can, path);
  if (std::strcmp(reinterpret_cast<const char*>(can.driver), "vivid") != 0) {
    throw RigError(std::string(path) + " is not of vivid, the kernel's test cameras");
  }
  return device;
}

void set_timings(const FileHandle& device, const char* path) {
  // The header's initialiser names the members of a union without naming the union.
  v4l2_dv_timings timings{};
  timings.type = V4L2_DV_BT_656_1120;
  v4l2_bt_timings& bt = timings.bt;
  bt.width = kWidth_px;
  bt.height = kHeight_px;
  bt.pixelclock = 25'175'000;
  bt.hfrontporch = 16;
  bt.hsync = 96;
  bt.hbackporch = 48;
  bt.vfrontporch = 10;
  bt.vsync = 2;
  bt.vbackporch = 33;
  bt.standards = V4L2_DV_BT_STD_DMT | V4L2_DV_BT_STD_CEA861;
  ask(device, VIDIOC_S_DV_TIMINGS, timings, std::string(path) + ": timings");
}

void set_format(const FileHandle& device, std::uint32_t type, const char* path) {
  v4l2_format format{};
  format.type = type;
  format.fmt.pix.width = kWidth_px;
  format.fmt.pix.height = kHeight_px;
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  format.fmt.pix.colorspace = V4L2_COLORSPACE_SMPTE170M;
  ask(device, VIDIOC_S_FMT, format, std::string(path) + ": format");
  if (format.fmt.pix.pixelformat != V4L2_PIX_FMT_YUYV || format.fmt.pix.sizeimage != kFrameBytes) {
    throw RigError(std::string(path) + " does not take 640x480 YUYV");
  }
}

}  // namespace

Vivid::Vivid(const char* camera, const char* display) : camera_path_(camera), display_path_(display) {
  open();
}

Vivid::~Vivid() {
  close();
}

void Vivid::open() {
  camera_ = open_vivid(camera_path_);
  set_up_camera();
  display_ = open_vivid(display_path_);
  set_up_display();
}

void Vivid::set_up_camera() {
  int input = kCameraInput;
  ask(camera_, VIDIOC_S_INPUT, input, std::string(camera_path_) + ": input");
  set_timings(camera_, camera_path_);
  set_format(camera_, V4L2_BUF_TYPE_VIDEO_CAPTURE, camera_path_);
  // Otherwise it stamps the end of a frame when the frame begins, in the future.
  set_control("Timestamp Source", 1);
  set_control("OSD Text Mode", 2);
  loop_display();
}

void Vivid::set_up_display() {
  int output = kDisplayOutput;
  ask(display_, VIDIOC_S_OUTPUT, output, std::string(display_path_) + ": output");
  set_timings(display_, display_path_);
  set_format(display_, V4L2_BUF_TYPE_VIDEO_OUTPUT, display_path_);
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  request.memory = V4L2_MEMORY_MMAP;
  ask(display_, VIDIOC_REQBUFS, request, std::string(display_path_) + ": buffers");
  if (request.count != kBuffers) throw RigError(std::string(display_path_) + " has too few buffers");
  for (std::uint32_t i = 0; i < kBuffers; ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    ask(display_, VIDIOC_QUERYBUF, buffer, std::string(display_path_) + ": buffers");
    void* memory =
        mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, display_.get(), buffer.m.offset);
    if (memory == MAP_FAILED) fail_with_errno(std::string(display_path_) + ": buffers");
    memory_[i] = {static_cast<std::uint8_t*>(memory), buffer.length};
    std::memset(memory, 0x80, buffer.length);  // grey
  }
  for (std::uint32_t i = 0; i < kBuffers; ++i) queue(i);
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  ask(display_, VIDIOC_STREAMON, type, std::string(display_path_) + ": stream");
}

void Vivid::queue(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.bytesused = kFrameBytes;
  buffer.field = V4L2_FIELD_NONE;
  ask(display_, VIDIOC_QBUF, buffer, std::string(display_path_) + ": picture");
}

template <typename IsIt>
bool Vivid::find_control(IsIt&& is_it, v4l2_queryctrl& query) {
  query = {};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl(camera_.get(), VIDIOC_QUERYCTRL, &query) == 0) {
    if (is_it(std::string_view(reinterpret_cast<const char*>(query.name)))) return true;
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return false;
}

void Vivid::set_control(std::string_view name, int value) {
  v4l2_queryctrl query{};
  if (!find_control([name](std::string_view other) { return other == name; }, query))
    throw RigError(std::string(camera_path_) + " has no control '" + std::string(name) + "'");
  v4l2_control control{query.id, value};
  ask(camera_, VIDIOC_S_CTRL, control, std::string(camera_path_) + ": " + std::string(name));
}

// Linux 6.1 loops all of a device's outputs to its inputs; in 6.12 each input has a menu instead of what its
// plug is in, "HDMI 000-0 Is Connected To", with "Output HDMI 000-0" in it.
void Vivid::loop_display() {
  v4l2_queryctrl plug{};
  if (find_control([](std::string_view name) { return name == kLoop; }, plug)) {
    set_control(kLoop, 1);
    return;
  }
  const auto is_plug = [](std::string_view name) {
    return name.starts_with("HDMI ") && name.ends_with("-0 Is Connected To");
  };
  if (!find_control(is_plug, plug)) {
    throw RigError(std::string(camera_path_) + " has neither a control '" + std::string(kLoop) +
                   "' nor 'HDMI ... Is Connected To': this vivid cannot be looped");
  }
  const std::string name = reinterpret_cast<const char*>(plug.name);
  const std::string output = "Output " + name.substr(0, name.find(" Is"));
  for (int i = plug.minimum; i <= plug.maximum; ++i) {
    v4l2_querymenu item{};
    item.id = plug.id;
    item.index = static_cast<std::uint32_t>(i);
    if (ioctl(camera_.get(), VIDIOC_QUERYMENU, &item) != 0) continue;  // in use by another input
    if (output == reinterpret_cast<const char*>(item.name)) {
      set_control(name, i);
      return;
    }
  }
  throw RigError(std::string(camera_path_) + ": '" + name + "' does not offer '" + output + "'");
}

bool Vivid::show(std::span<const std::uint8_t> yuyv) {
  if (unplugged_) return false;
  for (std::span<std::uint8_t>& memory : memory_) {
    std::copy_n(yuyv.begin(), std::min({yuyv.size(), kFrameBytes, memory.size()}), memory.begin());
  }
  return true;
}

void Vivid::unplug() {
  set_control("Disconnect", 1);
  unplugged_ = true;
}

void Vivid::close() {
  for (std::span<std::uint8_t>& memory : memory_) {
    if (!memory.empty()) munmap(memory.data(), memory.size());
    memory = {};
  }
  display_.reset();
  camera_.reset();
}

void Vivid::plug_in() {
  close();
  unplugged_ = false;
  open();
}

void Vivid::set_dropped_percent(int percent) {
  set_control("Percentage of Dropped Buffers", percent);
}

void Vivid::flag_next_frame() {
  set_control("Inject V4L2_BUF_FLAG_ERROR", 1);
}

}  // namespace vergence::rig
