// The system calls of video capture, made for real.
#pragma once

#include "hal/v4l2/video_device.hpp"

namespace vergence::v4l2 {

class LinuxVideoSystem final : public VideoSystem {
 public:
  int open(const char* path, int& handle) override;
  void close(int handle) override;
  int control(int handle, unsigned long request, void* argument) override;
  int poll(std::span<PollEntry> entries, std::int64_t timeout_ns) override;
  int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) override;
  int map_own(std::size_t bytes, std::uint8_t*& memory) override;
  void unmap(std::uint8_t* memory, std::size_t bytes) override;
};

}  // namespace vergence::v4l2
