#include "firmware_like/target_belief.hpp"

namespace vergence {

Status TargetBelief::configure(const RobotConfig& config) {
  *this = {};
  believe_ns_ = config.believe_ns;
  least_confidence_ = config.least_confidence;
  return motion_.configure(config.target_motion);
}

void TargetBelief::put(const Sighting& sighting) {
  if (is_waiting_) take(waiting_);  // two within one release offset: the earlier one is due first anyway
  is_waiting_ = false;
  if (sighting.valid_from_ns < now_ns_) {
    ++late_;
    ++late_in_a_row_;
    take(sighting);
    return;
  }
  late_in_a_row_ = 0;
  waiting_ = sighting;
  is_waiting_ = true;
}

void TargetBelief::step(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (is_waiting_ && waiting_.valid_from_ns <= now_ns) {
    is_waiting_ = false;
    take(waiting_);
  }
  if (seen_ && !is_believed(now_ns)) forget();
}

void TargetBelief::lose() {
  is_waiting_ = false;
  if (seen_) forget();
}

// Found again, it may be anywhere and move in any way.
void TargetBelief::forget() {
  seen_ = false;
  motion_.forget();
}

void TargetBelief::take(const Sighting& sighting) {
  const Estimate& estimate = sighting.estimate;
  if (estimate.state != TrackState::kTracking || estimate.confidence < least_confidence_) return;
  if (!motion_.observe(sighting.stamp_ns, sighting.T_W_H * sighting.T_H_M)) return;
  seen_ = true;
  seen_ns_ = sighting.stamp_ns;
}

bool TargetBelief::is_believed(std::int64_t now_ns) const {
  return seen_ && now_ns - seen_ns_ <= believe_ns_;
}

}  // namespace vergence
