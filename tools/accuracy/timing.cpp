#include "tools/accuracy/timing.hpp"

#include <algorithm>
#include <map>

#include "tools/run/estimator.hpp"

namespace vergence::accuracy {

TimingRow time_frames(const std::filesystem::path& directory, bool cold, int frames, int passes) {
  const tools::Dataset dataset = tools::read_dataset(directory);
  std::map<int, double> quickest_ms;
  for (int pass = 0; pass < passes; ++pass) {
    tools::EstimateOptions options;
    options.cold = cold;
    tools::Estimator estimator(dataset, options);
    int count = 0;
    for (const tools::Frame& frame : dataset.frames) {
      if (count++ == frames) break;
      const bool tracked_before = estimator.tracker().state() == TrackState::kTracking;
      const auto [left, right] = tools::read_frame(dataset, frame);
      const double ms = estimator.run(frame, left, right).compute_ms;
      if (!cold && !tracked_before) continue;
      const auto [entry, is_first] = quickest_ms.emplace(frame.number, ms);
      if (!is_first) entry->second = std::min(entry->second, ms);
    }
  }
  TimingRow row;
  row.name = directory.filename().string();
  row.cold = cold;
  row.frames = quickest_ms.size();
  if (quickest_ms.empty()) return row;
  std::vector<double> ms;
  for (const auto& [frame, value] : quickest_ms) ms.push_back(value);
  std::sort(ms.begin(), ms.end());
  row.median_ms = ms[ms.size() / 2];
  row.p95_ms = ms[ms.size() * 95 / 100];
  return row;
}

}  // namespace vergence::accuracy
