#include "tools/report/thinned.hpp"

#include <algorithm>
#include <cmath>

namespace vergence::tools {
namespace {

struct Extremes {
  std::size_t first = kGap;
  std::size_t smallest = 0;
  std::size_t largest = 0;
  std::size_t last = 0;
};

Extremes extremes(std::span<const double> y, std::size_t begin, std::size_t end) {
  Extremes e;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::isfinite(y[i])) continue;
    if (e.first == kGap) e = {i, i, i, i};
    if (y[i] < y[e.smallest]) e.smallest = i;
    if (y[i] > y[e.largest]) e.largest = i;
    e.last = i;
  }
  return e;
}

}  // namespace

std::vector<std::size_t> thinned(std::span<const double> y, std::size_t most) {
  // A stretch of one sample gives that sample.
  const std::size_t stretches = y.size() <= most ? y.size() : most / 4;
  std::vector<std::size_t> broken_before(y.size() + 1, 0);  // how many values before are not finite
  for (std::size_t i = 0; i < y.size(); ++i) broken_before[i + 1] = broken_before[i] + !std::isfinite(y[i]);
  std::vector<std::size_t> kept;
  std::size_t previous = kGap;
  for (std::size_t s = 0; s < stretches; ++s) {
    const Extremes e = extremes(y, s * y.size() / stretches, (s + 1) * y.size() / stretches);
    if (e.first == kGap) continue;
    std::vector<std::size_t> here{e.first, e.smallest, e.largest, e.last};
    std::sort(here.begin(), here.end());
    here.erase(std::unique(here.begin(), here.end()), here.end());
    for (const std::size_t i : here) {
      if (previous != kGap && broken_before[i] != broken_before[previous]) kept.push_back(kGap);
      kept.push_back(i);
      previous = i;
    }
  }
  return kept;
}

}  // namespace vergence::tools
