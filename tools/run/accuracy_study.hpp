// How far the estimates are from the truth, by method and generations, over many seeds: the numbers of
// docs/accuracy.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/run/estimator.hpp"

namespace vergence::tools {

struct StudyPlan {
  std::vector<int> generations{9, 50, 200, 1000};
  int seeds = 10;
  int frames = 30;  // of each data set, at most
};

// Found means: within the thesis's own bounds, 10 mm and 0.15 [5.5].
inline constexpr double kFound_mm = 10;
inline constexpr double kFound_e = 0.15;

// One data set, method and number of generations, over all seeds.
struct StudyRow {
  std::string dataset;
  Method method = Method::kVergence;
  int generations = 0;
  int runs = 0;
  int found = 0;              // runs that found the target in some frame
  double frames_to_find = 0;  // median of these
  // Of all frames from there on.
  Vector3 rms_mm = Vector3::Zero();
  double rms_e = 0;
  double p95_mm = 0;
  double frames_found = 0;  // share of them within the bounds
};

// Loads every frame once. `progress(done, total)` is called after every run. Throws InputError.
[[nodiscard]] std::vector<StudyRow> run_study(const Dataset& dataset, const StudyPlan& plan,
                                              const std::function<void(int, int)>& progress);

}  // namespace vergence::tools
