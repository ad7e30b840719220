#include "tools/accuracy/page.hpp"

#include <algorithm>
#include <fstream>
#include <ostream>

#include "tools/accuracy/text.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::accuracy {
namespace {

const char* met_text(const std::optional<bool>& met) {
  return !met ? "-" : *met ? "yes" : "**no**";
}

void write_errors(std::ostream& out, const ErrorReport& report) {
  out << "### " << report.claim.what << "\n\nTarget: " << report.claim.target
      << ".\n\n| data set | frames | tracked, % | RMS x y z, mm | RMS e | largest, mm | met |\n"
         "|---|---|---|---|---|---|---|\n";
  const auto row_text = [&](const ErrorRow& row, const char* met) {
    out << "| " << row.name << " | " << row.frames << " | "
        << format("%.1f", row.seen == 0
                              ? 0.0
                              : 100.0 * static_cast<double>(row.tracked) / static_cast<double>(row.seen));
    if (row.frames == 0) {
      out << " | - | - | - | - |\n";
      return;
    }
    out << format(" | %.2f %.2f %.2f | %.4f | %.2f | %s |\n", row.rms_mm[0], row.rms_mm[1], row.rms_mm[2],
                  row.rms_e, row.largest_mm, met);
  };
  for (std::size_t i = 0; i < report.rows.size(); ++i)
    row_text(report.rows[i], report.met[i] ? "yes" : "**no**");
  row_text(report.all, met_text(report.claim.met));
  out << "\n";
}

void write_cold(std::ostream& out, const std::vector<ColdRow>& rows) {
  if (rows.empty()) return;
  out << "## From nothing\n\n"
         "Every look begins without any history; where the target is not found, the tracker is given the "
         "same "
         "pair again, up to three\n"
         "times. Found means tracked, and within 10 mm and 0.15 of the truth [5.5]. The `elsewhere` ones "
         "were "
         "photographed before\n"
         "blue, and are before tan, white, green and tan clutter. The `hard` ones are dim or glaring, with "
         "a\n"
         "bar across; no claim rests on them.\n\n"
         "| data set | looks | in the first frame, % | within 3, % | frames tracked at a wrong pose |\n"
         "|---|---|---|---|---|\n";
  for (const ColdRow& row : rows) {
    const auto looks = static_cast<double>(row.looks);
    out << format("| %s | %zu | %.1f | %.1f | %zu |\n", row.name.c_str(), row.looks,
                  100 * static_cast<double>(row.at_once) / looks, 100 * static_cast<double>(row.soon) / looks,
                  row.false_locks);
  }
  out << "\n";
}

void write_study(std::ostream& out, const std::vector<StudyRow>& rows, const std::string& link) {
  if (rows.empty()) return;
  out << "## Error against generations\n\n"
         "Other random starts over the first frames of a sequence, "
      << rows.front().runs
      << " to a row. *thesis*: votes of hue alone, plain binary genes, no gate of\nsaturation, the flat "
         "model, no "
         "refinement. The others are ours up to a stage: evolved by RM-GA, refined, refined on the\nlearned "
         "relief. "
         "*Found* means within the thesis's own bounds, 10 mm and 0.15 [5.5]; errors are over all frames "
         "from the\n"
         "first found on. Where a row has large errors, what was found was lost again.\n\n"
         "![error against generations]("
      << link
      << "accuracy.png)\n\n| data set | way | generations | found | in frame | RMS x y z, mm | RMS e | 95 % "
         "below, "
         "mm | frames within, % |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const StudyRow& row : rows) {
    out << "| " << row.dataset << " | " << row.way.name() << " | " << row.generations << " | "
        << format("%d of %d | ", row.found, row.runs);
    if (row.found == 0) {
      out << "- | - | - | - | - |\n";
    } else {
      out << format("%.0f | %.2f %.2f %.2f | %.4f | %.2f | %.1f |\n", row.frames_to_find, row.rms_mm[0],
                    row.rms_mm[1], row.rms_mm[2], row.rms_e, row.p95_mm, 100 * row.frames_found);
    }
  }
  out << "\n";
}

