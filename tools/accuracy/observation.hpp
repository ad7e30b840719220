// What was observed in one frame of a run, and what counts as right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/run/estimator.hpp"

namespace vergence::accuracy {

// A pose is right within the thesis's 10 mm [5.5] and a third of its 0.15: the target, and not some other
// thing.
inline constexpr double kRight_mm = 10;
inline constexpr double kRight_e = 0.05;
// And precise so near that a gripper would not miss.
inline constexpr double kPrecise_mm = 2;
inline constexpr double kPrecise_e = 0.02;

struct Observation {
  std::size_t case_index = 0;
  std::uint64_t seed = 1;
  int attempt = 0;      // Task::kCold: 0 is the first look
  int tracked_for = 0;  // frames without a break before this one in which it was tracked
  tools::FrameResult result;

  [[nodiscard]] bool tracking() const { return result.estimate.state == TrackState::kTracking; }
  [[nodiscard]] bool within(double mm, double e) const {
    return result.error && result.error->position_mm.norm() <= mm && result.error->e <= e;
  }
  [[nodiscard]] bool right() const { return within(kRight_mm, kRight_e); }
  [[nodiscard]] bool precise() const { return within(kPrecise_mm, kPrecise_e); }
  // Found, and it is.
  [[nodiscard]] bool locked() const { return tracking() && right(); }
};

}  // namespace vergence::accuracy
