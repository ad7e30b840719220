// How long something took, over any number of times, in fixed memory: buckets whose width is a sixteenth of
// their octave, so a quantile is known to 1/16 from 1 ns to 18 minutes. Count, least, greatest and sum are
// exact.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace vergence::rt {

class DurationHistogram {
 public:
  static constexpr int kOctaveBits = 4;  // 16 buckets an octave
  static constexpr int kOctaves = 36;
  static constexpr std::size_t kBuckets = (std::size_t{1} << kOctaveBits) * (kOctaves + 1);
  // What is longer is counted in the last bucket.
  static constexpr std::int64_t kLongest_ns = (std::int64_t{1} << (kOctaves + kOctaveBits)) - 1;

  struct Bucket {
    std::int64_t least_ns = 0;     // that it counts
    std::int64_t greatest_ns = 0;  // of the last bucket: without end
    std::uint64_t count = 0;
  };

  // Less than nothing counts as nothing.
  void add(std::int64_t duration_ns) {
    const std::int64_t ns = std::max<std::int64_t>(duration_ns, 0);
    ++counts_[index(ns)];
    ++count_;
    min_ns_ = std::min(min_ns_, ns);
    max_ns_ = std::max(max_ns_, ns);
    sum_ns_ = ns > std::numeric_limits<std::int64_t>::max() - sum_ns_
                  ? std::numeric_limits<std::int64_t>::max()
                  : sum_ns_ + ns;
  }
  // As if all of `other` had been added here.
  void add(const DurationHistogram& other) {
    for (std::size_t i = 0; i < kBuckets; ++i) counts_[i] += other.counts_[i];
    count_ += other.count_;
    min_ns_ = std::min(min_ns_, other.min_ns_);
    max_ns_ = std::max(max_ns_, other.max_ns_);
    sum_ns_ = other.sum_ns_ > std::numeric_limits<std::int64_t>::max() - sum_ns_
                  ? std::numeric_limits<std::int64_t>::max()
                  : sum_ns_ + other.sum_ns_;
  }
  void clear() { *this = {}; }

  [[nodiscard]] std::uint64_t count() const { return count_; }
  // 0 while there is nothing.
  [[nodiscard]] std::int64_t min_ns() const { return count_ == 0 ? 0 : min_ns_; }
  [[nodiscard]] std::int64_t max_ns() const { return max_ns_; }
  [[nodiscard]] std::int64_t sum_ns() const { return sum_ns_; }
  [[nodiscard]] std::int64_t mean_ns() const {
    return count_ == 0 ? 0 : static_cast<std::int64_t>(static_cast<std::uint64_t>(sum_ns_) / count_);
  }

  // What a share q in [0, 1] of the durations does not exceed: never below the true quantile, above it by at
  // most 1/16, and exact for q = 1. 0 while there is nothing.
  [[nodiscard]] std::int64_t quantile_upper_bound_ns(double q) const {
    if (count_ == 0) return 0;
    const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(count_);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i + 1 < kBuckets; ++i) {
      seen += counts_[i];
      if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(greatest_in(i), max_ns_);
    }
    return max_ns_;
  }

  [[nodiscard]] Bucket bucket(std::size_t i) const {
    const bool last = i + 1 == kBuckets;
    return {least_in(i), last ? std::numeric_limits<std::int64_t>::max() : greatest_in(i), counts_[i]};
  }

 private:
  // Below 16 a bucket a nanosecond; above, by the octave and the four bits that follow its first.
  static constexpr std::size_t index(std::int64_t ns) {
    const auto value = static_cast<std::uint64_t>(std::min(ns, kLongest_ns));
    if (value < (1U << kOctaveBits)) return static_cast<std::size_t>(value);
    const int shift = static_cast<int>(std::bit_width(value)) - (kOctaveBits + 1);
    return (static_cast<std::size_t>(shift) << kOctaveBits) + static_cast<std::size_t>(value >> shift);
  }
  static constexpr std::int64_t least_in(std::size_t i) {
    if (i < (2U << kOctaveBits)) return static_cast<std::int64_t>(i);
    const std::size_t shift = (i >> kOctaveBits) - 1;
    const std::size_t leading = (i & ((1U << kOctaveBits) - 1)) + (1U << kOctaveBits);
    return static_cast<std::int64_t>(leading << shift);
  }
  static constexpr std::int64_t greatest_in(std::size_t i) {
    return i + 1 < kBuckets ? least_in(i + 1) - 1 : kLongest_ns;
  }

  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t count_ = 0;
  std::int64_t min_ns_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t max_ns_ = 0;
  std::int64_t sum_ns_ = 0;
};

static_assert(std::is_trivially_copyable_v<DurationHistogram>);

}  // namespace vergence::rt
