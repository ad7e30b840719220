// `vergence accuracy`: every claim of accuracy measured on rendered data sets, as a table and a page; or,
// with
// --cold, how often the poses of given data sets are found from nothing; or, with --fit-confidence, the
// weights of a photo-model's confidence.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tools/accuracy/case_run.hpp"
#include "tools/accuracy/confidence_study.hpp"
#include "tools/accuracy/consistency.hpp"
#include "tools/accuracy/page.hpp"
#include "tools/accuracy/plots.hpp"
#include "tools/accuracy/suite.hpp"
#include "tools/accuracy/text.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/progress.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#include "tools/run/parallel.hpp"

namespace vergence::tools {
namespace {

struct Options {
  accuracy::SuiteOptions suite;
  std::vector<std::string> only;
  std::filesystem::path page;
  std::vector<std::filesystem::path> cold;
  int seeds = 20;
  bool unlearned = false;
  int stay = 0;
  bool fit_confidence = false;
  std::filesystem::path features;
};

accuracy::SuiteParts parts_of(const std::vector<std::string>& names) {
  const auto has = [&](std::initializer_list<const char*> any) {
    return names.empty() || std::any_of(any.begin(), any.end(), [&](const char* name) {
             return std::find(names.begin(), names.end(), name) != names.end();
           });
  };
  accuracy::SuiteParts parts;
  parts.marker = has({"marker", "covariance"});
  parts.photo = has({"photo", "covariance"});
  parts.lock = has({"lock", "confidence"});
  parts.absent = has({"absent", "confidence"});
  parts.time = has({"time"});
  parts.generations = has({"generations"});
  return parts;
}

// A bar that changes its name from one kind of work to the next.
class PhasedProgress {
 public:
  void tell(const char* what, std::size_t total) {
    if (what_ != what) {
      bar_ = std::make_unique<Progress>(what, total);
      what_ = what;
    }
    bar_->step();
  }

