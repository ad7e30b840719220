#include "tools/accuracy/timing.hpp"

#include <algorithm>
#include <map>

#include "tools/run/estimator.hpp"

namespace vergence::accuracy {
namespace {

void keep_least(std::map<int, double>& least, int frame, double value) {
  const auto [entry, is_first] = least.emplace(frame, value);
  if (!is_first) entry->second = std::min(entry->second, value);
}

double at_share(const std::map<int, double>& by_frame, double share) {
  std::vector<double> values;
  values.reserve(by_frame.size());
  for (const auto& [frame, value] : by_frame) values.push_back(value);
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

}  // namespace

TimingRow time_frames(const std::filesystem::path& directory, bool cold, int frames, int passes) {
  const tools::Dataset dataset = tools::read_dataset(directory);
  std::map<int, double> quickest_ms;
  std::map<int, double> quickest_cpu_ms;
  for (int pass = 0; pass < passes; ++pass) {
    tools::EstimateOptions options;
    options.cold = cold;
    tools::Estimator estimator(dataset, options);
    int count = 0;
    for (const tools::Frame& frame : dataset.frames) {
      if (count++ == frames) break;
      const bool tracked_before = estimator.tracker().state() == TrackState::kTracking;
      const auto [left, right] = tools::read_frame(dataset, frame);
      const tools::FrameResult result = estimator.run(frame, left, right);
      if (!cold && !tracked_before) continue;
      keep_least(quickest_ms, frame.number, result.compute_ms);
      keep_least(quickest_cpu_ms, frame.number, result.cpu_ms);
    }
  }
  TimingRow row;
  row.name = directory.filename().string();
  row.cold = cold;
  row.frames = quickest_ms.size();
  if (quickest_ms.empty()) return row;
  row.median_ms = at_share(quickest_ms, 0.5);
  row.p95_ms = at_share(quickest_ms, 0.95);
  row.median_cpu_ms = at_share(quickest_cpu_ms, 0.5);
  return row;
}

}  // namespace vergence::accuracy
