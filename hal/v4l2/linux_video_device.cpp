#include "hal/v4l2/linux_video_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

namespace vergence::v4l2 {
namespace {

constexpr int kMaxPolled = 4;
constexpr int kInterrupts = 100;  // a call that signals interrupt more often has failed

int keep(void* mapped, std::uint8_t*& memory) {
  if (mapped == MAP_FAILED) return errno;
  memory = static_cast<std::uint8_t*>(mapped);
  return 0;
}

}  // namespace

int LinuxVideoSystem::open(const char* path, int& handle) {
  const int opened = ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (opened < 0) return errno;
  handle = opened;
  return 0;
}

void LinuxVideoSystem::close(int handle) {
  ::close(handle);
}

int LinuxVideoSystem::control(int handle, unsigned long request, void* argument) {
  for (int i = 0; i < kInterrupts; ++i) {
    if (::ioctl(handle, request, argument) >= 0) return 0;
    if (errno != EINTR) return errno;
  }
  return EINTR;
}

// An interrupted wait is over: the caller looks at the clock and waits again.
int LinuxVideoSystem::poll(std::span<PollEntry> entries, std::int64_t timeout_ns) {
  std::array<pollfd, kMaxPolled> polled{};
  if (entries.size() > polled.size()) return EINVAL;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    polled[i] = {entries[i].handle, POLLIN, 0};
    entries[i].happened = 0;
  }
  const std::int64_t wait_ns = std::max<std::int64_t>(timeout_ns, 0);
  const timespec wait{static_cast<std::time_t>(wait_ns / 1'000'000'000),
                      static_cast<long>(wait_ns % 1'000'000'000)};
  const int ready = ::ppoll(polled.data(), entries.size(), &wait, nullptr);
  if (ready < 0) return errno == EINTR ? 0 : errno;
  for (std::size_t i = 0; i < entries.size(); ++i) entries[i].happened = polled[i].revents;
  return 0;
}

int LinuxVideoSystem::map(int handle, std::size_t bytes, std::int64_t offset, std::uint8_t*& memory) {
  // Some drivers' memory cannot be mapped for reading alone.
  return keep(::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, handle, static_cast<off_t>(offset)),
              memory);
}

int LinuxVideoSystem::map_own(std::size_t bytes, std::uint8_t*& memory) {
  return keep(::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0), memory);
}

void LinuxVideoSystem::unmap(std::uint8_t* memory, std::size_t bytes) {
  ::munmap(memory, bytes);
}

}  // namespace vergence::v4l2
