#include "tools/rig/fault_judge.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "tools/demo/measures.hpp"

namespace vergence::rig {
namespace {

using demo::at_least;
using demo::at_most;

constexpr double kStill_mm_per_s = 1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void add_rest(std::vector<tools::Metric>& metrics, const std::string& name, double searching, double again_ms,
              double again_within_ms) {
  metrics.push_back(at_least(name + "_searching", searching, "", 1, std::nullopt,
                             "share of that time in which the controller said that it searches, and believed "
                             "in no target"));
  metrics.push_back(at_most(name + "_again_ms", again_ms, "ms", again_within_ms, std::nullopt,
                            "from its end until the tool moved again"));
}

}  // namespace

FaultJudge::FaultJudge(const RigScenario& scenario)
    : faults_(scenario.faults),
      operators_(scenario.operators),
      duration_s_(scenario.duration_s),
      settle_s_(scenario.settle_s),
      verdicts_(scenario.faults.size()) {}

// A stop is latched until the operator's next word; the next fault is judged by itself.
double FaultJudge::end_of(const FaultEvent& fault) const {
  double end_s = duration_s_;
  for (const OperatorEvent& event : operators_) {
    if (event.at_s > fault.at_s) end_s = std::min(end_s, event.at_s);
  }
  for (const FaultEvent& other : faults_) {
    if (other.at_s > fault.at_s) end_s = std::min(end_s, other.at_s);
  }
  return end_s;
}

void FaultJudge::watch_rest(const FaultEvent& fault, Verdict& verdict, const FaultMoment& now) {
  const double since_s = now.t_s - fault.at_s;
  if (since_s >= fault.within_s && since_s < fault.for_s) {
    ++verdict.rest_moments;
    // Without pictures the last look remains what it was.
    const bool sees_it = fault.kind == FaultKind::kTargetAbsent && now.tracks;
    if (now.searches && !sees_it) ++verdict.searching_moments;
  }
  if (since_s >= fault.for_s && verdict.again_s < 0 && now.tool_mm_per_s >= kStill_mm_per_s) {
    verdict.again_s = since_s - fault.for_s;
  }
}

void FaultJudge::watch(const FaultMoment& now) {
  for (std::size_t k = 0; k < verdicts_.size(); ++k) {
    const FaultEvent& fault = faults_[k];
    Verdict& verdict = verdicts_[k];
    if (now.t_s < fault.at_s) {
      verdict.was_on = now.drives_on;
      verdict.moving_mm_per_s = now.tool_mm_per_s;
    }
    if (now.t_s < fault.at_s || now.t_s >= end_of(fault)) continue;
    const double since_s = now.t_s - fault.at_s;
    if (!now.drives_on) verdict.was_off = true;
    if (fault.expect == Expectation::kRest) {
      watch_rest(fault, verdict, now);
      if (since_s >= fault.for_s) continue;
    }
    const bool is_still = now.tool_mm_per_s < kStill_mm_per_s;
    if (since_s <= fault.within_s || verdict.still_since_s < 0) {
      if (!is_still) verdict.still_since_s = -1;
      if (is_still && verdict.still_since_s < 0) verdict.still_since_s = since_s;
    }
    if (since_s > fault.within_s)
      verdict.fastest_mm_per_s = std::max(verdict.fastest_mm_per_s, now.tool_mm_per_s);
  }
}

void FaultJudge::add_stillness(std::vector<tools::Metric>& metrics, const std::string& name,
                               const FaultEvent& fault, const Verdict& verdict) const {
  // A hand that rests proves nothing.
  std::optional<double> moving;
  if (fault.at_s >= settle_s_ || fault.expect == Expectation::kRest) moving = kStill_mm_per_s;
  metrics.push_back(at_least(name + "_from_mm_per_s", verdict.moving_mm_per_s, "mm/s", moving, std::nullopt,
                             "how fast the tool was when the fault came"));
  const double still_ms = verdict.still_since_s < 0 ? kNaN : verdict.still_since_s * 1e3;
  metrics.push_back(at_most(name + "_still_ms", still_ms, "ms", fault.within_s * 1e3, std::nullopt,
                            "from the fault until the tool was slower than 1 mm/s"));
  metrics.push_back(
      at_most(name + "_then_mm_per_s", verdict.fastest_mm_per_s, "mm/s", kStill_mm_per_s, std::nullopt,
              fault.expect == Expectation::kRest ? "fastest after that, until it was over"
                                                 : "fastest after that, until the operator's next word"));
}

std::vector<tools::Metric> FaultJudge::metrics() const {
  std::vector<tools::Metric> metrics;
  for (std::size_t k = 0; k < verdicts_.size(); ++k) {
    const FaultEvent& fault = faults_[k];
    const Verdict& verdict = verdicts_[k];
    const std::string name = std::to_string(k + 1) + "_" + fault.name;
    const bool rests = fault.expect == Expectation::kRest;
    if (rests || fault.expect == Expectation::kStop) add_stillness(metrics, name, fault, verdict);
    if (rests) {
      add_rest(metrics, name,
               verdict.rest_moments > 0
                   ? static_cast<double>(verdict.searching_moments) / verdict.rest_moments
                   : kNaN,
               verdict.again_s < 0 ? kNaN : verdict.again_s * 1e3, fault.again_within_s * 1e3);
    }
    if (fault.expect == Expectation::kStop) {
      metrics.push_back(at_least(name + "_drives_off", verdict.was_off ? 1 : 0, "", 1, std::nullopt,
                                 "whether the drives went out of operation"));
    }
    if (rests || fault.expect == Expectation::kCarryOn) {
      metrics.push_back(at_most(name + "_stops", verdict.was_on && !verdict.was_off ? 0 : 1, "", 0,
                                std::nullopt,
                                "whether the drives went out of operation, which was not called for"));
    }
  }
  return metrics;
}

}  // namespace vergence::rig
