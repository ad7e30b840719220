// The system calls of video capture over cameras in memory, in virtual time: poll() moves the clock to the
// next frame or to the end of the wait.
#pragma once

#include <linux/dma-buf.h>

#include <map>
#include <vector>

#include "hal/v4l2/v4l2_config.hpp"
#include "hal/v4l2/video_device.hpp"
#include "tests/support/fake_video_device.hpp"

namespace vergence::testing {

class FakeVideoSystem final : public v4l2::VideoSystem {
 public:
  std::vector<FakeVideoDevice*> devices;
  std::int64_t longest_poll_ns = 0;
  int polls = 0;
  int map_error = 0;
  int syncs_begun = 0;  // of DMA-BUFs
  int syncs_ended = 0;

  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }
  [[nodiscard]] std::size_t open_handles() const { return handles_.size(); }
  [[nodiscard]] std::size_t live_maps() const { return maps_.size(); }

  int open(const char* path, int& handle) override {
    for (FakeVideoDevice* device : devices) {
      if (device->path != path || !device->is_present) continue;
      handle = next_handle_++;
      handles_[handle] = {device, device->generation, nullptr};
      return 0;
    }
    return ENOENT;
  }

  void close(int handle) override {
    const auto found = handles_.find(handle);
    if (found == handles_.end()) return;
    const Handle& h = found->second;
    if (h.exported == nullptr && h.generation == h.device->generation) h.device->let_go();
    handles_.erase(found);
  }

  int control(int handle, unsigned long request, void* argument) override {
    const auto found = handles_.find(handle);
    if (found == handles_.end()) return EBADF;
    Handle& h = found->second;
    if (h.exported != nullptr) {
      if (request != DMA_BUF_IOCTL_SYNC) return ENOTTY;
      const bool is_end = (static_cast<dma_buf_sync*>(argument)->flags & DMA_BUF_SYNC_END) != 0;
      ++(is_end ? syncs_ended : syncs_begun);
      return 0;
    }
    if (h.generation != h.device->generation) return ENODEV;
    if (request == VIDIOC_EXPBUF) return export_buffer(*h.device, *static_cast<v4l2_exportbuffer*>(argument));
    return h.device->control(request, argument);
  }

  int poll(std::span<v4l2::PollEntry> entries, std::int64_t timeout_ns) override {
    ++polls;
    longest_poll_ns = std::max(longest_poll_ns, timeout_ns);
    const std::int64_t until_ns = now_ns_ + timeout_ns;
    for (;;) {
      for (FakeVideoDevice* device : devices) device->run_until(now_ns_);
      bool any = false;
      for (v4l2::PollEntry& entry : entries) {
        const auto found = handles_.find(entry.handle);
        entry.happened = 0;
        if (found == handles_.end()) continue;
        const Handle& h = found->second;
        entry.happened = h.generation != h.device->generation ? short{POLLERR | POLLHUP} : h.device->events();
        any = any || entry.happened != 0;
      }
      if (any || now_ns_ >= until_ns) return 0;
      now_ns_ = until_ns;
      for (const FakeVideoDevice* device : devices) now_ns_ = std::min(now_ns_, device->next_frame_ns);
    }
  }

  int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) override {
    const auto found = handles_.find(handle);
    if (map_error != 0 || found == handles_.end()) return map_error != 0 ? map_error : EBADF;
    const Handle& h = found->second;
    if (h.exported != nullptr) return keep(h.exported, bytes, nullptr, memory);
    const auto at = static_cast<std::size_t>(offset) >> 12U;
    if (at / 2 >= h.device->buffers.size() || at % 2 >= h.device->buffers[at / 2].planes.size())
      return EINVAL;
    return keep(h.device->buffers[at / 2].planes[at % 2], bytes, h.device, memory);
  }

  int map_own(std::size_t bytes, std::uint8_t*& memory) override {
    if (map_error != 0) return map_error;
    return keep(std::make_shared<std::vector<std::uint8_t>>(bytes), bytes, nullptr, memory);
  }

  void unmap(std::uint8_t* memory, std::size_t /*bytes*/) override {
    const auto found = maps_.find(memory);
    if (found == maps_.end()) return;
    if (FakeVideoDevice* device = found->second.device; device != nullptr && device->mapped > 0)
      --device->mapped;
    pinned_.push_back(found->second.memory);  // as the kernel keeps pages that a driver may still write to
    if (!is_pinned(memory)) pinned_.pop_back();
    maps_.erase(found);
  }

 private:
  struct Handle {
    FakeVideoDevice* device = nullptr;
    int generation = 0;
    Memory exported;
  };
  struct Map {
    Memory memory;
    FakeVideoDevice* device = nullptr;
  };

  [[nodiscard]] bool is_pinned(const std::uint8_t* memory) const {
    for (const FakeVideoDevice* device : devices)
      for (const FakeVideoDevice::Buffer& buffer : device->buffers)
        if (std::find(buffer.user.begin(), buffer.user.end(), memory) != buffer.user.end()) return true;
    return false;
  }

  int keep(const Memory& owned, std::size_t bytes, FakeVideoDevice* device, std::uint8_t*& memory) {
    if (bytes > owned->size()) return EINVAL;
    memory = owned->data();
    maps_[memory] = {owned, device};
    if (device != nullptr) ++device->mapped;
    return 0;
  }

  int export_buffer(FakeVideoDevice& device, v4l2_exportbuffer& wish) {
    if (const auto e = device.errors.find(VIDIOC_EXPBUF); e != device.errors.end()) return e->second;
    if (wish.index >= device.buffers.size() || wish.plane >= device.plane_count()) return EINVAL;
    wish.fd = next_handle_++;
    handles_[wish.fd] = {&device, device.generation, device.buffers[wish.index].planes[wish.plane]};
    return 0;
  }

  std::int64_t now_ns_ = 0;
  int next_handle_ = 3;
  std::map<int, Handle> handles_;
  std::map<std::uint8_t*, Map> maps_;
  std::vector<Memory> pinned_;
};

inline v4l2::VideoConfig config_of(const FakeVideoDevice& device) {
  v4l2::VideoConfig config;
  device.path.copy(config.path.data(), config.path.size() - 1);
  config.fourcc = device.fourccs.front();
  config.width_px = 640;
  config.height_px = 480;
  config.interval = {1, 30};
  return config;
}

}  // namespace vergence::testing
