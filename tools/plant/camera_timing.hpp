// When a pair of pictures is exposed, when it reaches the controller, and whether it does. A pure function
// of the pair's number.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vergence::plant {

struct CameraTimingOptions {
  double fps = 30;
  std::int64_t first_stamp_ns = 0;
  std::int64_t exposure_ns = 0;         // centred on the stamp
  std::int64_t latency_ns = 9'000'000;  // from the stamp to delivery: read-out and transfer
  // Pairs with stamps in [from, to) are lost; of the others, each with this probability.
  std::vector<std::array<std::int64_t, 2>> lost_spans_ns;
  double lost_share = 0;
  std::uint64_t seed = 1;
};

struct PairTiming {
  std::uint64_t sequence = 0;  // counts lost pairs too
  std::int64_t exposure_begin_ns = 0;
  std::int64_t stamp_ns = 0;
  std::int64_t exposure_end_ns = 0;
  std::int64_t delivery_ns = 0;
  bool is_lost = false;
};

class CameraTiming {
 public:
  // Throws std::invalid_argument where a number is outside its range, or pictures would arrive before their
  // exposure ends.
  explicit CameraTiming(CameraTimingOptions options);

  [[nodiscard]] PairTiming pair(std::uint64_t sequence) const;
  [[nodiscard]] const CameraTimingOptions& options() const { return options_; }

 private:
  CameraTimingOptions options_;
};

}  // namespace vergence::plant
