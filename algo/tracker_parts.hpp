// What the files of the tracker share among themselves, and nobody else.
#pragma once

#include <cmath>

#include "algo/tracker.hpp"

namespace vergence {

inline constexpr double kFound = 0.5;  // confidence from which a target counts as found
inline constexpr int kTrackGenerations = 60;

// The first passes of a photo-model's refinement.
inline constexpr RefinePass kCoarsePass{2, 200, 8};

// Confidence as the share of the way from what chance reaches to what a sure match reaches.
struct Certainty {
  double chance;
  double sure;
};

[[nodiscard]] inline double share_of(double value, const Certainty& certainty) {
  const double share = (value - certainty.chance) / (certainty.sure - certainty.chance);
  return share > 0 ? (share < 1 ? share : 1) : 0;
}

inline unsigned at(int i) {
  return static_cast<unsigned>(i);
}

// What is found elsewhere has to be fitter by a twentieth than what is followed.
[[nodiscard]] inline bool clearly_fitter(double found, double followed) {
  constexpr double kMargin = 0.05;
  return found > followed + kMargin * (followed > 0 ? followed : -followed);
}

// Far enough apart to be two different guesses rather than one.
[[nodiscard]] inline bool distinct(const Pose& a, const Pose& b) {
  return (a.position_mm - b.position_mm).squaredNorm() > 15.0 * 15.0 ||
         (a.e - b.e).squaredNorm() > 0.15 * 0.15;
}

// Whether a pose lies in a box or not far beside it: fitting may have carried it anywhere.
[[nodiscard]] inline bool about_in(const SearchBox& box, const Pose& pose) {
  constexpr double kMargin = 1.25;  // of the half range
  bool inside = true;
  for (int i = 0; i < kGenes; ++i) {
    const double off = (i < 3 ? pose.position_mm[i] : pose.e[i - 3]) - box.centre[at(i)];
    inside &= std::abs(off) <= kMargin * box.half_range[at(i)];
  }
  return inside;
}

}  // namespace vergence
