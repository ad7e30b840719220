#include "algo/photo_likeness.hpp"

#include <array>
#include <cmath>

namespace vergence {
namespace {

constexpr unsigned kChannels = 3;
constexpr unsigned kQuarters = 4;
constexpr double kNoiseVariance = 10;  // of luma on a bare wall, a point; both chromas together as much again
constexpr double kFewestPoints = 8;    // of a quarter that has a say

struct ChannelSums {
  double a = 0;
  double b = 0;
  double aa = 0;
  double bb = 0;
  double ab = 0;
};

struct Sums {
  double points = 0;
  std::array<ChannelSums, kChannels> channel{};

  void add(const Sums& other) {
    points += other.points;
    for (unsigned c = 0; c < kChannels; ++c) {
      ChannelSums& mine = channel[c];
      const ChannelSums& its = other.channel[c];
      mine.a += its.a;
      mine.b += its.b;
      mine.aa += its.aa;
      mine.bb += its.bb;
      mine.ab += its.ab;
    }
  }

  // Of the first channels.
  [[nodiscard]] double correlation(unsigned channels, double noise_variance) const {
    if (points < kFewestPoints) return 0;
    double aa = noise_variance;
    double bb = noise_variance;
    double ab = 0;
    for (unsigned c = 0; c < channels; ++c) {
      const ChannelSums& s = channel[c];
      aa += (s.aa - s.a * s.a / points) / points;
      bb += (s.bb - s.b * s.b / points) / points;
      ab += (s.ab - s.a * s.b / points) / points;
    }
    return ab / std::sqrt(aa * bb);
  }
};

}  // namespace

PhotoLikeness photo_likeness(const PhotoModel& model, int points, const RefineSamples& samples,
                             const float* photo) {
  std::array<Sums, kQuarters> quarter{};
  for (unsigned i = 0; i < static_cast<unsigned>(points); ++i) {
    if (!(samples.weight[i] > 0)) continue;
    Sums& sums = quarter[(model.x_mm[i] > 0 ? 1U : 0U) + (model.y_mm[i] > 0 ? 2U : 0U)];
    sums.points += 1;
    for (unsigned c = 0; c < kChannels; ++c) {
      const auto a = static_cast<double>(samples.value[4 * i + c]);
      const auto b = static_cast<double>(photo[4 * i + c]);
      ChannelSums& s = sums.channel[c];
      s.a += a;
      s.b += b;
      s.aa += a * a;
      s.bb += b * b;
      s.ab += a * b;
    }
  }
  PhotoLikeness result{0, 1};
  Sums all;
  for (const Sums& sums : quarter) {
    all.add(sums);
    const double likeness = sums.correlation(kChannels, 2 * kNoiseVariance);
    if (likeness < result.worst_quarter) result.worst_quarter = likeness;
  }
  result.luma = all.correlation(1, kNoiseVariance);
  return result;
}

}  // namespace vergence
