// Interposes the C allocator, which operator new uses too, by glibc's own second names for it.
#include "tests/noheap/heap_counter.hpp"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>

namespace {

std::atomic<bool> armed{false};
std::atomic<long> counted{0};

void count() {
  if (armed.load(std::memory_order_relaxed)) counted.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

extern "C" {

void* __libc_malloc(std::size_t);                 // NOLINT
void* __libc_calloc(std::size_t, std::size_t);    // NOLINT
void* __libc_realloc(void*, std::size_t);         // NOLINT
void __libc_free(void*);                          // NOLINT
void* __libc_memalign(std::size_t, std::size_t);  // NOLINT

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count();
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) {
  count();
  return __libc_realloc(block, size);
}
void free(void* block) {
  count();
  __libc_free(block);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  count();
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? ENOMEM : 0;
}

// The C library asks the kernel by itself, so these see only what others ask for.
void* mmap(void* place, std::size_t bytes, int protection, int flags, int file, off_t offset) noexcept {
  count();
  // The kernel answers with an address.
  return reinterpret_cast<void*>(::syscall(SYS_mmap, place, bytes, protection, flags, file, offset));
}
int munmap(void* place, std::size_t bytes) noexcept {
  count();
  return static_cast<int>(::syscall(SYS_munmap, place, bytes));
}
int brk(void*) noexcept {
  count();
  errno = ENOMEM;
  return -1;
}
void* sbrk(std::intptr_t) noexcept {
  count();
  errno = ENOMEM;
  return reinterpret_cast<void*>(-1);
}

}  // extern "C"

namespace vergence::testing {

HeapCounter::HeapCounter() {
  counted = 0;
  armed = true;
}
HeapCounter::~HeapCounter() {
  armed = false;
}

long HeapCounter::calls() const {
  return counted.load();
}

}  // namespace vergence::testing
