// Where something was at any recent instant: the last samples, with straight lines between them. A frame is
// older than what the tasks know by the time it is looked at; its hand and eyes are read from here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vergence {

template <std::size_t kValues, std::size_t kSamples = 64>
class MotionHistory {
 public:
  using Values = std::array<double, kValues>;

  void clear() { count_ = 0; }

  // Stamps must rise; others are left out.
  void add(std::int64_t stamp_ns, const Values& values) {
    if (count_ > 0 && stamp_ns <= stamps_ns_[newest()]) return;
    const std::size_t place = count_ % kSamples;
    stamps_ns_[place] = stamp_ns;
    values_[place] = values;
    ++count_;
  }

  // False where nothing is known of that instant: before the oldest sample, or more than `ahead_ns` after
  // the newest, which then stands for it.
  [[nodiscard]] bool at(std::int64_t t_ns, std::int64_t ahead_ns, Values& values) const {
    if (count_ == 0) return false;
    std::size_t later = newest();
    if (t_ns >= stamps_ns_[later]) {
      values = values_[later];
      return t_ns - stamps_ns_[later] <= ahead_ns;
    }
    const std::size_t kept = count_ < kSamples ? count_ : kSamples;
    for (std::size_t i = 1; i < kept; ++i) {
      const std::size_t earlier = (count_ - 1 - i) % kSamples;
      if (stamps_ns_[earlier] <= t_ns) {
        const double share = static_cast<double>(t_ns - stamps_ns_[earlier]) /
                             static_cast<double>(stamps_ns_[later] - stamps_ns_[earlier]);
        for (std::size_t k = 0; k < kValues; ++k) {
          values[k] = values_[earlier][k] + share * (values_[later][k] - values_[earlier][k]);
        }
        return true;
      }
      later = earlier;
    }
    return false;
  }

 private:
  [[nodiscard]] std::size_t newest() const { return (count_ - 1) % kSamples; }

  std::array<std::int64_t, kSamples> stamps_ns_{};
  std::array<Values, kSamples> values_{};
  std::size_t count_ = 0;
};

}  // namespace vergence
