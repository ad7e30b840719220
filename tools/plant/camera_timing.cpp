#include "tools/plant/camera_timing.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "tools/render/random.hpp"

namespace vergence::plant {

CameraTiming::CameraTiming(CameraTimingOptions options) : options_(std::move(options)) {
  const bool is_good = options_.fps >= 0.001 && options_.fps <= 1e6 && options_.first_stamp_ns >= 0 &&
                       options_.exposure_ns >= 0 && options_.latency_ns >= (options_.exposure_ns + 1) / 2 &&
                       options_.lost_share >= 0 && options_.lost_share <= 1;
  if (!is_good) throw std::invalid_argument("CameraTiming: options outside their ranges");
}

PairTiming CameraTiming::pair(std::uint64_t sequence) const {
  PairTiming pair;
  pair.sequence = sequence;
  // From the number, not by adding up periods: a thirtieth of a second is no whole number of nanoseconds.
  pair.stamp_ns = options_.first_stamp_ns + std::llround(static_cast<double>(sequence) * 1e9 / options_.fps);
  pair.exposure_begin_ns = pair.stamp_ns - options_.exposure_ns / 2;
  pair.exposure_end_ns = pair.exposure_begin_ns + options_.exposure_ns;
  pair.delivery_ns = pair.stamp_ns + options_.latency_ns;
  pair.is_lost =
      render::uniform(options_.seed, sequence) < options_.lost_share ||
      std::any_of(options_.lost_spans_ns.begin(), options_.lost_spans_ns.end(),
                  [&](const auto& span) { return pair.stamp_ns >= span[0] && pair.stamp_ns < span[1]; });
  return pair;
}

}  // namespace vergence::plant
