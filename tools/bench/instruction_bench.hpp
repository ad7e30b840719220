// Does the work of a frame depend on what the cameras see? Counted, not timed: instructions of user code
// under valgrind's callgrind, whole frames, over images of every kind.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/bench_scene.hpp"

namespace vergence::tools {

struct InstructionCount {
  TargetKind kind;
  BenchContent content;
  double instructions;
};

struct InstructionBenchResult {
  std::vector<InstructionCount> counts;
  double spread = 0;  // the larger of both kinds' largest / smallest - 1
};

// Runs `executable bench --frame KIND:CONTENT` under callgrind for every kind and content. Nothing where
// valgrind is not installed or cannot run this program here. Throws std::runtime_error where a run fails.
[[nodiscard]] std::optional<InstructionBenchResult> run_instruction_bench(
    const std::filesystem::path& executable);

// The frame that is counted: KIND is marker or photo, CONTENT as to_string(BenchContent). Throws InputError.
void run_counted_frame(const std::string& kind_and_content);

}  // namespace vergence::tools