 private:
  std::string what_;
  std::unique_ptr<Progress> bar_;
};

void print_extras(const accuracy::SuiteResult& result) {
  if (result.right.frames > 0) {
    std::cout << accuracy::format(
        "\nconfidence: expected calibration error %.3f (right), %.3f (precise) over %zu frames\n",
        result.right.expected_error, result.precise.expected_error, result.right.frames);
  }
  for (const accuracy::ConsistencyRow& row : result.consistency) {
    if (row.name[0] != '*') continue;  // groups only
    std::cout << "covariance: " << row.name;
    for (const double ratio : row.consistency.ratio) std::cout << accuracy::format(" %.2f", ratio);
    std::cout << "\n";
  }
  for (const accuracy::ErrorReport& report : result.errors) {
    for (std::size_t i = 0; i < report.rows.size(); ++i) {
      if (report.met[i]) continue;
      const accuracy::ErrorRow& row = report.rows[i];
      std::cout << accuracy::format(
          "not met: %-28s %4zu frames, tracked %5.1f %%, %.2f %.2f %.2f mm, e %.4f, "
          "largest %.2f mm (%s)\n",
          row.name.c_str(), row.frames,
          100.0 * static_cast<double>(row.tracked) / static_cast<double>(std::max<std::size_t>(1, row.seen)),
          row.rms_mm[0], row.rms_mm[1], row.rms_mm[2], row.rms_e, row.largest_mm, report.claim.what.c_str());
    }
  }
}

void run_suite_command(Options& options) {
  options.suite.parts = parts_of(options.only);
  if (!options.page.empty()) require_writable(options.page);
  make_directory(options.suite.places.work);
  accuracy::SuiteResult result;
  {
    PhasedProgress progress;
    result = accuracy::run_suite(
        options.suite, [&](const char* what, std::size_t, std::size_t total) { progress.tell(what, total); });
  }
  accuracy::print_claims(std::cout, result.claims);
  print_extras(result);
  if (options.page.empty()) return;
  const std::filesystem::path figures = options.page.parent_path() / "images";
  make_directory(figures);
  if (!result.study.empty()) accuracy::write_generation_plot(figures / "accuracy.png", result.study);
  if (result.right.frames > 0) accuracy::write_reliability_plot(figures / "reliability.png", result.right);
  accuracy::write_page(options.page, result, options.suite, "images/");
}

void run_fit_command(const Options& options) {
  if (!options.features.empty()) require_writable(options.features);
  make_directory(options.suite.places.work);
  std::vector<accuracy::SearchedPose> poses;
  {
    PhasedProgress progress;
    poses = accuracy::search_for_confidence(
        {options.suite.places, options.cold}, options.suite.threads,
        [&](const char* what, std::size_t total) { progress.tell(what, total); });
  }
  accuracy::print_confidence_study(std::cout, poses, accuracy::fit_confidence(poses));
  if (options.features.empty()) return;
  std::ofstream out(options.features);
  accuracy::write_features(out, poses);
  if (!out.flush()) throw InputError(options.features, "--features", "cannot be written");
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string name_of(const std::filesystem::path& directory) {
  const std::filesystem::path name = directory.lexically_normal();
  return (name.has_filename() ? name : name.parent_path()).filename().string();
}

// Of targets that stand still: where they are tracked some frames after they were first looked for.
void print_stay(const Options& options, const std::vector<std::vector<accuracy::Observation>>& seen) {
  std::cout << "| data set | looks | frame | right, % | tracked elsewhere, % | within 1.5 mm and 0.01, % | "
               "within 5 mm and 0.03, % |\n|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (const int frame : {1, 3, 10, 30, 100}) {
      if (frame > options.stay) break;
      std::size_t looks = 0;
      std::size_t right = 0;
      std::size_t elsewhere = 0;
      std::size_t flat = 0;
      std::size_t solid = 0;
      for (const accuracy::Observation& o : seen[i]) {
        if (!o.result.error || o.attempt != frame - 1) continue;
        ++looks;
        right += o.locked() ? 1 : 0;
        elsewhere += o.tracking() && !o.locked() ? 1 : 0;
        flat += o.tracking() && o.within(1.5, 0.01) ? 1 : 0;
        solid += o.tracking() && o.within(5, 0.03) ? 1 : 0;
      }
      if (looks == 0) continue;
      const auto share = [&](std::size_t n) {
        return 100 * static_cast<double>(n) / static_cast<double>(looks);
      };
      std::cout << accuracy::format("| %s | %zu | %d | %.1f | %.1f | %.0f | %.0f |\n",
                                    name_of(options.cold[i]).c_str(), looks, frame, share(right),
                                    share(elsewhere), share(flat), share(solid));
    }
  }
}

// Bounds of a flat target, and of a solid, whose truth is that of its mean front plane.
void run_cold_command(const Options& options) {
  std::vector<std::vector<accuracy::Observation>> seen(options.cold.size());
  in_parallel(options.cold.size(), options.suite.threads, [&](std::size_t i) {
    const Dataset dataset = read_dataset(options.cold[i]);
    if (dataset.truth.empty()) {
      throw InputError(dataset.directory / "truth.csv", "", "no frame has a known pose",
                       "accuracy needs the truth");
    }
    seen[i] = accuracy::run_cold(dataset, options.seeds, options.unlearned, options.stay);
  });
  if (options.stay > 0) {
    print_stay(options, seen);
    return;
  }
  std::cout << "| data set | looks | tracked, % | found in the first frame, % | within 3, % | "
               "within 1.5 mm and 0.01, % | within 5 mm and 0.03, % | median mm | median e | median ms | "
               "errors within two stated deviations, % |\n"
               "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < seen.size(); ++i) {
    std::size_t tracked = 0;
    std::size_t found = 0;
    std::size_t found_soon = 0;
    std::size_t flat = 0;
    std::size_t solid = 0;
    std::vector<double> mm;
    std::vector<double> e;
    std::vector<double> ms;
    std::vector<const accuracy::Observation*> first;
    for (const accuracy::Observation& o : seen[i]) {
      if (!o.result.error) continue;
      found_soon += o.locked() ? 1 : 0;
      if (o.attempt > 0) continue;
      found += o.locked() ? 1 : 0;
      tracked += o.tracking() ? 1 : 0;
      flat += o.within(1.5, 0.01) ? 1 : 0;
      solid += o.within(5, 0.03) ? 1 : 0;
      mm.push_back(o.result.error->position_mm.norm());
      e.push_back(o.result.error->e);
      ms.push_back(o.result.compute_ms);
      first.push_back(&o);
    }
    if (mm.empty()) continue;
    const auto share = [&](std::size_t n) {
      return 100 * static_cast<double>(n) / static_cast<double>(mm.size());
    };
    const double within_two = accuracy::consistency(first).share_within_two();
    std::cout << accuracy::format(
        "| %s | %zu | %.0f | %.1f | %.1f | %.0f | %.0f | %.2f | %.4f | %.1f | %.1f |\n",
        name_of(options.cold[i]).c_str(), mm.size(), share(tracked), share(found), share(found_soon),
        share(flat), share(solid), median(mm), median(e), median(ms), 100 * within_two);
  }
}

}  // namespace

