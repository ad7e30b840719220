// Fits photo_confidence() anew and says how it judges: on the scenes it was fitted to, on those of the suite,
// and on data sets of any origin.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "tools/accuracy/confidence_fit.hpp"
#include "tools/accuracy/rendered_sets.hpp"

namespace vergence::accuracy {

// A pose that a search ended with.
struct SearchedPose {
  std::string part;   // "fit", "suite" or "given"
  std::string scene;  // data set
  std::string model;  // data set whose target is looked for
  int frame = 0;
  std::uint64_t seed = 1;
  bool there = false;  // the target
  double error_mm = 0;
  double error_e = 0;
  PhotoFeatures feature{};
  double confidence = 0;  // as the tracker has it now

  // Found within the bounds by which tracking is judged.
  [[nodiscard]] bool right() const;
  // At the target, yet turned by what the photo of a solid may be misled by: neither a model of "right" nor
  // of "wrong", and left out of the fit.
  [[nodiscard]] bool undecided() const;
};

struct StudyPlaces {
  Places places;
  std::vector<std::filesystem::path> given;  // data sets; each is looked for in all of them
};

[[nodiscard]] std::vector<SearchedPose> search_for_confidence(
    const StudyPlaces& where, int threads, const std::function<void(const char*, std::size_t)>& progress);

[[nodiscard]] PhotoFeatures fit_confidence(const std::vector<SearchedPose>& poses);

void write_features(std::ostream& out, const std::vector<SearchedPose>& poses);
void print_confidence_study(std::ostream& out, const std::vector<SearchedPose>& poses,
                            const PhotoFeatures& weights);

}  // namespace vergence::accuracy
