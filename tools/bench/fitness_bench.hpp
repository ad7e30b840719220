// What an evaluation costs, against the plain evaluator in the same run, and what fits into 24 ms.
#pragma once

namespace vergence::tools {

struct FitnessBenchResult {
  double marker_ns_per_sample = 0;  // 360 samples: both cameras
  double marker_speedup_vs_scalar = 0;
  double photo_ns_per_sample = 0;  // about 1000 points a camera
  double photo_speedup_vs_scalar = 0;
  double correlation_ns_per_sample = 0;
  int generations_in_24ms_marker = 0;  // of votes, thesis's evaluator, all else as by default
  int generations_in_24ms_photo = 0;
};

[[nodiscard]] FitnessBenchResult run_fitness_bench(int turns);

}  // namespace vergence::tools
