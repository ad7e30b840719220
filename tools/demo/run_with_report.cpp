#include "tools/demo/scenario.hpp"
#include "tools/io/writable.hpp"

namespace vergence::demo {

tools::Summary run_with_report(const Scenario& scenario, const RunOptions& options) {
  tools::make_directory(options.out);
  // Found out now, not after minutes.
  for (const char* file : {"report.html", "log.csv", "summary.json"})
    tools::require_writable(options.out / file);
  const Outcome outcome = scenario.run(options);

  tools::Summary summary;
  summary.scenario = scenario.name;
  summary.seed = options.seed;
  summary.signature = outcome.log.signature();
  summary.duration_s = outcome.duration_s;
  summary.metrics = outcome.metrics;
  outcome.log.write_csv(options.out / "log.csv");
  tools::write_summary(options.out / "summary.json", summary);

  tools::ReportPage page;
  page.title = scenario.title;
  page.description = scenario.description;
  page.command = std::string("vergence demo ") + scenario.name + " --seed " + std::to_string(options.seed);
  page.summary = summary;
  page.pictures = outcome.pictures;
  page.notes = outcome.notes;
  tools::write_html_report(options.out / "report.html", page);
  return summary;
}

}  // namespace vergence::demo
