// Forward projection of many samples to pixel indices, once per instruction set. To be included after
// Highway, inside a file that is compiled for each target.
//
// Single precision, no fused multiply-add, true division: the same bits on every processor.
#if defined(VERGENCE_ALGO_PROJECTION_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef VERGENCE_ALGO_PROJECTION_INL_HPP
#undef VERGENCE_ALGO_PROJECTION_INL_HPP
#else
#define VERGENCE_ALGO_PROJECTION_INL_HPP
#endif

#include <cstdint>

#include "algo/camera_model.hpp"
#include "algo/limits.hpp"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace vergence::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// The image a pixel index counts in; the index after the last pixel stands for everything beside it.
struct PixelGrid {
  int width_px;
  int height_px;
  [[nodiscard]] std::int32_t outside() const { return width_px * height_px; }
};

// Index of the pixel nearest to (u, v); the grid's outside index where there is none or `visible` is false.
//
// Adding and subtracting 1.5 * 2^23 rounds a float to a whole number (ties to even), and leaves it in the low
// bits of its representation: an index without any conversion instruction, exact up to 2^22 pixels.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> pixel_index(D d, V u, V v, hn::Mask<D> visible, PixelGrid grid) {
  const hn::RebindToSigned<D> di;
  static_assert(kMaxImagePixels < (1 << 22));
  constexpr float kMagic = 12582912.0F;
  constexpr std::int32_t kMagicBits = 0x4B400000;
  const V magic = hn::Set(d, kMagic);
  const auto within = [&](V x, int size) {
    return hn::And(hn::Ge(x, hn::Set(d, -0.5F)), hn::Lt(x, hn::Set(d, static_cast<float>(size) - 0.5F)));
  };
  const auto inside = hn::And(visible, hn::And(within(u, grid.width_px), within(v, grid.height_px)));
  const V column = hn::Sub(hn::Add(u, magic), magic);
  const V row = hn::Sub(hn::Add(v, magic), magic);
  const V index = hn::Add(hn::Mul(row, hn::Set(d, static_cast<float>(grid.width_px))), column);
  const V chosen = hn::IfThenElse(inside, index, hn::Set(d, static_cast<float>(grid.outside())));
  return hn::Sub(hn::BitCast(di, hn::Add(chosen, magic)), hn::Set(di, kMagicBits));
}

// Lens distortion of normalized coordinates (x, y), OpenCV's five coefficients.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void distort(D d, const CameraModel& camera, V& x, V& y) {
  const auto k = [&](unsigned i) { return hn::Set(d, static_cast<float>(camera.distortion[i])); };
  const V two = hn::Set(d, 2.0F);
  const V xx = hn::Mul(x, x);
  const V yy = hn::Mul(y, y);
  const V xy2 = hn::Mul(two, hn::Mul(x, y));
  const V r2 = hn::Add(xx, yy);
  V radial = hn::Add(hn::Mul(k(4), r2), k(1));
  radial = hn::Add(hn::Mul(radial, r2), k(0));
  radial = hn::Add(hn::Mul(radial, r2), hn::Set(d, 1.0F));
  const V xd =
      hn::Add(hn::Mul(x, radial), hn::Add(hn::Mul(k(2), xy2), hn::Mul(k(3), hn::Add(r2, hn::Mul(two, xx)))));
  const V yd =
      hn::Add(hn::Mul(y, radial), hn::Add(hn::Mul(k(2), hn::Add(r2, hn::Mul(two, yy))), hn::Mul(k(3), xy2)));
  x = xd;
  y = yd;
}

// Takes no point for hidden.
struct EveryPoint {
  static constexpr bool kAll = true;
};

