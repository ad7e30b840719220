#include "tools/accuracy/reliability.hpp"

#include <algorithm>
#include <cmath>

namespace vergence::accuracy {

Reliability reliability(const std::vector<Observation>& seen,
                        const std::function<bool(const Observation&)>& is_right) {
  Reliability result;
  for (const Observation& o : seen) {
    const double confidence = std::clamp(o.result.estimate.confidence, 0.0, 1.0);
    const auto index = std::min(kReliabilityBins - 1,
                                static_cast<std::size_t>(confidence * static_cast<double>(kReliabilityBins)));
    const double right = is_right(o) ? 1 : 0;
    ReliabilityBin& bin = result.bin[index];
    ++bin.frames;
    bin.mean_confidence += confidence;
    bin.right += right;
    ++result.frames;
    result.squared_error += (confidence - right) * (confidence - right);
  }
  if (result.frames == 0) return result;
  const auto all = static_cast<double>(result.frames);
  result.squared_error /= all;
  for (ReliabilityBin& bin : result.bin) {
    if (bin.frames == 0) continue;
    const auto count = static_cast<double>(bin.frames);
    bin.mean_confidence /= count;
    bin.right /= count;
    result.expected_error += count / all * std::abs(bin.right - bin.mean_confidence);
  }
  return result;
}

}  // namespace vergence::accuracy
