#include "tools/accuracy/consistency.hpp"

namespace vergence::accuracy {

Consistency consistency(const std::vector<const Observation*>& seen) {
  Consistency result;
  for (const Observation* o : seen) {
    const Matrix6& covariance = o->result.estimate.covariance;
    // A wrong target is a matter of confidence, not of covariance.
    if (!o->locked() || (covariance.diagonal().array() <= 0).any()) continue;
    ++result.frames;
    const tools::PoseError& error = *o->result.error;
    for (unsigned i = 0; i < 6; ++i) {
      const double e = i < 3 ? error.position_mm[i] : error.e_difference[i - 3];
      const double ratio = e * e / covariance(i, i);
      result.ratio[i] += ratio;
      result.within_two[i] += ratio <= 4 ? 1 : 0;
    }
  }
  if (result.frames == 0) return result;
  for (unsigned i = 0; i < 6; ++i) {
    result.ratio[i] /= static_cast<double>(result.frames);
    result.within_two[i] /= static_cast<double>(result.frames);
  }
  return result;
}

double Consistency::share_within_two() const {
  double sum = 0;
  for (const double share : within_two) sum += share;
  return sum / static_cast<double>(within_two.size());
}

}  // namespace vergence::accuracy
