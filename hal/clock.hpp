// Time as the controller knows it: nanoseconds of one monotonic clock, handed in wherever it is needed and
// never read from a global.
#pragma once

#include <concepts>
#include <cstdint>

namespace vergence {

inline constexpr std::int64_t kNsPerSecond = 1'000'000'000;

[[nodiscard]] constexpr double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

template <typename T>
concept Clock = requires(T& clock) {
  { clock.now_ns() } -> std::same_as<std::int64_t>;
};

}  // namespace vergence
