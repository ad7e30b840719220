// The pen of section 6.3: hangs from the hand that looks down into a pool, is let go, falls freely, and meets
// what floats there or not.
#pragma once

#include <limits>
#include <optional>

#include "algo/pose.hpp"
#include "tools/render/mesh.hpp"

namespace vergence::demo {

// T_W_S of the hand over the pool at the start: x along y of the world, y along x, z down.
[[nodiscard]] Transform pool_start();

class Pen {
 public:
  explicit Pen(const Transform& T_S_W) : T_S_W_(T_S_W) {}

  // Whether a pen that is let go now comes down near the target's middle: by poses in the world, and the
  // target's velocity seen from the hand [mm/s].
  [[nodiscard]] static bool will_hit(const Transform& T_W_H, const Transform& T_W_M,
                                     const Vector3& drift_mm_per_s);

  // Each millisecond: where hand and target are, of which mesh it is (in its own frame), and whether the pen
  // is let go, if it hangs still.
  void step(double t_s, const Transform& T_W_H, const Transform& T_W_M, const render::Mesh& mesh,
            bool let_go);

  std::optional<double> dropped_s;
  std::optional<double> landed_s;
  double miss_mm = std::numeric_limits<double>::quiet_NaN();  // from the target's middle
  bool hit = false;

 private:
  Transform T_S_W_;
  std::optional<Vector3> last_tip_;
  Vector3 from_ = Vector3::Zero();
  Vector3 velocity_ = Vector3::Zero();
};

}  // namespace vergence::demo
