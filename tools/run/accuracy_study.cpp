#include "tools/run/accuracy_study.hpp"

#include <algorithm>
#include <cmath>

#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

struct Pair {
  Frame frame;
  RgbImage left;
  RgbImage right;
};

double at_share(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

StudyRow study_row(const Dataset& dataset, const std::vector<Pair>& frames, Method method, int generations,
                   int seeds) {
  StudyRow row;
  row.dataset = dataset.directory.filename().string();
  row.method = method;
  row.generations = generations;
  row.runs = seeds;
  std::vector<double> first_found;
  std::vector<double> distances;
  Vector3 squares = Vector3::Zero();
  double e_squares = 0;
  int within = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    EstimateOptions options;
    options.method = method;
    options.seed = static_cast<std::uint64_t>(seed);
    options.generations = generations;
    Estimator estimator(dataset, options);
    bool found = false;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const PoseError error = *estimator.run(frames[i].frame, frames[i].left, frames[i].right).error;
      const double distance = error.position_mm.norm();
      const bool good = distance <= kFound_mm && error.e <= kFound_e;
      if (good && !found) first_found.push_back(static_cast<double>(i + 1));
      found = found || good;
      if (!found) continue;
      within += good ? 1 : 0;
      distances.push_back(distance);
      squares += error.position_mm.cwiseAbs2();
      e_squares += error.e * error.e;
    }
  }
  row.found = static_cast<int>(first_found.size());
  row.frames_to_find = at_share(first_found, 0.5);
  if (distances.empty()) return row;
  const auto count = static_cast<double>(distances.size());
  row.rms_mm = (squares / count).cwiseSqrt();
  row.rms_e = std::sqrt(e_squares / count);
  row.p95_mm = at_share(distances, 0.95);
  row.frames_found = within / count;
  return row;
}

}  // namespace

std::vector<StudyRow> run_study(const Dataset& dataset, const StudyPlan& plan,
                                const std::function<void(int, int)>& progress) {
  std::vector<Pair> frames;
  for (const Frame& frame : dataset.frames) {
    if (static_cast<int>(frames.size()) == plan.frames) break;
    if (dataset.truth.count(frame.number) == 0) continue;
    auto [left, right] = read_frame(dataset, frame);
    frames.push_back({frame, std::move(left), std::move(right)});
  }
  if (frames.empty()) {
    throw InputError(dataset.directory / "truth.csv", "", "no frame has a known pose",
                     "accuracy needs the truth");
  }
  std::vector<StudyRow> rows;
  const int total = static_cast<int>(2 * plan.generations.size());
  for (const Method method : {Method::kThesis, Method::kVergence}) {
    for (const int generations : plan.generations) {
      rows.push_back(study_row(dataset, frames, method, generations, plan.seeds));
      progress(static_cast<int>(rows.size()), total);
    }
  }
  return rows;
}

}  // namespace vergence::tools
