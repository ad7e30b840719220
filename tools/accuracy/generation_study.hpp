// How far the estimates are from the truth, by method, stage and generations a frame, over many seeds.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/accuracy/observation.hpp"
#include "tools/run/estimator.hpp"

namespace vergence::accuracy {

// A way of estimating: the thesis's, or ours up to a stage.
struct Way {
  Method method = Method::kVergence;
  Stage last_stage = Stage::kRelief;

  [[nodiscard]] std::string name() const;
};

// The thesis's, and ours up to each stage that a kind of target goes through.
[[nodiscard]] std::vector<Way> ways_for(TargetKind kind);

struct StudyPlan {
  std::vector<int> generations{9, 50, 200, 1000};
  int seeds = 5;
  int frames = 45;  // of each data set, at most
  int threads = 0;  // 0: all cores
};

// One data set, way and number of generations, over all seeds.
struct StudyRow {
  std::string dataset;
  Way way;
  int generations = 0;
  int runs = 0;
  int found = 0;              // runs that found (kFound_mm, kFound_e) the target in some frame
  double frames_to_find = 0;  // median of these
  // Of all frames from there on.
  Vector3 rms_mm = Vector3::Zero();
  double rms_e = 0;
  double p95_mm = 0;
  double frames_found = 0;  // share of them within the bounds
};

// Loads every frame once. `progress()` is called after every row, from one thread at a time. By way, then by
// generations. Throws InputError.
[[nodiscard]] std::vector<StudyRow> run_study(const tools::Dataset& dataset, const StudyPlan& plan,
                                              const std::function<void()>& progress);

}  // namespace vergence::accuracy