// Pixel indices of `count` points (x, y, z) of the target frame, posed by T_C_M, and how many of them count:
// all, or those that `counts(d, i)` says yes to, a vector at a time; the others get the index of what is
// beside the image. `index` is written in whole vectors; x, y, z are read so, and counted.
template <bool kDistorted, class Counts>
HWY_INLINE int point_indices_as(const CameraModel& camera, PixelGrid grid, const Transform& T_C_M,
                                const float* HWY_RESTRICT x_mm, const float* HWY_RESTRICT y_mm,
                                const float* HWY_RESTRICT z_mm, int count,
                                [[maybe_unused]] const Counts& counts, std::int32_t* HWY_RESTRICT index) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  // Without distortion the intrinsics fold into the matrix: [fx 0 cx; 0 fy cy; 0 0 1] [R t].
  float P[3][4];
  for (int column = 0; column < 4; ++column) {
    const auto entry = [&](int row) { return column < 3 ? T_C_M.R(row, column) : T_C_M.t_mm[row]; };
    const double depth = entry(2);
    P[0][column] = static_cast<float>(kDistorted ? entry(0) : camera.fx_px * entry(0) + camera.cx_px * depth);
    P[1][column] = static_cast<float>(kDistorted ? entry(1) : camera.fy_px * entry(1) + camera.cy_px * depth);
    P[2][column] = static_cast<float>(depth);
  }
  const auto row = [&](int r, hn::Vec<decltype(d)> x, hn::Vec<decltype(d)> y, hn::Vec<decltype(d)> z) {
    const auto xy = hn::Add(hn::Mul(hn::Set(d, P[r][0]), x), hn::Mul(hn::Set(d, P[r][1]), y));
    return hn::Add(xy, hn::Add(hn::Mul(hn::Set(d, P[r][2]), z), hn::Set(d, P[r][3])));
  };
  auto counted = hn::Zero(di);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < count; i += lanes) {
    const auto x = hn::Load(d, x_mm + i);
    const auto y = hn::Load(d, y_mm + i);
    const auto z = hn::Load(d, z_mm + i);
    const auto depth = row(2, x, y, z);
    auto visible = hn::Ge(depth, hn::Set(d, static_cast<float>(kMinDepth_mm)));
    if constexpr (!Counts::kAll) {
      const auto counts_here = counts(d, i);
      counted = hn::Sub(counted, hn::VecFromMask(di, hn::RebindMask(di, counts_here)));  // minus one if so
      visible = hn::And(counts_here, visible);
    }
    const auto inverse = hn::Div(hn::Set(d, 1.0F), depth);
    auto u = hn::Mul(row(0, x, y, z), inverse);
    auto v = hn::Mul(row(1, x, y, z), inverse);
    if constexpr (kDistorted) {
      distort(d, camera, u, v);
      u = hn::Add(hn::Mul(u, hn::Set(d, static_cast<float>(camera.fx_px))),
                  hn::Set(d, static_cast<float>(camera.cx_px)));
      v = hn::Add(hn::Mul(v, hn::Set(d, static_cast<float>(camera.fy_px))),
                  hn::Set(d, static_cast<float>(camera.cy_px)));
    }
    hn::Store(pixel_index(d, u, v, visible, grid), di, index + i);
  }
  return Counts::kAll ? count : hn::GetLane(hn::SumOfLanes(di, counted));
}

template <class Counts>
HWY_INLINE int point_indices(const CameraModel& camera, PixelGrid grid, const Transform& T_C_M,
                             const float* HWY_RESTRICT x_mm, const float* HWY_RESTRICT y_mm,
                             const float* HWY_RESTRICT z_mm, int count, const Counts& counts,
                             std::int32_t* HWY_RESTRICT index) {
  return camera.has_distortion()
             ? point_indices_as<true>(camera, grid, T_C_M, x_mm, y_mm, z_mm, count, counts, index)
             : point_indices_as<false>(camera, grid, T_C_M, x_mm, y_mm, z_mm, count, counts, index);
}

// Pixel indices of a disc's samples: the centre is projected once, and a sample at (px, py) of the pattern
// lies at radius R / Z times the pattern from it, in normalized coordinates.
template <bool kDistorted>
HWY_INLINE void disc_indices(const CameraModel& camera, PixelGrid grid, const Vector3& centre_C_mm,
                             double radius_mm, const float* HWY_RESTRICT pattern_x,
                             const float* HWY_RESTRICT pattern_y, int count,
                             std::int32_t* HWY_RESTRICT index) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const bool in_front = centre_C_mm[2] >= kMinDepth_mm;
  const double inverse = in_front ? 1.0 / centre_C_mm[2] : 0.0;
  const double x0 = centre_C_mm[0] * inverse;
  const double y0 = centre_C_mm[1] * inverse;
  const double r = radius_mm * inverse;
  const auto set = [&](double value) { return hn::Set(d, static_cast<float>(value)); };
  const auto visible = hn::FirstN(d, in_front ? hn::Lanes(d) : 0);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto fx = set(camera.fx_px);
  const auto fy = set(camera.fy_px);
  const auto cx = set(camera.cx_px);
  const auto cy = set(camera.cy_px);
  // Centre and radius in pixels, or where the lens bends the disc, in normalized coordinates.
  const auto u0 = set(kDistorted ? x0 : camera.fx_px * x0 + camera.cx_px);
  const auto v0 = set(kDistorted ? y0 : camera.fy_px * y0 + camera.cy_px);
  const auto ru = set(kDistorted ? r : camera.fx_px * r);
  const auto rv = set(kDistorted ? r : camera.fy_px * r);
  for (int i = 0; i < count; i += lanes) {
    auto u = hn::Add(u0, hn::Mul(ru, hn::Load(d, pattern_x + i)));
    auto v = hn::Add(v0, hn::Mul(rv, hn::Load(d, pattern_y + i)));
    if constexpr (kDistorted) {
      distort(d, camera, u, v);
      u = hn::Add(hn::Mul(u, fx), cx);
      v = hn::Add(hn::Mul(v, fy), cy);
    }
    hn::Store(pixel_index(d, u, v, visible, grid), di, index + i);
  }
}

}  // namespace
}  // namespace vergence::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
