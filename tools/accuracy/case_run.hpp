// Runs the tracker over the data set of a case.
#pragma once

#include <vector>

#include "tools/accuracy/case.hpp"
#include "tools/accuracy/observation.hpp"
#include "tools/accuracy/rendered_sets.hpp"

namespace vergence::accuracy {

inline constexpr int kAttempts = 3;

// Seeds 1 to `seeds`, each frame's pictures read once. `case_index` goes into the observations. By seed, then
// by frame. Throws InputError.
[[nodiscard]] std::vector<Observation> run_case(const Case& what, std::size_t case_index,
                                                const Places& places, int seeds);

// Data sets of any origin, every frame from nothing, and shown again up to kAttempts times until it is found:
// what `--cold` asks for. A relief learned at one frame serves the next, or, where each is `unlearned`, does
// not. With `stay`, each is shown so many times instead, found or not: a target that stands still.
[[nodiscard]] std::vector<Observation> run_cold(const tools::Dataset& dataset, int seeds, bool unlearned,
                                                int stay);

}  // namespace vergence::accuracy
