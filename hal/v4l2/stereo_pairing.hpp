// Finds pictures of the same instant by their stamps. Pure: it knows frames as a stamp and a number.
#pragma once

#include <array>
#include <cstdint>

#include "hal/v4l2/video_limits.hpp"

namespace vergence::v4l2 {

struct TimedFrame {
  std::int64_t stamp_ns = 0;
  int id = -1;
};

// Frames that are no longer waited with, by side; whoever passed them in may use their memory again. One call
// fills it; it is emptied before the next.
struct DroppedFrames {
  std::array<std::array<int, kPairingDepth>, 2> ids{};
  std::array<int, 2> count{};
};

struct PairingCounts {
  std::uint64_t pairs = 0;
  // By side. What was added is paired, dropped, refused or waiting.
  std::array<std::uint64_t, 2> added{};
  std::array<std::uint64_t, 2> unpaired{};    // dropped: no frame of the other side within the skew
  std::array<std::uint64_t, 2> superseded{};  // dropped: a newer pair was there at the same time
  std::array<std::uint64_t, 2> backwards{};   // refused: not newer than the one before it
};

class StereoPairing {
 public:
  // Forgets everything. max_skew_ns: 0 to a second.
  void configure(std::int64_t max_skew_ns);
  // Frames of a side that may wait: 1 to kPairingDepth.
  void set_depth(int depth);

  // side 0: left, 1: right. Stamps of a side rise; one that does not is dropped.
  void add(int side, TimedFrame frame, DroppedFrames& dropped);

  // The newest pair (by its older stamp, then by the smaller skew) within the skew. Everything older goes,
  // and what cannot find a partner any more.
  [[nodiscard]] bool newest(TimedFrame& left, TimedFrame& right, DroppedFrames& dropped);

  // Drops what waits of a side; its stamps still have to rise.
  void clear(int side, DroppedFrames& dropped);

  [[nodiscard]] const PairingCounts& counts() const { return counts_; }
  [[nodiscard]] int waiting(int side) const { return sides_[static_cast<std::size_t>(side)].count; }

 private:
  struct Side {
    std::array<TimedFrame, kPairingDepth> frames{};  // oldest first
    int count = 0;
    std::int64_t last_stamp_ns = INT64_MIN / 2;
  };
  void drop_oldest(std::size_t side, int n, std::array<std::uint64_t, 2>& counter, DroppedFrames& dropped);
  void drop_hopeless(DroppedFrames& dropped);

  std::array<Side, 2> sides_{};
  std::int64_t max_skew_ns_ = 0;
  int depth_ = kPairingDepth;
  PairingCounts counts_;
};

}  // namespace vergence::v4l2
