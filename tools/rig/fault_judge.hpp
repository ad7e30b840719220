// What each fault of a scenario was to bring about, and whether it did: by how the tool went and what the
// drives were, each millisecond.
#pragma once

#include <vector>

#include "tools/report/metric.hpp"
#include "tools/rig/rig_scenario.hpp"

namespace vergence::rig {

struct FaultMoment {
  double t_s = 0;
  double tool_mm_per_s = 0;
  bool drives_on = false;  // any of them
  bool searches = false;   // the controller says so, and believes in no target
  bool tracks = false;     // its last look at pictures found the target
};

class FaultJudge {
 public:
  explicit FaultJudge(const RigScenario& scenario);

  void watch(const FaultMoment& now);
  [[nodiscard]] std::vector<tools::Metric> metrics() const;

 private:
  struct Verdict {
    double still_since_s = -1;    // after the fault; -1: not yet
    double fastest_mm_per_s = 0;  // from the time on that it had
    double moving_mm_per_s = 0;   // when the fault came
    bool was_on = false;          // when the fault came
    bool was_off = false;         // since
    int rest_moments = 0;         // while it is to rest
    int searching_moments = 0;    // of them, in which the controller searched
    double again_s = -1;          // after the end, until the tool moved; -1: not yet
  };
  [[nodiscard]] double end_of(const FaultEvent& fault) const;
  static void watch_rest(const FaultEvent& fault, Verdict& verdict, const FaultMoment& now);
  void add_stillness(std::vector<tools::Metric>& metrics, const std::string& name, const FaultEvent& fault,
                     const Verdict& verdict) const;

  std::vector<FaultEvent> faults_;
  std::vector<OperatorEvent> operators_;
  double duration_s_;
  double settle_s_;
  std::vector<Verdict> verdicts_;
};

}  // namespace vergence::rig