void add_accuracy_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("accuracy", "Every claim of accuracy, measured: claim, target, measured, met");
  const auto options = std::make_shared<Options>();
  options->suite.places = {"tools/render/scenes", "out/accuracy"};
  command->add_flag("--quick", options->suite.size.quick, "Fewer data sets and frames: some three minutes");
  command
      ->add_option(
          "--only", options->only,
          "Some of it: marker, photo, lock, absent, time, generations, confidence (lock and absent), "
          "covariance (marker and photo)")
      ->check(CLI::IsMember(
          {"marker", "photo", "lock", "absent", "time", "generations", "confidence", "covariance"}))
      ->delimiter(',')
      ->type_name("PART");
  command->add_option("-o,--output", options->page, "Write the page, Markdown, and its figures into images/")
      ->type_name("FILE.md");
  command->add_option("--work", options->suite.places.work, "Where data sets are rendered, once")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--scenes", options->suite.places.scenes, "Where the scenes are")
      ->type_name("DIR")
      ->capture_default_str();
  command
      ->add_option("--threads", options->suite.threads,
                   "Threads; times are taken on one (default: all cores)")
      ->check(CLI::Range(1, 256));
  CLI::Option* cold =
      command
          ->add_option("--cold", options->cold,
                       "Instead: data sets with truth.csv; how often each frame is found from nothing")
          ->type_name("DIR...");
  command->add_option("--seeds", options->seeds, "With --cold: random starts for each frame")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--unlearned", options->unlearned,
                    "With --cold: what one look learned of the target, its relief, is not kept for the next");
  command
      ->add_option("--stay", options->stay,
                   "With --cold: each picture is shown for so many frames; where the target is tracked after "
                   "1, 3, 10, 30 and 100 of them")
      ->needs(cold)
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  CLI::Option* fit = command->add_flag(
      "--fit-confidence", options->fit_confidence,
      "Instead: the weights of a photo-model's confidence, fitted to scenes of its own, and how it judges "
      "others; with --cold, those as well, each target in each of them");
  command->add_option("--features", options->features, "With --fit-confidence: every pose as a row, CSV")
      ->needs(fit)
      ->type_name("FILE.csv");
  command->footer(
      "Examples:\n"
      "  vergence accuracy --quick\n"
      "  vergence accuracy --quick --only marker,lock\n"
      "  vergence accuracy --cold lab/book lab/box --seeds 20");
  command->callback([options] {
    if (options->fit_confidence) {
      run_fit_command(*options);
    } else if (options->cold.empty()) {
      run_suite_command(*options);
    } else {
      run_cold_command(*options);
    }
  });
}

}  // namespace vergence::tools
