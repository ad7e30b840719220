// Long series made short enough to draw, without losing what an eye would see.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vergence::tools {

// Indices to draw, rising; kGap stands between two where the line is broken by a value that is not finite.
inline constexpr std::size_t kGap = static_cast<std::size_t>(-1);

// Of every stretch of samples the first, the smallest, the largest and the last, so that peaks stay and lines
// join where they did; at most `most` indices (4 or more), besides gaps. Series that are short enough stay
// whole.
[[nodiscard]] std::vector<std::size_t> thinned(std::span<const double> y, std::size_t most);

}  // namespace vergence::tools
