// When a controller that went bus-off may go back on the bus: not at once, and not for ever. A bus that
// throws its nodes off again and again has a fault that somebody must mend.
#pragma once

#include <cstdint>

namespace vergence::canopen {

class RestartPolicy {
 public:
  static constexpr std::int64_t kDelay_ns = 100'000'000;      // after a bus-off, and between two tries
  static constexpr std::int64_t kWindow_ns = 10'000'000'000;  // this long without bus-off: all is forgotten
  static constexpr int kMostRestarts = 5;                     // within it

  // Once a period; true where a restart is due now.
  [[nodiscard]] bool is_due(std::int64_t now_ns, bool is_off) {
    if (!is_off) {
      off_ = false;
      if (restarts_ > 0 && now_ns - last_ns_ > kWindow_ns) restarts_ = 0;
      return false;
    }
    if (!off_) {
      off_ = true;
      last_ns_ = now_ns;
    }
    if (restarts_ >= kMostRestarts || now_ns - last_ns_ < kDelay_ns) return false;
    ++restarts_;
    last_ns_ = now_ns;
    return true;
  }
  [[nodiscard]] bool has_given_up() const { return off_ && restarts_ >= kMostRestarts; }

 private:
  bool off_ = false;
  std::int64_t last_ns_ = 0;  // the bus-off, or the last try after it
  int restarts_ = 0;
};

}  // namespace vergence::canopen
