#include "tools/accuracy/claims.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/accuracy/text.hpp"

namespace vergence::accuracy {
namespace {

constexpr int kWithin_frames = 3;

double percent(std::size_t part, std::size_t all) {
  return all == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(all);
}

bool within(const ErrorRow& row, const ErrorBounds& bounds) {
  return row.frames > 0 && (row.rms_mm.array() <= bounds.rms_mm.array()).all() && row.rms_e <= bounds.rms_e &&
         (bounds.largest_mm <= 0 || row.largest_mm <= bounds.largest_mm);
}

std::vector<const Observation*> of_case(const std::vector<Observation>& seen, std::size_t index) {
  std::vector<const Observation*> some;
  for (const Observation& o : seen) {
    if (o.case_index == index) some.push_back(&o);
  }
  return some;
}

}  // namespace

bool counts(const Observation& seen, Part part) {
  if (!seen.tracking() || !seen.result.error) return false;
  switch (part) {
    case Part::kLocked: return seen.tracked_for >= 1;
    case Part::kEarly: return seen.found() && seen.tracked_for < kLearned_frames;
    case Part::kRelief: return seen.tracked_for >= kLearned_frames;
  }
  return false;
}

ErrorRow error_row(const std::string& name, const std::vector<const Observation*>& seen, Part part) {
  ErrorRow row;
  row.name = name;
  Vector3 squares = Vector3::Zero();
  double e_squares = 0;
  for (const Observation* o : seen) {
    if (!o->result.error) continue;
    ++row.seen;
    row.tracked += o->tracking() ? 1 : 0;
    if (!counts(*o, part)) continue;
    ++row.frames;
    const tools::PoseError& error = *o->result.error;
    squares += error.position_mm.cwiseAbs2();
    e_squares += error.e * error.e;
    row.largest_mm = std::max(row.largest_mm, error.position_mm.norm());
  }
  if (row.frames == 0) return row;
  row.rms_mm = (squares / static_cast<double>(row.frames)).cwiseSqrt();
  row.rms_e = std::sqrt(e_squares / static_cast<double>(row.frames));
  return row;
}

ErrorReport error_report(const std::string& what, const std::vector<Case>& cases,
                         const std::vector<Observation>& seen, const std::vector<std::string>& groups,
                         Part part, const ErrorBounds& bounds) {
  ErrorReport report;
  std::vector<const Observation*> all;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (std::find(groups.begin(), groups.end(), cases[i].group) == groups.end()) continue;
    const auto some = of_case(seen, i);
    all.insert(all.end(), some.begin(), some.end());
    const ErrorRow row = error_row(cases[i].set.name, some, part);
    report.rows.push_back(row);
    report.met.push_back(within(row, bounds));
  }
  report.all = error_row("all", all, part);
  Claim& claim = report.claim;
  claim.what = what;
  claim.target = format("RMS %g %g %g mm", bounds.rms_mm[0], bounds.rms_mm[1], bounds.rms_mm[2]);
  if (bounds.rms_e < 1) claim.target += format(", e %g", bounds.rms_e);
  if (bounds.largest_mm > 0) claim.target += format(", none off by more than %g mm", bounds.largest_mm);
  if (report.all.frames == 0) {
    claim.measured = "no such frame";
    return report;
  }
  const auto met = std::count(report.met.begin(), report.met.end(), true);
  claim.measured = format("%.2f %.2f %.2f mm, e %.4f, largest %.2f mm; %ld of %zu data sets meet it",
                          report.all.rms_mm[0], report.all.rms_mm[1], report.all.rms_mm[2], report.all.rms_e,
                          report.all.largest_mm, static_cast<long>(met), report.rows.size());
  claim.met = within(report.all, bounds) && met == static_cast<std::ptrdiff_t>(report.rows.size());
  return report;
}

std::vector<Claim> cold_claims(const std::string& what, const std::vector<Case>& cases,
                               const std::vector<Observation>& seen, const std::string& group) {
  std::size_t looks = 0;
  std::size_t at_once = 0;
  std::size_t soon = 0;
  std::size_t false_locks = 0;
  for (const Observation& o : seen) {
    if (cases[o.case_index].group != group) continue;
    looks += o.attempt == 0 ? 1 : 0;
    at_once += o.attempt == 0 && o.locked() ? 1 : 0;
    soon += o.locked() ? 1 : 0;  // the last attempt, where it is
    false_locks += o.tracking() && !o.found() ? 1 : 0;
  }
  if (looks == 0) return {};
  const std::string wrong = format("; %zu frames tracked at a wrong pose", false_locks);
  return {{what + ", in the first frame", "95 %",
           format("%.1f %% of %zu", percent(at_once, looks), looks) + wrong, percent(at_once, looks) >= 95},
          {what + ", within 3 frames", "100 %", format("%.1f %% of %zu", percent(soon, looks), looks),
           soon == looks}};
}

std::vector<ColdRow> cold_rows(const std::vector<Case>& cases, const std::vector<Observation>& seen) {
  std::vector<ColdRow> rows(cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) rows[i].name = cases[i].set.name;
  for (const Observation& o : seen) {
    ColdRow& row = rows[o.case_index];
    if (cases[o.case_index].task != Task::kCold) continue;
    row.looks += o.attempt == 0 ? 1 : 0;
    row.at_once += o.attempt == 0 && o.locked() ? 1 : 0;
    row.soon += o.locked() ? 1 : 0;
    row.false_locks += o.tracking() && !o.found() ? 1 : 0;
  }
  std::erase_if(rows, [](const ColdRow& row) { return row.looks == 0; });
  return rows;
}

Claim relock_claim(const std::string& what, const std::vector<Case>& cases,
                   const std::vector<Observation>& seen, const std::string& group) {
  std::size_t events = 0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (cases[i].group != group) continue;
    std::map<std::uint64_t, std::vector<const Observation*>> runs;
    for (const Observation* o : of_case(seen, i)) runs[o->seed].push_back(o);
    for (const auto& [seed, run] : runs) {
      for (const int event : cases[i].events) {
        const auto again = [&](const Observation* o) {
          return o->result.frame >= event && o->result.frame < event + kWithin_frames && o->locked();
        };
        ++events;
        found += std::any_of(run.begin(), run.end(), again) ? 1 : 0;
      }
    }
  }
  Claim claim{what, "100 %", "not run", {}};
  if (events == 0) return claim;
  claim.measured = format("%.1f %% of %zu", percent(found, events), events);
  claim.met = found == events;
  return claim;
}

std::vector<Claim> absent_claims(const std::string& what, const std::vector<Case>& cases,
                                 const std::vector<Observation>& seen, const std::string& group) {
  std::size_t frames = 0;
  std::size_t lost = 0;
  std::size_t false_locks = 0;
  for (const Observation& o : seen) {
    if (cases[o.case_index].group != group) continue;
    ++frames;
    lost += o.result.estimate.state == TrackState::kLost ? 1 : 0;
    false_locks += o.tracking() ? 1 : 0;
  }
  if (frames == 0) return {};
  return {{what + ": `lost`", "99.5 %", format("%.1f %% of %zu frames", percent(lost, frames), frames),
           percent(lost, frames) >= 99.5},
          {what + ": tracked all the same", "0", format("%zu frames", false_locks), false_locks == 0}};
}

}  // namespace vergence::accuracy
