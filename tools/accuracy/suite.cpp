#include "tools/accuracy/suite.hpp"

#include <algorithm>
#include <mutex>

#include "tools/accuracy/case_run.hpp"
#include "tools/accuracy/text.hpp"
#include "tools/run/parallel.hpp"

namespace vergence::accuracy {
namespace {

using Told = std::function<void(const char*, std::size_t, std::size_t)>;

const ErrorBounds kMarkerBounds{{0.2, 0.2, 0.4}, 0.004, 2};
const ErrorBounds kBarBounds{{0.3, 0.3, 0.7}, 0.004, 0};
const ErrorBounds kReliefBounds{{0.2, 0.2, 0.9}, 0.006, 0};
const ErrorBounds kEarlyBounds{{1, 1, 4}};
constexpr double kColdMost_ms = 24;
constexpr double kTrackMost_ms = 5;
constexpr int kTimedFrames = 40;
constexpr int kTimedPasses = 3;

int seeds_of(const Case& what, SuiteSize size) {
  switch (what.task) {
    case Task::kFollow: return size.quick ? 1 : 2;
    case Task::kRelock: return size.quick ? 2 : 4;
    case Task::kCold: return size.quick ? 1 : 4;  // of 200 looks a per cent is two: too few to tell
    case Task::kAbsent: return 1;
  }
  return 1;
}

std::vector<Case> chosen_cases(const SuiteOptions& options) {
  std::vector<Case> cases;
  const auto add = [&](bool wanted, const std::vector<Case>& more) {
    if (wanted) cases.insert(cases.end(), more.begin(), more.end());
  };
  add(options.parts.marker, marker_cases(options.size));
  add(options.parts.photo, photo_cases(options.size));
  add(options.parts.lock, lock_cases(options.size));
  add(options.parts.absent, absent_cases(options.size));
  return cases;
}

void render_all(const SuiteOptions& options, const std::vector<Case>& cases, const Told& told) {
  std::vector<RenderedSet> sets;
  for (const Case& what : cases) sets.push_back(what.set);
  if (options.parts.absent) {
    for (const Case& what : lock_cases(options.size)) sets.push_back(what.set);  // for their models
  }
  if (options.parts.generations) {
    for (const RenderedSet& set : generation_sets(options.size)) sets.push_back(set);
  }
  if (options.parts.time) {
    for (const TimedSet& timed : timed_sets(options.size)) sets.push_back(timed.set);
  }
  std::size_t done = 0;
  render_missing(options.places, sets, [&] { told("rendering", ++done, sets.size()); });
}

std::vector<Observation> observe(const SuiteOptions& options, const std::vector<Case>& cases,
                                 const Told& told) {
  std::vector<std::vector<Observation>> by_case(cases.size());
  std::mutex mutex;
  std::size_t done = 0;
  tools::in_parallel(cases.size(), options.threads, [&](std::size_t i) {
    by_case[i] = run_case(cases[i], i, options.places, seeds_of(cases[i], options.size));
    const std::scoped_lock lock(mutex);
    told("estimating", ++done, cases.size());
  });
  std::vector<Observation> all;
  for (auto& some : by_case) {
    for (Observation& seen : some) all.push_back(std::move(seen));
  }
  return all;
}

void study(const SuiteOptions& options, const Told& told, SuiteResult& result) {
  StudyPlan plan;
  plan.threads = options.threads;
  plan.seeds = options.size.quick ? 2 : 5;
  plan.frames = options.size.quick ? 15 : 45;
  const auto sets = generation_sets(options.size);
  const std::size_t total = sets.size() * plan.generations.size() * 4;
  std::size_t done = 0;
  for (const RenderedSet& set : sets) {
    const tools::Dataset dataset = tools::read_dataset(directory_of(options.places, set));
    const auto rows = run_study(dataset, plan, [&] { told("generations", ++done, total); });
    result.study.insert(result.study.end(), rows.begin(), rows.end());
  }
}

// Alone on the machine as far as this program goes.
void measure_time(const SuiteOptions& options, const Told& told, SuiteResult& result) {
  const auto sets = timed_sets(options.size);
  std::size_t done = 0;
  for (const TimedSet& timed : sets) {
    const TimingRow row =
        time_frames(directory_of(options.places, timed.set), timed.cold, kTimedFrames, kTimedPasses);
    result.timing.push_back(row);
    Claim claim;
    claim.what = std::string("time of a ") + (timed.cold ? "cold frame, " : "tracked frame, ") + row.name;
    claim.target = timed.cold ? format("%g ms", kColdMost_ms) : format("median %g ms", kTrackMost_ms);
    claim.measured = format("median %.1f ms, 95 %% below %.1f ms; processor time %.1f ms", row.median_ms,
                            row.p95_ms, row.median_cpu_ms);
    if (row.frames > 0) {
      claim.met = timed.cold ? row.p95_ms <= kColdMost_ms : row.median_ms <= kTrackMost_ms;
    }
    result.claims.push_back(claim);
    told("timing", ++done, sets.size());
  }
}

void judge_confidence(const std::vector<Observation>& seen, SuiteResult& result) {
  std::vector<Observation> first;
  for (const Observation& o : seen) {
    if (o.attempt == 0) first.push_back(o);
  }
  result.right = reliability(first, [](const Observation& o) { return o.right(); });
  result.precise = reliability(first, [](const Observation& o) { return o.precise(); });
}

void judge_covariance(const std::vector<Case>& cases, const std::vector<Observation>& seen,
                      SuiteResult& result) {
  std::vector<std::string> groups;
  for (const Case& what : cases) {
    if (std::find(groups.begin(), groups.end(), what.group) == groups.end()) groups.push_back(what.group);
  }
  const auto add = [&](const std::string& name, const auto& belongs) {
    std::vector<const Observation*> some;
    for (const Observation& o : seen) {
      if (belongs(o.case_index)) some.push_back(&o);
    }
    const Consistency c = consistency(some);
    if (c.frames > 0) result.consistency.push_back({name, c});
  };
  for (const std::string& group : groups) {
    add("**" + group + "**", [&](std::size_t i) { return cases[i].group == group; });
    for (std::size_t k = 0; k < cases.size(); ++k) {
      if (cases[k].group == group) add(cases[k].set.name, [&](std::size_t i) { return i == k; });
    }
  }
}

}  // namespace

SuiteResult run_suite(const SuiteOptions& options, const Told& progress) {
  const std::vector<Case> cases = chosen_cases(options);
  render_all(options, cases, progress);
  const std::vector<Observation> seen = observe(options, cases, progress);

  SuiteResult result;
  const auto add_errors = [&](const char* what, const std::vector<std::string>& groups, Part part,
                              const ErrorBounds& bounds) {
    result.errors.push_back(error_report(what, cases, seen, groups, part, bounds));
    result.claims.push_back(result.errors.back().claim);
  };
  const auto add_claims = [&](const std::vector<Claim>& more) {
    result.claims.insert(result.claims.end(), more.begin(), more.end());
  };
  if (options.parts.marker) {
    add_errors("marker, locked", {kMarker}, Part::kLocked, kMarkerBounds);
    add_errors("marker behind a bar, locked", {kMarkerBar}, Part::kLocked, kBarBounds);
  }
  if (options.parts.photo) {
    add_errors("solid, tracked for a second or more", {kPhoto}, Part::kRelief, kReliefBounds);
    add_errors("solid, in its first second", {kPhoto, kColdPhoto}, Part::kEarly, kEarlyBounds);
  }
  if (options.parts.lock) {
    add_claims(cold_claims("marker found from nothing", cases, seen, kColdMarker));
    add_claims(cold_claims("solid found from nothing", cases, seen, kColdPhoto));
    add_claims(cold_claims("solid before another background", cases, seen, kElsewhere));
    add_claims({relock_claim("marker found again within 3 frames", cases, seen, kRelockMarker)});
    add_claims({relock_claim("solid found again within 3 frames", cases, seen, kRelockPhoto)});
  }
  if (options.parts.absent) {
    add_claims(absent_claims("marker not there", cases, seen, kAbsentMarker));
    add_claims(absent_claims("solid not there", cases, seen, kAbsentPhoto));
  }
  result.cold = cold_rows(cases, seen);
  judge_confidence(seen, result);
  judge_covariance(cases, seen, result);
  if (options.parts.time) measure_time(options, progress, result);
  if (options.parts.generations) study(options, progress, result);
  return result;
}

}  // namespace vergence::accuracy
