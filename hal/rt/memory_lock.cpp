#include "hal/rt/memory_lock.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace vergence::rt {
namespace {

[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kSmallestPage_bytes = 4096;
  std::array<volatile char, kPrefaultedStack_bytes> stack;
  for (std::size_t i = 0; i < stack.size(); i += kSmallestPage_bytes) stack[i] = 0;
}

// So that no call of the C library can give memory back or take new pages after the lock: drivers may still
// allocate while devices open.
bool keep_heap() {
  const bool no_trim = mallopt(M_TRIM_THRESHOLD, -1) == 1;
  const bool no_maps = mallopt(M_MMAP_MAX, 0) == 1;
  return no_trim && no_maps;
}

}  // namespace

const char* describe(MemoryLockError error) {
  switch (error) {
    case MemoryLockError::kNone: return "no error";
    case MemoryLockError::kNotPermitted:
      return "memory may not be locked: grant CAP_IPC_LOCK, or LimitMEMLOCK=infinity in the unit, or memlock "
             "in /etc/security/limits.conf";
    case MemoryLockError::kOverLimit:
      return "more memory than RLIMIT_MEMLOCK allows: LimitMEMLOCK=infinity in the unit, or memlock in "
             "/etc/security/limits.conf, or CAP_IPC_LOCK";
    case MemoryLockError::kFailed: return "memory could not be locked: see errno";
  }
  return "unknown error";
}

MemoryLockError memory_lock_error(int error_number) {
  switch (error_number) {
    case 0: return MemoryLockError::kNone;
    case EPERM: return MemoryLockError::kNotPermitted;
    case ENOMEM: return MemoryLockError::kOverLimit;
    default: return MemoryLockError::kFailed;
  }
}

MemoryLock lock_memory() {
  MemoryLock lock;
  lock.heap_is_kept = keep_heap();
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) lock.error_number = errno;
  lock.error = memory_lock_error(lock.error_number);
  touch_stack();
  return lock;
}

void unlock_memory() {
  (void)munlockall();
}

const char* describe(CpuLatencyError error) {
  switch (error) {
    case CpuLatencyError::kNone: return "no error";
    case CpuLatencyError::kNoDevice:
      return "no /dev/cpu_dma_latency: pass the device to the container, or boot with "
             "processor.max_cstate=1 intel_idle.max_cstate=0";
    case CpuLatencyError::kNotPermitted:
      return "/dev/cpu_dma_latency may not be written: a udev rule gives it to the controller's group "
             "(KERNEL==\"cpu_dma_latency\", GROUP=\"vergence\", MODE=\"0660\")";
    case CpuLatencyError::kFailed: return "/dev/cpu_dma_latency did not take the request: see errno";
  }
  return "unknown error";
}

CpuLatencyError CpuLatencyRequest::hold(const char* device) {
  release();
  errno_ = 0;
  file_ = open(device, O_WRONLY | O_CLOEXEC);
  if (file_ < 0) {
    errno_ = errno;
    if (errno_ == ENOENT || errno_ == ENXIO || errno_ == ENODEV) return CpuLatencyError::kNoDevice;
    return errno_ == EACCES || errno_ == EPERM ? CpuLatencyError::kNotPermitted : CpuLatencyError::kFailed;
  }
  // Binary, in microseconds; it counts for as long as the file is open.
  const std::int32_t latency_us = 0;
  if (write(file_, &latency_us, sizeof latency_us) != static_cast<ssize_t>(sizeof latency_us)) {
    const int error = errno;
    release();
    errno_ = error;
    return CpuLatencyError::kFailed;
  }
  return CpuLatencyError::kNone;
}

void CpuLatencyRequest::release() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

}  // namespace vergence::rt
