// Small worlds for the benchmarks: a marker and a card seen head-on by two cameras, and images without them.
#pragma once

#include "algo/target_model.hpp"
#include "tools/io/dataset.hpp"

namespace vergence::tools {

enum class BenchContent {
  kPresent,
  kAbsent,
  kNoise,
  kBlack,
  kSaturated
};
inline constexpr BenchContent kBenchContents[] = {BenchContent::kPresent, BenchContent::kAbsent,
                                                  BenchContent::kNoise, BenchContent::kBlack,
                                                  BenchContent::kSaturated};

[[nodiscard]] const char* to_string(BenchContent content);

struct BenchScene {
  Dataset dataset;  // rig, target and search box of the thesis; no files
  Pose truth;       // T_H_M of the target where it is present
  RgbImage left;
  RgbImage right;
};

[[nodiscard]] BenchScene make_bench_scene(TargetKind kind, BenchContent content);

}  // namespace vergence::tools
