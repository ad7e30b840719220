// How long a frame takes, on one core.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vergence::accuracy {

struct TimingRow {
  std::string name;
  bool cold = false;
  std::size_t frames = 0;
  double median_ms = 0;
  double p95_ms = 0;
  double median_cpu_ms = 0;  // as the processor counts it
};

// The data set is gone through `passes` times; each frame counts with its quickest pass, since the work of a
// frame is the same in all of them and only the machine's other work differs. Where not `cold`, frames count
// that were tracked from the frame before.
[[nodiscard]] TimingRow time_frames(const std::filesystem::path& directory, bool cold, int frames,
                                    int passes);

}  // namespace vergence::accuracy
