// What was observed in one frame of a run, and what counts as right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/run/estimator.hpp"

namespace vergence::accuracy {

// A target is found within the thesis's own bounds [5.5]: it is that target, and not some other thing.
inline constexpr double kFound_mm = 10;
inline constexpr double kFound_e = 0.15;
// A pose is right within the same distance and a third of that turn.
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
  [[nodiscard]] bool found() const { return within(kFound_mm, kFound_e); }
  [[nodiscard]] bool right() const { return within(kRight_mm, kRight_e); }
  [[nodiscard]] bool precise() const { return within(kPrecise_mm, kPrecise_e); }
  // Said to be found, and it is.
  [[nodiscard]] bool locked() const { return tracking() && found(); }
};

}  // namespace vergence::accuracy
