// When a picture must be shown so that the camera takes it fresh. vivid paces its 60 Hz by the kernel's
// ticks, in gaps of unlike length; but three of them are always a twentieth of a second.
#pragma once

#include <array>
#include <cstdint>

namespace vergence::rig {

class PictureSchedule {
 public:
  // Without captures, pictures come at this interval.
  explicit PictureSchedule(std::int64_t idle_ns) : idle_ns_(idle_ns) {}

  void captured(std::int64_t stamp_ns) {
    if (stamp_ns <= last_[2]) return;
    last_ = {last_[1], last_[2], stamp_ns};
  }

  // True where a picture is due now, which is asked each millisecond.
  [[nodiscard]] bool is_due(std::int64_t now_ns) {
    // Before the next capture, or where none came for a while, after the last picture.
    const std::int64_t expected_ns = last_[0] + kThreePeriods_ns;
    const bool is_known = last_[0] != 0 && expected_ns > last_[2] && expected_ns - last_[2] <= kLongestGap_ns;
    const std::int64_t due_ns = is_known ? expected_ns - kLead_ns : shown_ns_ + idle_ns_;
    const bool is_shown = is_known && shown_ns_ >= due_ns;
    if (!(is_known && !is_shown && now_ns >= due_ns) && now_ns < shown_ns_ + idle_ns_) return false;
    shown_ns_ = now_ns;
    return true;
  }

  static constexpr std::int64_t kLead_ns = 1'000'000;

 private:
  static constexpr std::int64_t kThreePeriods_ns = 50'000'000;
  static constexpr std::int64_t kLongestGap_ns = 25'000'000;

  std::int64_t idle_ns_;
  std::array<std::int64_t, 3> last_{};  // captures, oldest first
  std::int64_t shown_ns_ = 0;
};

}  // namespace vergence::rig
