// All claims of accuracy, measured: renders the data sets, runs them, judges.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/accuracy/claims.hpp"
#include "tools/accuracy/consistency.hpp"
#include "tools/accuracy/generation_study.hpp"
#include "tools/accuracy/reliability.hpp"
#include "tools/accuracy/rendered_sets.hpp"
#include "tools/accuracy/timing.hpp"

namespace vergence::accuracy {

// Parts that can be asked for one by one.
struct SuiteParts {
  bool marker = false;
  bool photo = false;
  bool lock = false;
  bool absent = false;
  bool time = false;
  bool generations = false;
};

struct SuiteOptions {
  Places places;
  SuiteSize size;
  SuiteParts parts;
  int threads = 0;  // 0: all cores
};

struct ConsistencyRow {
  std::string name;
  Consistency consistency;
};

struct SuiteResult {
  std::vector<Claim> claims;
  std::vector<ErrorReport> errors;
  std::vector<ColdRow> cold;
  std::vector<StudyRow> study;
  std::vector<TimingRow> timing;
  std::vector<ConsistencyRow> consistency;
  Reliability right;    // of first looks and followed frames
  Reliability precise;  // the same frames, held to kPrecise_mm and kPrecise_e
};

// `progress(what, done, total)` is called after every piece of work, from one thread at a time. Throws
// InputError.
[[nodiscard]] SuiteResult run_suite(
    const SuiteOptions& options, const std::function<void(const char*, std::size_t, std::size_t)>& progress);

}  // namespace vergence::accuracy
