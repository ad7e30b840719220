#include "hal/v4l2/stereo_pairing.hpp"

#include <algorithm>

namespace vergence::v4l2 {

void StereoPairing::configure(std::int64_t max_skew_ns) {
  *this = {};
  max_skew_ns_ = max_skew_ns;
}

void StereoPairing::set_depth(int depth) {
  depth_ = std::clamp(depth, 1, kPairingDepth);
}

void StereoPairing::add(int side_number, TimedFrame frame, DroppedFrames& dropped) {
  const auto s = static_cast<std::size_t>(side_number);
  Side& side = sides_[s];
  ++counts_.added[s];
  if (frame.stamp_ns <= side.last_stamp_ns) {
    ++counts_.backwards[s];
    dropped.ids[s][static_cast<std::size_t>(dropped.count[s]++)] = frame.id;
    return;
  }
  side.last_stamp_ns = frame.stamp_ns;
  if (side.count >= depth_) drop_oldest(s, side.count - depth_ + 1, counts_.unpaired, dropped);
  side.frames[static_cast<std::size_t>(side.count++)] = frame;
}

bool StereoPairing::newest(TimedFrame& left, TimedFrame& right, DroppedFrames& dropped) {
  int found_l = -1;
  int found_r = -1;
  std::int64_t best_older_ns = 0;
  std::int64_t best_skew_ns = 0;
  for (int l = 0; l < sides_[0].count; ++l) {
    for (int r = 0; r < sides_[1].count; ++r) {
      const std::int64_t stamp_l = sides_[0].frames[static_cast<std::size_t>(l)].stamp_ns;
      const std::int64_t stamp_r = sides_[1].frames[static_cast<std::size_t>(r)].stamp_ns;
      const std::int64_t older_ns = std::min(stamp_l, stamp_r);
      const std::int64_t skew_ns = std::max(stamp_l, stamp_r) - older_ns;
      if (skew_ns > max_skew_ns_) continue;
      const bool is_better =
          found_l < 0 || older_ns > best_older_ns || (older_ns == best_older_ns && skew_ns < best_skew_ns);
      if (!is_better) continue;
      found_l = l;
      found_r = r;
      best_older_ns = older_ns;
      best_skew_ns = skew_ns;
    }
  }
  if (found_l < 0) {
    drop_hopeless(dropped);
    return false;
  }
  left = sides_[0].frames[static_cast<std::size_t>(found_l)];
  right = sides_[1].frames[static_cast<std::size_t>(found_r)];
  drop_oldest(0, found_l, counts_.superseded, dropped);
  drop_oldest(1, found_r, counts_.superseded, dropped);
  for (Side& side : sides_) {
    std::rotate(side.frames.begin(), side.frames.begin() + 1, side.frames.end());
    --side.count;
  }
  ++counts_.pairs;
  drop_hopeless(dropped);
  return true;
}

void StereoPairing::clear(int side, DroppedFrames& dropped) {
  const auto s = static_cast<std::size_t>(side);
  drop_oldest(s, sides_[s].count, counts_.unpaired, dropped);
}

void StereoPairing::drop_oldest(std::size_t s, int n, std::array<std::uint64_t, 2>& counter,
                                DroppedFrames& dropped) {
  Side& side = sides_[s];
  for (int i = 0; i < n; ++i)
    dropped.ids[s][static_cast<std::size_t>(dropped.count[s]++)] =
        side.frames[static_cast<std::size_t>(i)].id;
  std::rotate(side.frames.begin(), side.frames.begin() + n, side.frames.end());
  side.count -= n;
  counter[s] += static_cast<std::uint64_t>(n);
}

// What the other side has passed by more than the skew: its stamps only rise, so no partner comes.
void StereoPairing::drop_hopeless(DroppedFrames& dropped) {
  for (std::size_t s = 0; s < 2; ++s) {
    const std::int64_t other_ns = sides_[1 - s].last_stamp_ns;
    int n = 0;
    while (n < sides_[s].count &&
           sides_[s].frames[static_cast<std::size_t>(n)].stamp_ns < other_ns - max_skew_ns_)
      ++n;
    drop_oldest(s, n, counts_.unpaired, dropped);
  }
}

}  // namespace vergence::v4l2
