// Timing of short work: many repetitions, medians, and rivals measured turn by turn so that a machine whose
// speed drifts does not favour one of them.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace vergence::tools {

[[nodiscard]] inline double now_ns() {
  return static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

[[nodiscard]] inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct PairOfTimes {
  double ours_ns;
  double theirs_ns;
  double ratio;  // ours / theirs, the median over the turns
};

// Medians of `turns` runs of each, taken in turn.
template <class Ours, class Theirs>
[[nodiscard]] PairOfTimes measure_in_turn(int turns, Ours&& ours, Theirs&& theirs) {
  std::vector<double> a;
  std::vector<double> b;
  std::vector<double> ratios;
  for (int i = 0; i < turns + 1; ++i) {
    const double t0 = now_ns();
    ours();
    const double t1 = now_ns();
    theirs();
    const double t2 = now_ns();
    if (i == 0) continue;  // warm-up
    a.push_back(t1 - t0);
    b.push_back(t2 - t1);
    ratios.push_back(a.back() / b.back());
  }
  return {median(a), median(b), median(ratios)};
}

}  // namespace vergence::tools
