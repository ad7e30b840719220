// A triple buffer that tells the writer what it got back: values that own something (buffers of a driver)
// pass from one thread to another without copying, locking or waiting, and each comes back exactly once.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace vergence::v4l2 {

template <typename T>
class Exchange {
 public:
  // The writer's side. Returns a value that nobody has any more: the reader passed over it, or was done with
  // it.
  [[nodiscard]] T offer(const T& value) {
    places_[writing_] = value;
    const std::uint32_t before = middle_.exchange(writing_ | kFresh, std::memory_order_acq_rel);
    writing_ = before & kPlace;
    return places_[writing_];
  }
  // Whether the reader has what was offered last; then the one it had before comes back with the next offer.
  [[nodiscard]] bool is_taken() const { return (middle_.load(std::memory_order_acquire) & kFresh) == 0; }

  // The reader's side: the newest value, valid until the next call that finds one; null where there is none.
  [[nodiscard]] const T* take() {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return nullptr;
    const std::uint32_t before = middle_.exchange(reading_, std::memory_order_acq_rel);
    reading_ = before & kPlace;
    return &places_[reading_];
  }

 private:
  static constexpr std::uint32_t kPlace = 3;
  static constexpr std::uint32_t kFresh = 4;

  std::array<T, 3> places_{};
  std::uint32_t writing_ = 0;             // the writer's alone
  std::atomic<std::uint32_t> middle_{1};  // a place, and whether it holds what was not taken
  std::uint32_t reading_ = 2;             // the reader's alone
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
};

}  // namespace vergence::v4l2
