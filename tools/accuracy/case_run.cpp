#include "tools/accuracy/case_run.hpp"

#include <memory>

namespace vergence::accuracy {
namespace {

// One tracker with its history.
class Run {
 public:
  Run(const tools::Dataset& dataset, const Case& what, std::size_t case_index, std::uint64_t seed)
      : what_(what), case_index_(case_index), seed_(seed), estimator_(dataset, options_of(seed)) {}

  void look(const tools::Frame& frame, const tools::RgbImage& left, const tools::RgbImage& right) {
    if (what_.task == Task::kCold) {
      what_.unlearned ? estimator_.unlearn() : estimator_.forget();
      const int attempts = what_.stay > 0 ? what_.stay : kAttempts;
      for (int attempt = 0; attempt < attempts; ++attempt) {
        // The target stands still; each look draws other random numbers.
        const auto draw = static_cast<std::uint64_t>(frame.number) * static_cast<unsigned>(attempts) +
                          static_cast<unsigned>(attempt);
        note(estimator_.run(frame, left, right, draw, attempt / 30.0), attempt);
        if (what_.stay == 0 && observations_.back().locked()) break;
      }
    } else {
      note(estimator_.run(frame, left, right), 0);
    }
  }

  [[nodiscard]] std::vector<Observation> take() { return std::move(observations_); }

 private:
  static tools::EstimateOptions options_of(std::uint64_t seed) {
    tools::EstimateOptions options;
    options.seed = seed;
    return options;
  }

  void note(tools::FrameResult result, int attempt) {
    Observation seen;
    seen.case_index = case_index_;
    seen.seed = seed_;
    seen.attempt = attempt;
    seen.tracked_for = attempt == 0 && what_.task == Task::kCold ? 0 : tracked_for_;
    seen.result = std::move(result);
    tracked_for_ = seen.tracking() ? seen.tracked_for + 1 : 0;
    observations_.push_back(std::move(seen));
  }

  const Case& what_;
  std::size_t case_index_;
  std::uint64_t seed_;
  tools::Estimator estimator_;
  int tracked_for_ = 0;
  std::vector<Observation> observations_;
};

std::vector<Observation> run_all(const tools::Dataset& dataset, const Case& what, std::size_t case_index,
                                 int seeds) {
  std::vector<std::unique_ptr<Run>> runs;
  for (int seed = 1; seed <= seeds; ++seed) {
    runs.push_back(std::make_unique<Run>(dataset, what, case_index, static_cast<std::uint64_t>(seed)));
  }
  for (const tools::Frame& frame : dataset.frames) {
    if (what.set.frames > 0 && frame.number >= what.set.frames) break;
    const auto [left, right] = tools::read_frame(dataset, frame);
    for (const auto& run : runs) run->look(frame, left, right);
  }
  std::vector<Observation> all;
  for (const auto& run : runs) {
    for (Observation& seen : run->take()) all.push_back(std::move(seen));
  }
  return all;
}

}  // namespace

std::vector<Observation> run_case(const Case& what, std::size_t case_index, const Places& places, int seeds) {
  tools::Dataset dataset = tools::read_dataset(directory_of(places, what.set));
  if (!what.model_of.empty()) {
    const tools::Dataset other = tools::read_dataset(places.work / what.model_of);
    dataset.target = other.target;
    dataset.box = other.box;
  }
  if (what.task == Task::kAbsent) {
    // Whatever is there is not what is looked for. The times stay those of the frames.
    dataset.truth.clear();
  }
  return run_all(dataset, what, case_index, seeds);
}

std::vector<Observation> run_cold(const tools::Dataset& dataset, int seeds, bool unlearned, int stay) {
  Case what;
  what.unlearned = unlearned;
  what.stay = stay;
  what.set.frames = 0;
  what.task = Task::kCold;
  return run_all(dataset, what, 0, seeds);
}

}  // namespace vergence::accuracy
