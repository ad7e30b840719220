#include "tools/accuracy/confidence_study.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "tools/accuracy/case_run.hpp"
#include "tools/accuracy/text.hpp"
#include "tools/run/parallel.hpp"

namespace vergence::accuracy {
namespace {

constexpr double kUndecided_mm = 15;
constexpr double kUndecided_e = 0.3;
// Four of five searches of the fit are for a target that is not there; in use there are fewer.
constexpr double kRightCounts = 2;
constexpr double kRidge = 0.1;
constexpr int kSeeds = 3;  // of a target that is there
constexpr double kBelieved = 0.5;

std::vector<Case> suite_cases() {
  std::vector<Case> cases = lock_cases({});
  const std::vector<Case> absent = absent_cases({});
  cases.insert(cases.end(), absent.begin(), absent.end());
  std::erase_if(cases, [](const Case& c) { return c.group != kColdPhoto && c.group != kAbsentPhoto; });
  return cases;
}

void keep(const std::vector<Observation>& seen, SearchedPose pose, std::vector<SearchedPose>& poses) {
  for (const Observation& o : seen) {
    if (!o.result.evidence || o.attempt > 0 || o.tracked_for > 0) continue;  // searched for, not followed
    pose.frame = o.result.frame;
    pose.seed = o.seed;
    pose.there = o.result.error.has_value();
    pose.error_mm = pose.there ? o.result.error->position_mm.norm() : 0;
    pose.error_e = pose.there ? o.result.error->e : 0;
    pose.feature = photo_features(*o.result.evidence);
    pose.confidence = o.result.estimate.confidence;
    poses.push_back(pose);
  }
}

std::string name_of(const std::filesystem::path& directory) {
  const std::filesystem::path path = directory.lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

std::vector<SearchedPose> search_given(const std::vector<std::filesystem::path>& given, std::size_t scene,
                                       std::size_t model) {
  tools::Dataset dataset = tools::read_dataset(given[scene]);
  if (scene != model) {
    dataset.target = tools::read_dataset(given[model]).target;
    dataset.truth.clear();
  }
  std::vector<SearchedPose> poses;
  std::vector<Observation> seen = run_cold(dataset, kSeeds, false, 0);
  std::erase_if(seen, [](const Observation& o) { return o.attempt > 0; });
  keep(seen, {"given", name_of(given[scene]), name_of(given[model])}, poses);
  return poses;
}

}  // namespace

bool SearchedPose::right() const {
  return there && error_mm <= kFound_mm && error_e <= kFound_e;
}

bool SearchedPose::undecided() const {
  return there && !right() && error_mm <= kUndecided_mm && error_e <= kUndecided_e;
}

std::vector<SearchedPose> search_for_confidence(
    const StudyPlaces& where, int threads, const std::function<void(const char*, std::size_t)>& progress) {
  std::vector<Case> cases = confidence_cases();
  const std::size_t fitted = cases.size();
  const std::vector<Case> suite = suite_cases();
  cases.insert(cases.end(), suite.begin(), suite.end());
  std::vector<RenderedSet> sets;
  for (const Case& what : cases) sets.push_back(what.set);
  render_missing(where.places, sets, [&] { progress("rendering", sets.size()); });

  const std::size_t pairs = where.given.size() * where.given.size();
  std::vector<std::vector<SearchedPose>> by_piece(cases.size() + pairs);
  std::mutex mutex;
  tools::in_parallel(by_piece.size(), threads, [&](std::size_t i) {
    if (i < cases.size()) {
      const Case& what = cases[i];
      const std::string& model = what.model_of.empty() ? what.set.name : what.model_of;
      keep(run_case(what, i, where.places, what.task == Task::kCold ? kSeeds : 1),
           {i < fitted ? "fit" : "suite", what.set.name, model}, by_piece[i]);
    } else {
      const std::size_t pair = i - cases.size();
      by_piece[i] = search_given(where.given, pair / where.given.size(), pair % where.given.size());
    }
    const std::scoped_lock lock(mutex);
    progress("searching", by_piece.size());
  });
  std::vector<SearchedPose> all;
  for (const auto& some : by_piece) all.insert(all.end(), some.begin(), some.end());
  return all;
}

PhotoFeatures fit_confidence(const std::vector<SearchedPose>& poses) {
  std::vector<JudgedPose> judged;
  for (const SearchedPose& pose : poses) {
    if (pose.part == "fit" && !pose.undecided()) {
      judged.push_back({pose.feature, pose.right(), pose.right() ? kRightCounts : 1});
    }
  }
  return fit_confidence(judged, kRidge);
}

void write_features(std::ostream& out, const std::vector<SearchedPose>& poses) {
  out << "part,scene,model,frame,seed,there,error_mm,error_e,right,undecided,confidence";
  for (const char* name : kPhotoFeatureNames) out << ',' << name;
  out << '\n';
  for (const SearchedPose& pose : poses) {
    out << pose.part << ',' << pose.scene << ',' << pose.model << ',' << pose.frame << ',' << pose.seed << ','
        << pose.there << ',' << pose.error_mm << ',' << pose.error_e << ',' << pose.right() << ','
        << pose.undecided() << ',' << pose.confidence;
    for (const double x : pose.feature) out << ',' << x;
    out << '\n';
  }
}

void print_confidence_study(std::ostream& out, const std::vector<SearchedPose>& poses,
                            const PhotoFeatures& weights) {
  out << "| feature | weight |\n|---|---|\n";
  for (std::size_t i = 0; i < kPhotoFeatures; ++i) {
    out << format("| %s | %.2f |\n", kPhotoFeatureNames[i], weights[i]);
  }
  out << "\nPoses, and how many of them are believed: as the tracker judges now, and with these "
         "weights.\n\n"
         "| scenes | poses | how many | now | fitted |\n|---|---|---|---|---|\n";
  const auto row = [&](const char* part, const char* what, const auto& belongs) {
    std::size_t all = 0;
    std::size_t now = 0;
    std::size_t fitted = 0;
    for (const SearchedPose& pose : poses) {
      if (pose.part != part || !belongs(pose)) continue;
      ++all;
      now += pose.confidence >= kBelieved ? 1 : 0;
      double sum = 0;
      for (std::size_t i = 0; i < kPhotoFeatures; ++i) sum += weights[i] * pose.feature[i];
      fitted += sum >= 0 ? 1 : 0;
    }
    if (all > 0) out << format("| %s | %s | %zu | %zu | %zu |\n", part, what, all, now, fitted);
  };
  for (const char* part : {"fit", "suite", "given"}) {
    row(part, "right", [](const SearchedPose& p) { return p.right(); });
    row(part, "within 2 mm and 0.15", [](const SearchedPose& p) { return p.right() && p.error_mm <= 2; });
    row(part, "undecided", [](const SearchedPose& p) { return p.undecided(); });
    row(part, "wrong", [](const SearchedPose& p) { return p.there && !p.right() && !p.undecided(); });
    row(part, "not there", [](const SearchedPose& p) { return !p.there; });
  }
}

}  // namespace vergence::accuracy
