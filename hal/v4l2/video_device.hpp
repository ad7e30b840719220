// The system calls that video capture makes, and no more: the seam between it and the kernel, so that all of
// it can be tested without one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vergence::v4l2 {

struct PollEntry {
  int handle = -1;     // negative: left out
  short happened = 0;  // POLLIN, POLLERR, POLLHUP as poll() gives them
};

// Calls answer an error number of errno.h, 0 for none. None but poll() waits for the device.
class VideoSystem {
 public:
  virtual int open(const char* path, int& handle) = 0;  // to read and write, without blocking
  virtual void close(int handle) = 0;
  virtual int control(int handle, unsigned long request, void* argument) = 0;  // ioctl()

  // Returns when one of the devices has something to say, or after timeout_ns.
  virtual int poll(std::span<PollEntry> entries, std::int64_t timeout_ns) = 0;

  virtual int map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) = 0;
  virtual int map_own(std::size_t bytes, std::uint8_t*& memory) = 0;  // memory of no device, whole pages
  virtual void unmap(std::uint8_t* memory, std::size_t bytes) = 0;

 protected:
  ~VideoSystem() = default;
};

}  // namespace vergence::v4l2
