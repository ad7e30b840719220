// The evaluator, once per instruction set (Highway). Two loops a camera: project the samples to pixel
// indices, eight or so at a time; then read one hue byte a sample, one by one (gathers of bytes are slower),
// and count votes, 32 or so at a time.
#include "algo/fitness.hpp"

#include <cstddef>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "algo/fitness.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "algo/projection-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace vergence::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Reads the hue byte of every index, eight at a time into one word: a store each eight samples, and little
// loop overhead.
HWY_INLINE void read_codes(const std::uint8_t* HWY_RESTRICT plane, const std::int32_t* HWY_RESTRICT index,
                           int count, std::uint8_t* HWY_RESTRICT out) {
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    std::uint64_t word = 0;
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) word |= std::uint64_t{plane[index[i + k]]} << (8 * k);
    std::memcpy(out + i, &word, 8);
  }
  for (; i < count; ++i) out[i] = plane[index[i]];
}

// a <= b of unsigned bytes, for which Highway has no comparison.
template <class V>
HWY_INLINE auto at_most(V a, V b) {
  return hn::Eq(hn::SaturatedSub(a, b), hn::Zero(hn::DFromV<V>()));
}

// The first `count` lanes; count may be negative, or more than the lanes (FirstN's own limit is that of a
// byte).
template <class D>
HWY_INLINE hn::Mask<D> first(D d, int count) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int within = count < lanes ? count : lanes;
  return hn::FirstN(d, static_cast<std::size_t>(within > 0 ? within : 0));
}

// Circular distance of hue codes, 255 where either has no hue.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V distance(D d, V a, V b) {
  const V steps = hn::Set(d, kHueSteps);
  const V difference = hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
  const V around = hn::Sub(steps, difference);  // wraps, but then a or b has no hue
  const auto no_hue = hn::Or(at_most(steps, a), at_most(steps, b));
  return hn::IfThenElse(no_hue, hn::Set(d, 255), hn::Min(difference, around));
}

std::int32_t marker_votes(const MarkerModel& model, const CameraModel& camera, const HuePlane& plane,
                          const Transform& T_C_M) {
  // All balls go through one step before any goes through the next: bytes written one by one must have
  // settled in the cache before they are read back as vectors.
  constexpr int kStride = kMaxInnerSamples + kMaxOuterSamples;
  const int samples = model.inner_samples + model.outer_samples;
  alignas(64) std::int32_t index[kMaxBalls * kStride + 16];
  alignas(64) std::uint8_t code[kMaxBalls * kStride + 64];
  const bool distorted = camera.has_distortion();
  const PixelGrid grid{plane.width_px, plane.height_px};
  for (int ball = 0; ball < model.balls; ++ball) {
    const Ball& b = model.ball[static_cast<unsigned>(ball)];
    const Vector3 centre_mm = T_C_M * b.centre_mm;
    std::int32_t* out = index + ball * kStride;
    if (distorted) {
      disc_indices<true>(camera, grid, centre_mm, b.radius_mm, model.pattern_x.data(), model.pattern_y.data(),
                         samples, out);
    } else {
      disc_indices<false>(camera, grid, centre_mm, b.radius_mm, model.pattern_x.data(),
                          model.pattern_y.data(), samples, out);
    }
  }
  for (int ball = 0; ball < model.balls; ++ball) {
    read_codes(plane.code.data(), index + ball * kStride, samples, code + ball * kStride);
  }
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes8 = static_cast<int>(hn::Lanes(d8));
  std::int32_t votes = 0;
  for (int ball = 0; ball < model.balls; ++ball) {
    const auto hue = hn::Set(d8, model.hue[static_cast<unsigned>(ball)]);
    const auto tolerance = hn::Set(d8, model.tolerance[static_cast<unsigned>(ball)]);
    std::int32_t in = 0;
    std::int32_t all = 0;
    for (int i = 0; i < samples; i += lanes8) {
      const auto match = at_most(distance(d8, hn::LoadU(d8, code + ball * kStride + i), hue), tolerance);
      const auto within_in = first(d8, model.inner_samples - i);
      const auto within = first(d8, samples - i);
      in += static_cast<std::int32_t>(hn::CountTrue(d8, hn::And(match, within_in)));
      all += static_cast<std::int32_t>(hn::CountTrue(d8, hn::And(match, within)));
    }
    // sum p = matches - others = 2 matches - samples, inner minus outer.
    votes += (2 * in - model.inner_samples) - (2 * (all - in) - model.outer_samples);
  }
  return votes;
}

