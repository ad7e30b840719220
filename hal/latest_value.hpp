// How tasks meet: a mailbox that holds the latest value, never a queue and never a lock. One task writes, one
// reads; neither waits, retries or fails, however they interrupt each other (a triple buffer: each side owns
// one of three places, and they swap the third).
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace vergence {

template <typename T>
class LatestValue {
 public:
  // The writer's side.
  void write(const T& value) {
    places_[writing_] = value;
    const std::uint32_t before = middle_.exchange(writing_ | kFresh, std::memory_order_acq_rel);
    writing_ = before & kPlace;
  }

  // The reader's side: whether a value came that was not read yet; if so, it is in `value` now. Values in
  // between are passed over.
  [[nodiscard]] bool read(T& value) {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    const std::uint32_t before = middle_.exchange(reading_, std::memory_order_acq_rel);
    reading_ = before & kPlace;
    value = places_[reading_];
    return true;
  }

 private:
  static constexpr std::uint32_t kPlace = 3;
  static constexpr std::uint32_t kFresh = 4;

  std::array<T, 3> places_{};
  std::uint32_t writing_ = 0;             // the writer's alone
  std::atomic<std::uint32_t> middle_{1};  // a place, and whether it holds what was not read
  std::uint32_t reading_ = 2;             // the reader's alone
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
};

}  // namespace vergence
