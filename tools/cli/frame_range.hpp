// Ranges of frame numbers as the command line writes them.
#pragma once

#include <limits>
#include <string>

namespace vergence::tools {

// first <= frame < end.
struct FrameRange {
  int first = 0;
  int end = std::numeric_limits<int>::max();

  [[nodiscard]] bool contains(int frame) const { return frame >= first && frame < end; }
};

// "A:B" (A to B - 1), "A:", ":B", or "A" alone. Throws CLI::ValidationError.
[[nodiscard]] FrameRange parse_frame_range(const std::string& text);

}  // namespace vergence::tools