void write_reliability(std::ostream& out, const SuiteResult& result, const std::string& link) {
  if (result.right.frames == 0) return;
  out << "## Confidence\n\n"
      << result.right.frames
      << format(
             " frames of all the cases above, and of views that are dim and covered in part. A pose is "
             "*right* "
             "within %g mm and\n%g, *precise* within %g mm and %g; where the target is not there, none "
             "is.\n\n",
             kRight_mm, kRight_e, kPrecise_mm, kPrecise_e)
      << format(
             "Expected calibration error: %.3f for right, %.3f for precise; mean squared error %.3f and "
             "%.3f.\n\n",
             result.right.expected_error, result.precise.expected_error, result.right.squared_error,
             result.precise.squared_error)
      << "![share of right poses over stated confidence](" << link
      << "reliability.png)\n\n| confidence | frames | mean | right, % | precise, % "
         "|\n|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < kReliabilityBins; ++i) {
    const ReliabilityBin& bin = result.right.bin[i];
    out << format("| %.1f to %.1f | %zu | ", static_cast<double>(i) / kReliabilityBins,
                  static_cast<double>(i + 1) / kReliabilityBins, bin.frames);
    if (bin.frames == 0) {
      out << "- | - | - |\n";
    } else {
      out << format("%.3f | %.1f | %.1f |\n", bin.mean_confidence, 100 * bin.right,
                    100 * result.precise.bin[i].right);
    }
  }
  out << "\n";
}

void write_consistency(std::ostream& out, const std::vector<ConsistencyRow>& rows) {
  out << "## Covariance\n\nMean of squared error over stated variance, by axis: 1 where covariance is what "
         "it says, "
         "more where it says too little.\nLast, the share of all errors within two standard deviations (95.4 "
         "% if "
         "normal). Frames that are tracked, right, and state\na covariance.\n\n";
  if (rows.empty()) {
    out << "No frame states a covariance yet.\n\n";
    return;
  }
  out << "| data set | frames | x | y | z | e1 | e2 | e3 | within two, % "
         "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const ConsistencyRow& row : rows) {
    out << "| " << row.name << " | " << row.consistency.frames << " |";
    for (const double ratio : row.consistency.ratio) out << format(" %.2f |", ratio);
    out << format(" %.1f |\n", 100 * row.consistency.share_within_two());
  }
  out << "\n";
}

}  // namespace

void print_claims(std::ostream& out, const std::vector<Claim>& claims) {
  out << "| claim | target | measured | met |\n|---|---|---|---|\n";
  for (const Claim& claim : claims) {
    out << "| " << claim.what << " | " << claim.target << " | " << claim.measured << " | "
        << met_text(claim.met) << " |\n";
  }
}

void write_page(const std::filesystem::path& page, const SuiteResult& result, const SuiteOptions& options,
                const std::string& link) {
  std::ofstream out(page);
  out << "# Accuracy\n\n"
         "Generated by `tools/accuracy.sh`"
      << (options.size.quick ? " with `--quick`" : "")
      << "; nothing here is written by hand. The scenes are rendered with exact "
         "truth\n([render.md](render.md)); "
         "`tools/accuracy/cases.cpp` lists them. A claim about errors is met where every one of its data "
         "sets, and\n"
         "all of their frames together, are within the bounds. What is not met stands here as it was "
         "measured.\n\n";
  print_claims(out, result.claims);
  out << "\nTimes are of one core, the quickest of three passes over the same frames; processor time "
         "is\nless where other programs want the core too.\n\n";
  if (!result.errors.empty()) out << "## Errors, data set by data set\n\n";
  for (const ErrorReport& report : result.errors) write_errors(out, report);
  write_cold(out, result.cold);
  write_reliability(out, result, link);
  write_consistency(out, result.consistency);
  write_study(out, result.study, link);
  if (!out.flush()) throw tools::InputError(page, "-o", "cannot be written");
}

}  // namespace vergence::accuracy
