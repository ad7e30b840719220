#include "tools/calibrate/pose_track.hpp"

#include <algorithm>
#include <utility>

#include "algo/rotation_vector.hpp"
#include "tools/calibrate/slopes.hpp"

namespace vergence::calibrate {

PoseTrack::PoseTrack(std::vector<TimedPose> poses) : poses_(std::move(poses)) {}

std::optional<Transform> PoseTrack::at(double t_s) const {
  const auto after = std::upper_bound(poses_.begin(), poses_.end(), t_s,
                                      [](double t, const TimedPose& pose) { return t < pose.t_s; });
  if (after == poses_.begin()) return {};
  if (after == poses_.end()) return t_s == last_s() ? std::optional(poses_.back().T) : std::nullopt;
  const auto before = after - 1;
  const double gap_s = after->t_s - before->t_s;
  if (gap_s > kLongestGap_s) return {};
  // Increments from the pose before; its neighbours give the rates at both ends.
  const auto increment = [&](const Transform& T) {
    Vector6 d;
    d << before->T.R.transpose() * (T.t_mm - before->T.t_mm),
        vector_from_rotation(before->T.R.transpose() * T.R);
    return d;
  };
  const Vector6 end = increment(after->T);
  Vector6 rate_before = end / gap_s;
  Vector6 rate_after = rate_before;
  if (before != poses_.begin() && before->t_s - (before - 1)->t_s <= kLongestGap_s)
    rate_before = (end - increment((before - 1)->T)) / (after->t_s - (before - 1)->t_s);
  if (after + 1 != poses_.end() && (after + 1)->t_s - after->t_s <= kLongestGap_s)
    rate_after = increment((after + 1)->T) / ((after + 1)->t_s - before->t_s);
  const double s = (t_s - before->t_s) / gap_s;
  const Vector6 d = s * s * (3 - 2 * s) * end + s * (1 - s) * (1 - s) * gap_s * rate_before -
                    s * s * (1 - s) * gap_s * rate_after;
  return moved(before->T, d);
}

}  // namespace vergence::calibrate
