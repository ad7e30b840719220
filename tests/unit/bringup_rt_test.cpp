// Fitness for real time: the machine's findings are handed on, wake-ups are judged by what the arm's task
// needs.
#include <array>
#include <cstring>

#include "firmware_like/task_table.hpp"
#include "tests/support/findings.hpp"
#include "tools/bringup/rt_checks.hpp"

namespace vergence::tools {
namespace {

using testing::expect_complete;
using testing::expect_finding;

constexpr const char* kWakeUps = "wake-ups of the arm's task";

rt::MachineReport machine_of(rt::Verdict verdict) {
  rt::MachineReport report;
  for (std::size_t i = 0; i < rt::kProbes; ++i) {
    rt::Finding& finding = report.findings[i];
    finding.probe = static_cast<rt::Probe>(i);
    finding.verdict = verdict;
    std::strcpy(finding.detail.data(), "detail");
    finding.remedy = verdict == rt::Verdict::kPass ? "" : "mend it";
  }
  return report;
}

WakeUps good_wake_ups() {
  return {"", true, 2'000'000, 1'000'000, 2500, 0, 5'000, 20'000, 60'000};
}

TEST(BringupRt, HandsTheMachinesFindingsOn) {
  const std::array verdicts = {rt::Verdict::kPass, rt::Verdict::kWarn, rt::Verdict::kFail};
  const std::array outcomes = {Outcome::kPass, Outcome::kWarn, Outcome::kFail};
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const auto findings = judge(machine_of(verdicts[i]), good_wake_ups());
    ASSERT_EQ(findings.size(), rt::kProbes + 1);
    expect_complete(findings);
    for (std::size_t probe = 0; probe < rt::kProbes; ++probe) {
      EXPECT_EQ(findings[probe].outcome, outcomes[i]);
      EXPECT_EQ(findings[probe].measured, "detail");
    }
  }
}

TEST(BringupRt, JudgesWakeUpsByTheirPeriod) {
  const rt::MachineReport machine = machine_of(rt::Verdict::kPass);
  WakeUps seen = good_wake_ups();
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kPass, "60 at worst: 3.0 % of 2.0 ms");
  seen.largest_ns = 200'001;
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kWarn, "10.0 %", "under load");
  seen.largest_ns = 1'000'000;
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kFail, "50.0 %", "deadlines");
  seen = good_wake_ups();
  seen.lost_periods = 1;
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kFail, "1 lost");
  seen = good_wake_ups();
  seen.is_realtime = false;
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kWarn, "without real time");
  seen = good_wake_ups();
  seen.runs = 0;
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kFail, "never ran");
  seen.problem = "no more threads";
  expect_finding(judge(machine, seen), kWakeUps, Outcome::kFail, "no more threads");
}

TEST(BringupRt, MeasuresOnThisMachine) {
  const RuntimeConfig config;
  const WakeUps seen = measure_wake_ups(config, 1'000'000, 0.05);
  EXPECT_EQ(seen.problem, "");
  EXPECT_EQ(seen.period_ns, 1'000'000);
  EXPECT_EQ(seen.deadline_ns, 500'000);
  EXPECT_GE(seen.runs, 1U);
  EXPECT_LE(seen.median_ns, seen.p99_ns);
  EXPECT_LE(seen.p99_ns, seen.largest_ns);
  EXPECT_EQ(judge_machine(config).findings.size(), rt::kProbes);
}

}  // namespace
}  // namespace vergence::tools
