#include "tools/bench/rt_report.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "firmware_like/task_table.hpp"
#include "hal/gpio_step/step_timing.hpp"

namespace vergence::tools {
namespace {

constexpr TaskRow kArm = task(TaskId::kArm);

double us(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

// Whole microseconds, up.
std::int64_t rounded_up_ns(std::int64_t ns) {
  return (ns + 999) / 1000 * 1000;
}

step::StepTiming timing_with(std::int64_t jitter_ns) {
  step::StepTiming timing;
  timing.jitter_ns = jitter_ns;
  return timing;
}

class Page {
 public:
  [[gnu::format(printf, 2, 3)]] void print(const char* format, ...) {
    std::va_list arguments;
    std::va_list again;
    va_start(arguments, format);
    va_copy(again, arguments);
    const int length = std::vsnprintf(nullptr, 0, format, arguments);
    va_end(arguments);
    std::vector<char> line(static_cast<std::size_t>(std::max(length, 0)) + 1);
    (void)std::vsnprintf(line.data(), line.size(), format, again);
    va_end(again);
    text_ += line.data();
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

void print_machine(Page& page, const RtBenchResult& result) {
  page.print("%-22s %-5s %s\n", "machine", "", "found");
  for (const rt::Finding& finding : result.machine.findings) {
    page.print("  %-20s %-5s %s\n", to_string(finding.probe), to_string(finding.verdict),
               finding.detail.data());
    if (*finding.remedy != '\0') page.print("  %-20s       -> %s\n", "", finding.remedy);
  }
}

constexpr std::array kQuantiles = {0.5, 0.99, 0.999, 1.0};

void print_row(Page& page, const char* load, const char* name, const rt::DurationHistogram& latency) {
  page.print("  %-7s %-18s %8llu", load, name, static_cast<unsigned long long>(latency.count()));
  for (const double q : kQuantiles) page.print(" %9.1f", us(latency.quantile_upper_bound_ns(q)));
  page.print("\n");
}

void print_comparison(Page& page, const RtLoad& load, const char* name, const RtComparison& comparison) {
  const rt::DurationHistogram& ours = comparison.ours.latency;
  print_row(page, load.name.c_str(), name, ours);
  if (!comparison.reference) return;
  print_row(page, "", "  cyclictest", *comparison.reference);
  if (!comparison.max_ratio) return;
  page.print("  %-7s %-18s %8s", "", "  ours / theirs", "");
  for (const double q : kQuantiles) {
    page.print(" %9.2f",
               us(ours.quantile_upper_bound_ns(q)) / us(comparison.reference->quantile_upper_bound_ns(q)));
  }
  page.print("   (median of %d slices' greatest: %.2f)\n", load.slices, *comparison.median_slice_ratio);
}

void print_latencies(Page& page, const RtBenchResult& result) {
  page.print("\n%-28s %8s %9s %9s %9s %9s\n", "lateness of wake-ups, us", "number", "median", "99 %",
             "99.9 %", "greatest");
  for (const RtLoad& load : result.loads) {
    print_comparison(page, load, "arm", load.arm);
    print_comparison(page, load, "steps", load.steps);
  }
}

void print_threads(Page& page, const RtBenchResult& result) {
  page.print("\n%-28s %8s %9s %9s %9s   %s\n", "threads", "faults", "lost", "missed", "stack kB", "core");
  for (const RtLoad& load : result.loads) {
    const auto row = [&](const char* name, const TaskMeasurement& ours) {
      page.print("  %-7s %-18s %8lld %9llu %9llu %4.1f of %3.0f  %s\n", load.name.c_str(), name,
                 static_cast<long long>(ours.faults.minor + ours.faults.major),
                 static_cast<unsigned long long>(ours.lost_periods),
                 static_cast<unsigned long long>(ours.misses),
                 static_cast<double>(ours.stack_used_bytes) / 1024,
                 static_cast<double>(ours.stack_bytes) / 1024, describe(ours.placement));
    };
    row("arm", load.arm.ours);
    row("steps", load.steps.ours);
  }
}

// Rows of a quarter of an octave.
void print_execution(Page& page, const RtLoad& load) {
  constexpr std::size_t kMerged = 4;
  constexpr double kBar = 50;
  const rt::DurationHistogram& execution = load.arm.ours.execution;
  page.print("\nthe arm's calculations, %s, us\n", load.name.c_str());
  for (std::size_t i = 0; i + kMerged <= rt::DurationHistogram::kBuckets; i += kMerged) {
    std::uint64_t count = 0;
    for (std::size_t j = i; j < i + kMerged; ++j) count += execution.bucket(j).count;
    if (count == 0) continue;
    const double share = static_cast<double>(count) / static_cast<double>(execution.count());
    const std::string bar(static_cast<std::size_t>(share * kBar + 0.5), '#');
    page.print("  %8.2f to %8.2f %9llu  %s\n", us(execution.bucket(i).least_ns),
               us(execution.bucket(i + kMerged - 1).greatest_ns), static_cast<unsigned long long>(count),
               bar.c_str());
  }
}

void print_verdict(Page& page, const RtBenchResult& result) {
  const double rate_Hz = 1e9 / static_cast<double>(kArm.period_ns);
  const double worst_us = us(worst_arm_latency_ns(result));
  const double deadline_us = us(kArm.deadline_ns);
  page.print("\nverdict: %s for %.0f Hz: worst wake-up %.1f us of %.0f us",
             is_fit(result) ? "fit" : "not fit", rate_Hz, worst_us, deadline_us);
  if (result.scheduling != rt::RtThreadError::kNone) page.print(", without real-time scheduling");
  std::uint64_t lost = 0;
  for (const RtLoad& load : result.loads) lost += load.arm.ours.lost_periods;
  if (lost > 0) page.print(", %llu periods lost", static_cast<unsigned long long>(lost));
  page.print("\n");
  if (result.machine.worst() == rt::Verdict::kFail) {
    page.print("         but the machine promises nothing beyond these seconds: see what failed above\n");
  }

  const std::int64_t jitter_ns = rounded_up_ns(step_jitter_ns(result));
  const step::StepTiming timing = timing_with(jitter_ns);
  page.print("steps:   edges up to %.1f us late, so jitter_ns = %lld, which permits %.1f steps/s\n",
             us(step_jitter_ns(result)), static_cast<long long>(jitter_ns),
             static_cast<double>(step::fastest_rate_millisteps_per_s(timing)) / 1000);
  if (jitter_ns > timing.ramp_ns) {
    page.print("         and is more than the step generator takes, %lld ns: mend the machine first\n",
               static_cast<long long>(timing.ramp_ns));
  }
}

nlohmann::ordered_json to_json(const rt::DurationHistogram& latency) {
  return {{"number", latency.count()},
          {"median_us", us(latency.quantile_upper_bound_ns(0.5))},
          {"p99_us", us(latency.quantile_upper_bound_ns(0.99))},
          {"p999_us", us(latency.quantile_upper_bound_ns(0.999))},
          {"max_us", us(latency.max_ns())}};
}

nlohmann::ordered_json to_json(const RtComparison& comparison) {
  nlohmann::ordered_json json = {{"latency", to_json(comparison.ours.latency)},
                                 {"execution", to_json(comparison.ours.execution)},
                                 {"cyclictest_latency", nullptr},
                                 {"max_ratio_vs_cyclictest", nullptr},
                                 {"median_slice_ratio_vs_cyclictest", nullptr},
                                 {"lost_periods", comparison.ours.lost_periods},
                                 {"missed_deadlines", comparison.ours.misses},
                                 {"page_faults", comparison.ours.faults.minor + comparison.ours.faults.major},
                                 {"stack_used_bytes", comparison.ours.stack_used_bytes}};
  if (comparison.reference) json["cyclictest_latency"] = to_json(*comparison.reference);
  if (comparison.max_ratio) json["max_ratio_vs_cyclictest"] = *comparison.max_ratio;
  if (comparison.median_slice_ratio) {
    json["median_slice_ratio_vs_cyclictest"] = *comparison.median_slice_ratio;
  }
  return json;
}

}  // namespace

std::string rt_report_text(const RtBenchResult& result) {
  Page page;
  print_machine(page, result);
  print_latencies(page, result);
  print_threads(page, result);
  for (const RtLoad& load : result.loads) print_execution(page, load);
  for (std::size_t i = 0; i < result.notes.size(); ++i) {
    page.print("%s%s\n", i == 0 ? "\n" : "", result.notes[i].c_str());
  }
  print_verdict(page, result);
  return page.text();
}

std::string rt_report_json(const RtBenchResult& result) {
  const std::int64_t jitter_ns = rounded_up_ns(step_jitter_ns(result));
  nlohmann::ordered_json json = {
      {"fit", is_fit(result)},
      {"real_time", result.scheduling == rt::RtThreadError::kNone},
      {"worst_arm_wake_up_us", us(worst_arm_latency_ns(result))},
      {"arm_deadline_us", us(kArm.deadline_ns)},
      {"step_jitter_ns", jitter_ns},
      {"step_rate_steps_per_s",
       static_cast<double>(step::fastest_rate_millisteps_per_s(timing_with(jitter_ns))) / 1000},
  };
  for (const RtLoad& load : result.loads) {
    json["loads"][load.name] = {
        {"slices", load.slices}, {"arm", to_json(load.arm)}, {"steps", to_json(load.steps)}};
  }
  for (const rt::Finding& finding : result.machine.findings) {
    json["machine"].push_back({{"probe", to_string(finding.probe)},
                               {"verdict", to_string(finding.verdict)},
                               {"detail", finding.detail.data()},
                               {"remedy", finding.remedy}});
  }
  json["notes"] = result.notes;
  return json.dump(2);
}

}  // namespace vergence::tools
