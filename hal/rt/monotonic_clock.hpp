// The clock of the real controller: CLOCK_MONOTONIC, which never steps and which deadlines are slept for on.
#pragma once

#include <cstdint>
#include <ctime>

#include "hal/clock.hpp"

namespace vergence::rt {

struct MonotonicClock {
  std::int64_t now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);  // cannot fail for this clock
    return std::int64_t{now.tv_sec} * kNsPerSecond + now.tv_nsec;
  }
};

static_assert(Clock<MonotonicClock>);

}  // namespace vergence::rt