std::int32_t photo_votes(const PhotoModel& model, const CameraModel& camera, const HuePlane& plane,
                         const Transform& T_C_M) {
  alignas(64) std::int32_t index[kMaxPhotoPoints + 16];
  alignas(64) std::uint8_t code[kMaxPhotoPoints + 64];
  const int points = model.points();
  point_indices(camera, {plane.width_px, plane.height_px}, T_C_M, model.x_mm.data(), model.y_mm.data(),
                model.z_mm.data(), points, EveryPoint{}, index);
  read_codes(plane.code.data(), index, points, code);

  const PhotoVotes& votes = model.votes;
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes8 = static_cast<int>(hn::Lanes(d8));
  const auto background = hn::Set(d8, model.background_hue);
  const auto steps = [&](double degrees) {
    return hn::Set(d8, static_cast<std::uint8_t>(hue_tolerance_steps(degrees)));
  };
  const auto in_tolerance = steps(votes.in_tolerance_deg);
  const auto background_tolerance = steps(votes.background_tolerance_deg);
  const auto out_tolerance = steps(votes.out_tolerance_deg);
  const auto count = [&](hn::Mask<decltype(d8)> mask) {
    return static_cast<std::int32_t>(hn::CountTrue(d8, mask));
  };

  std::int32_t in_match = 0;
  std::int32_t in_background = 0;
  std::int32_t out_background = 0;
  for (int i = 0; i < model.inner; i += lanes8) {
    const auto seen = hn::LoadU(d8, code + i);
    const auto within = first(d8, model.inner - i);
    const auto match = at_most(distance(d8, seen, hn::LoadU(d8, model.hue.data() + i)), in_tolerance);
    const auto bare = hn::AndNot(match, at_most(distance(d8, seen, background), background_tolerance));
    in_match += count(hn::And(match, within));
    in_background += count(hn::And(bare, within));
  }
  for (int i = model.inner; i < points; i += lanes8) {
    const auto within = first(d8, points - i);
    const auto bare = at_most(distance(d8, hn::LoadU(d8, code + i), background), out_tolerance);
    out_background += count(hn::And(bare, within));
  }
  return in_match * votes.in_match + in_background * votes.in_background +
         (model.inner - in_match - in_background) * votes.in_other +  //
         out_background * votes.out_background + (model.outer - out_background) * votes.out_other;
}

}  // namespace vergence::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vergence {

HWY_EXPORT(marker_votes);
HWY_EXPORT(photo_votes);

std::int32_t marker_votes(const MarkerModel& model, const CameraModel& camera, const HuePlane& plane,
                          const Transform& T_C_M) {
  return HWY_DYNAMIC_DISPATCH(marker_votes)(model, camera, plane, T_C_M);
}

std::int32_t photo_votes(const PhotoModel& model, const CameraModel& camera, const HuePlane& plane,
                         const Transform& T_C_M) {
  return HWY_DYNAMIC_DISPATCH(photo_votes)(model, camera, plane, T_C_M);
}

double marker_fitness(const MarkerModel& model, std::int64_t votes_left_and_right) {
  return static_cast<double>(votes_left_and_right) / (2.0 * model.balls * model.inner_samples);
}

double photo_fitness(const PhotoModel& model, std::int64_t votes_left_and_right) {
  return static_cast<double>(votes_left_and_right) / (2.0 * 1000.0 * model.points());
}

}  // namespace vergence
#endif
