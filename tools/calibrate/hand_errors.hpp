// A hand-eye fit that does not trust the hand: each view's hand pose may be wrong, by as much as the views
// themselves show.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "tools/calibrate/hand_eye_fit.hpp"

namespace vergence::calibrate {

// How large the errors are: of the corners, and of the hand poses, variances an axis.
struct HandEyeNoise {
  double corner_px2 = 0;
  double hand_mm2 = 0;
  double hand_rad2 = 0;
};

struct HandEyeSolution {
  HandEyeState state;
  Eigen::MatrixXd covariance;
  HandEyeNoise noise;
};

// From the fit that trusts the hand to the one that gives each view's hand pose an error, of a size that is
// found as well (expectation and maximisation). An arm errs by more pixels than corners do: whoever trusts it
// makes the cameras' orientation pay for its position. Nothing where the views do not determine the
// parameters.
[[nodiscard]] std::optional<HandEyeSolution> allow_hand_errors(const HandEyeFit& fit,
                                                               const HandEyeState& start);

}  // namespace vergence::calibrate
