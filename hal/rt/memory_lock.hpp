// The one place that keeps memory where it is and the processor awake: all pages locked and touched before
// the tasks start, and no deep idle state while one of CpuLatencyRequest lives.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vergence::rt {

// Of the stack of the thread that calls lock_memory(); those of RtThread are touched when they are painted.
inline constexpr std::size_t kPrefaultedStack_bytes = std::size_t{256} * 1024;

enum class MemoryLockError : std::uint8_t {
  kNone,
  kNotPermitted,  // EPERM: no right to lock any memory
  kOverLimit,     // ENOMEM: more than may be locked
  kFailed,        // otherwise
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(MemoryLockError error);
[[nodiscard]] MemoryLockError memory_lock_error(int error_number);

struct MemoryLock {
  MemoryLockError error = MemoryLockError::kNone;
  int error_number = 0;
  // The C library took the settings by which it keeps what it has: freed memory is not given back, and large
  // blocks are not mapped apart. Sanitizers' allocators do not.
  bool heap_is_kept = false;
};

// Locks all memory the process has and will have, and touches the caller's stack. Once, before the tasks
// start, from the main thread (at least kPrefaultedStack_bytes of stack must be left).
[[nodiscard]] MemoryLock lock_memory();
// For measurements that end before the process does.
void unlock_memory();

enum class CpuLatencyError : std::uint8_t {
  kNone,
  kNoDevice,      // the kernel or the container has none
  kNotPermitted,  // to write it
  kFailed,        // otherwise: last_errno()
};
[[nodiscard]] const char* describe(CpuLatencyError error);

class CpuLatencyRequest {
 public:
  CpuLatencyRequest() = default;
  ~CpuLatencyRequest() { release(); }
  CpuLatencyRequest(const CpuLatencyRequest&) = delete;
  CpuLatencyRequest& operator=(const CpuLatencyRequest&) = delete;

  // Asks that no core take longer than 0 us to wake, until release().
  [[nodiscard]] CpuLatencyError hold(const char* device = "/dev/cpu_dma_latency");
  void release();
  [[nodiscard]] bool is_held() const { return file_ >= 0; }
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  int file_ = -1;
  int errno_ = 0;
};

}  // namespace vergence::rt
