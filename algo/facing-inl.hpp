// Which points of a posed target an eye sees, as far as the target itself is in the way: four lanes at a time
// on every machine. To be included by files that are compiled for the least processor alone.
#pragma once

#include <cmath>
#include <cstddef>

#include "algo/colour_sampling-inl.hpp"
#include "algo/target_model.hpp"

HWY_BEFORE_NAMESPACE();
namespace vergence {
namespace {

class Facing {
 public:
  explicit Facing(const Transform& T_C_M) {
    const Vector3 eye_mm = -(T_C_M.R.transpose() * T_C_M.t_mm);
    const double distance_mm = std::sqrt(eye_mm.squaredNorm() + 1e-12);
    for (int k = 0; k < 3; ++k) eye_[k] = set(eye_mm[k] / distance_mm);
    per_mm_ = set(1 / distance_mm);
  }

  // How much of a say four points have: 1 where the surface faces the eye, 0 where it faces away, and between
  // the two where it is seen edge on, because normals are not exact.
  [[nodiscard]] V4 of(const SurfaceNormals& normals, std::size_t i) const {
    constexpr double kFacing = 0.2;  // cosine from which a point has its whole say
    const V4 towards = hn::Add(hn::Add(hn::Mul(eye_[0], hn::LoadU(d4, normals.x.data() + i)),
                                       hn::Mul(eye_[1], hn::LoadU(d4, normals.y.data() + i))),
                               hn::Mul(eye_[2], hn::LoadU(d4, normals.z.data() + i)));
    const V4 cosine = hn::Sub(towards, hn::Mul(per_mm_, hn::LoadU(d4, normals.reach_mm.data() + i)));
    return hn::Min(hn::Max(hn::Mul(cosine, set(1 / kFacing)), hn::Zero(d4)), set(1));
  }

 private:
  V4 eye_[3];  // direction of it, in the target frame
  V4 per_mm_;
};

}  // namespace
}  // namespace vergence
HWY_AFTER_NAMESPACE();
