// When a picture must be shown so that the camera takes it fresh: just before. vivid paces its 60 Hz by the
// kernel's ticks, in gaps of unlike length that repeat; so the next gap is the one that followed when the
// last two were the same.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace vergence::rig {

class PictureSchedule {
 public:
  // While the next capture is not known, pictures come at this interval.
  explicit PictureSchedule(std::int64_t idle_ns) : idle_ns_(idle_ns) {}

  void captured(std::int64_t stamp_ns) {
    const std::int64_t gap_ns = stamp_ns - last_ns_;
    if (gap_ns <= 0) return;
    last_ns_ = stamp_ns;
    for (std::size_t i = 0; i + 1 < kGaps; ++i) gaps_ns_[i] = gaps_ns_[i + 1];
    gaps_ns_[kGaps - 1] = gap_ns;
    const std::int64_t next_ns = next_gap_ns();
    expected_ns_ = next_ns > 0 ? stamp_ns + next_ns : 0;
  }

  // True where a picture is due now, which is asked each millisecond.
  [[nodiscard]] bool is_due(std::int64_t now_ns) {
    const bool is_awaited = expected_ns_ - kLead_ns > shown_ns_ && expected_ns_ > last_ns_;
    const bool is_due = is_awaited && now_ns + kLead_ns >= expected_ns_;
    if (!is_due && now_ns - shown_ns_ < (is_awaited ? 2 * idle_ns_ : idle_ns_)) return false;
    shown_ns_ = now_ns;
    return true;
  }

  // At most. Captures come a few microseconds after a whole millisecond, so that it is 8 ms and those: what
  // stamp_to_mid_exposure_ms of the robots' configurations says.
  static constexpr std::int64_t kLead_ns = 9'000'000;

 private:
  static constexpr std::size_t kGaps = 9;
  static constexpr std::int64_t kSame_ns = 1'000'000;

  [[nodiscard]] bool are_same(std::size_t a, std::size_t b) const {
    return std::abs(gaps_ns_[a] - gaps_ns_[b]) < kSame_ns;
  }
  // 0: not known.
  [[nodiscard]] std::int64_t next_gap_ns() const {
    for (std::size_t i = kGaps - 2; i >= 1; --i) {
      if (are_same(i, kGaps - 1) && are_same(i - 1, kGaps - 2)) return gaps_ns_[i + 1];
    }
    return 0;
  }

  std::int64_t idle_ns_;
  std::array<std::int64_t, kGaps> gaps_ns_{};  // between captures, oldest first
  std::int64_t last_ns_ = 0;                   // capture
  std::int64_t expected_ns_ = 0;               // the next one
  std::int64_t shown_ns_ = 0;
};

}  // namespace vergence::rig
