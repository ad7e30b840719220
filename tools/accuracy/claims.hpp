// From observations to what the page says: claims with what was measured, and the rows behind them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/accuracy/case.hpp"
#include "tools/accuracy/observation.hpp"

namespace vergence::accuracy {

struct Claim {
  std::string what;
  std::string target;
  std::string measured;
  std::optional<bool> met;  // nothing where it could not be measured
};

// Errors of the frames that count.
struct ErrorRow {
  std::string name;
  std::size_t frames = 0;   // that count
  std::size_t tracked = 0;  // of `seen`
  std::size_t seen = 0;     // in which the target is there
  Vector3 rms_mm = Vector3::Zero();
  double rms_e = 0;
  double largest_mm = 0;
};

// Which frames of a run count.
enum class Part {
  kLocked,  // tracked, and in the frame before too
  kEarly,   // of a photo-model: found, tracked for less than a second, cold frames included: its relief is
            // learned
  kRelief,  // tracked for a second or more: the relief is learned
};
inline constexpr int kLearned_frames = 30;

[[nodiscard]] bool counts(const Observation& seen, Part part);
[[nodiscard]] ErrorRow error_row(const std::string& name, const std::vector<const Observation*>& seen,
                                 Part part);

struct ErrorBounds {
  Vector3 rms_mm;
  double rms_e = 1;       // 1: none
  double largest_mm = 0;  // 0: none
};

// One row for each case of `group`, and the claim: every one of them, and all frames together, within the
// bounds.
struct ErrorReport {
  std::vector<ErrorRow> rows;
  ErrorRow all;
  std::vector<bool> met;  // by row
  Claim claim;
};
[[nodiscard]] ErrorReport error_report(const std::string& what, const std::vector<Case>& cases,
                                       const std::vector<Observation>& seen,
                                       const std::vector<std::string>& groups, Part part,
                                       const ErrorBounds& bounds);

// Looks from nothing: share found in the first frame, and within three.
[[nodiscard]] std::vector<Claim> cold_claims(const std::string& what, const std::vector<Case>& cases,
                                             const std::vector<Observation>& seen, const std::string& group);
// The same by data set, all groups.
struct ColdRow {
  std::string name;
  std::size_t looks = 0;
  std::size_t at_once = 0;
  std::size_t soon = 0;         // within three frames
  std::size_t false_locks = 0;  // frames tracked where the target is not
};
[[nodiscard]] std::vector<ColdRow> cold_rows(const std::vector<Case>& cases,
                                             const std::vector<Observation>& seen);
// After each event, found again within three frames.
[[nodiscard]] Claim relock_claim(const std::string& what, const std::vector<Case>& cases,
                                 const std::vector<Observation>& seen, const std::string& group);
// `lost` where it is not there, and never tracked.
[[nodiscard]] std::vector<Claim> absent_claims(const std::string& what, const std::vector<Case>& cases,
                                               const std::vector<Observation>& seen,
                                               const std::string& group);

}  // namespace vergence::accuracy
