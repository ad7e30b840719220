// Motion feed-forward [3.6.4]: where the target will be in the hand frame, from the known motion of the hand
// and the estimated velocity of the target in the world.
#pragma once

#include "algo/pose.hpp"

namespace vergence {

class MotionPredictor {
 public:
  void forget();

  // A pose was found at time t with the hand at T_W_H. Velocities follow, smoothed over a few frames.
  void observe(double t_s, const Transform& T_W_H, const Transform& T_H_M);

  // Pose of the target in the hand frame at time t, with the hand at T_W_H. Identity motion where nothing is
  // known yet. `known()` says whether anything was observed.
  [[nodiscard]] Transform predict(double t_s, const Transform& T_W_H) const;
  [[nodiscard]] bool known() const { return observations_ > 0; }

 private:
  int observations_ = 0;
  double t_s_ = 0;
  Transform T_W_M_;
  Vector3 velocity_mm_per_s_ = Vector3::Zero();  // in the world
  Vector3 spin_per_s_ = Vector3::Zero();         // quaternion vector part of the turn a second, in the world
};

}  // namespace vergence
