// A list in an array of fixed size.
#pragma once

#include <array>
#include <cstddef>

namespace vergence::canopen {

template <typename T, std::size_t kCapacity>
class FixedList {
 public:
  // False where it is full; what is there stays.
  constexpr bool add(const T& item) {
    if (size_ == kCapacity) return false;
    items_[size_++] = item;
    return true;
  }
  constexpr void clear() { size_ = 0; }
  constexpr void drop_first() {
    if (size_ == 0) return;
    for (std::size_t i = 1; i < size_; ++i) items_[i - 1] = items_[i];
    --size_;
  }

  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
  [[nodiscard]] constexpr const T& operator[](std::size_t i) const { return items_[i]; }
  [[nodiscard]] constexpr const T* begin() const { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, kCapacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace vergence::canopen
