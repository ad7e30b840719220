// Correlation sums, once per instruction set (Highway). The sums are integers; only their few quotients at
// the end are floating point, in double precision, once a camera.
#include "algo/correlation.hpp"

#include <cmath>

// A search asks for 48 points, some 70,000 times a frame: AVX-512 spends more on the ends than it saves
// between them (a cold frame takes 7 % longer with it).
#if defined(__x86_64__)
#define HWY_DISABLED_TARGETS HWY_AVX3
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "algo/correlation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "algo/projection-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace vergence::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Which points face the camera. Single precision, no fused multiply-add: the same on every processor.
class FacingPoints {
 public:
  static constexpr bool kAll = false;
  FacingPoints(const PhotoModel& photo, const Transform& T_C_M)
      : normals_(photo.normals), left_out_mm_(photo.left_out_mm.data()) {
    constexpr double kFacing = 0.1;  // cosine: normals are not exact, and what is seen edge on tells little
    const Vector3 eye_mm = -(T_C_M.R.transpose() * T_C_M.t_mm);
    for (int k = 0; k < 3; ++k) eye_mm_[k] = static_cast<float>(eye_mm[k]);
    least_mm_ = static_cast<float>(kFacing * std::sqrt(eye_mm.squaredNorm()));
  }

  template <class D>
  HWY_INLINE hn::Mask<D> operator()(D d, int i) const {
    const auto part = [&](int k, const float* normal) {
      return hn::Mul(hn::Set(d, eye_mm_[k]), hn::Load(d, normal + i));
    };
    const auto towards =
        hn::Add(hn::Add(part(0, normals_.x.data()), part(1, normals_.y.data())), part(2, normals_.z.data()));
    const auto distance_mm =
        hn::Sub(hn::Sub(towards, hn::Load(d, normals_.reach_mm.data() + i)), hn::Load(d, left_out_mm_ + i));
    return hn::Gt(distance_mm, hn::Set(d, least_mm_));
  }

 private:
  const SurfaceNormals& normals_;
  const float* left_out_mm_;
  float eye_mm_[3];
  float least_mm_;
};

void correlation_sums(const CorrelationModel& model, const PhotoModel& photo, const CameraModel& camera,
                      const ColourLevel& image, const Transform& T_C_M, CorrelationSums& sums) {
  alignas(64) std::int32_t index[kMaxPhotoPoints + 16];
  alignas(64) ColourPixel pixel[kMaxPhotoPoints + 16];
  const PixelGrid grid{image.width_px, image.height_px};
  const auto project = [&](const auto& counts) {
    return point_indices(camera, grid, T_C_M, photo.x_mm.data(), photo.y_mm.data(), photo.z_mm.data(),
                         model.points, counts, index);
  };
  const int facing =
      model.hidden == HiddenPoints::kLeftOut ? project(FacingPoints(photo, T_C_M)) : project(EveryPoint{});
  for (int i = 0; i < model.points; ++i) pixel[i] = image.pixel[index[i]];

  const hn::ScalableTag<std::int32_t> d32;
  const hn::RebindToUnsigned<decltype(d32)> du32;
  const hn::Repartition<std::int16_t, decltype(d32)> d16;
  const int lanes = static_cast<int>(hn::Lanes(d32));
  const auto even_bytes = hn::Set(du32, 0x00FF00FFU);
  const auto low_byte = hn::Set(du32, 0x000000FFU);
  const auto centre_both = hn::Set(d16, 128);
  const auto centre_low = hn::BitCast(d16, hn::Set(du32, 0x00000080U));
  const auto high_half = hn::BitCast(d16, hn::Set(du32, 0xFFFF0000U));
  const auto one_low = hn::BitCast(d16, hn::Set(du32, 0x00000001U));
  const auto one_high = hn::BitCast(d16, hn::Set(du32, 0x00010000U));

  const auto outside = hn::Set(d32, grid.outside());
  auto squares = hn::Zero(d32);
  auto products = hn::Zero(d32);
  auto seen = hn::Zero(d32);
  const auto accumulate = [&](auto a, auto c, auto& sum) {
    auto other = hn::Zero(d32);  // where some instruction sets put half of the sums
    sum = hn::ReorderWidenMulAccumulate(d32, a, c, sum, other);
    sum = hn::Add(sum, other);
  };
  struct Channels {
    hn::Vec<decltype(d32)> luma;
    hn::Vec<decltype(d32)> cb;
    hn::Vec<decltype(d32)> cr;
  };
  Channels of_image{hn::Zero(d32), hn::Zero(d32), hn::Zero(d32)};
  Channels of_model{hn::Zero(d32), hn::Zero(d32), hn::Zero(d32)};
  // Plain sums fit into 16 bits for so many vectors.
  const int block = 64 * lanes;
  for (int from = 0; from < model.points; from += block) {
    const int to = from + block < model.points ? from + block : model.points;
    auto image_yr = hn::Zero(d16);
    auto image_b = hn::Zero(d16);
    auto seen_yr = hn::Zero(d16);
    auto seen_b = hn::Zero(d16);
    for (int i = from; i < to; i += lanes) {
      const auto packed = hn::Load(du32, pixel + i);
      auto yr = hn::Sub(hn::BitCast(d16, hn::And(packed, even_bytes)), centre_both);
      yr = hn::Add(yr, hn::And(yr, high_half));  // luma, 2 cr
      auto b = hn::Sub(hn::BitCast(d16, hn::And(hn::ShiftRight<8>(packed), low_byte)), centre_low);
      b = hn::Add(b, b);  // 2 cb, 0
      const auto model_yr = hn::Load(d16, model.luma_cr.data() + 2 * i);
      const auto model_b = hn::Load(d16, model.cb.data() + 2 * i);
      const auto is_seen = hn::VecFromMask(d32, hn::Lt(hn::Load(d32, index + i), outside));
      seen = hn::Sub(seen, is_seen);  // minus one where it is
      image_yr = hn::Add(image_yr, yr);
      image_b = hn::Add(image_b, b);
      seen_yr = hn::Add(seen_yr, hn::And(model_yr, hn::BitCast(d16, is_seen)));
      seen_b = hn::Add(seen_b, hn::And(model_b, hn::BitCast(d16, is_seen)));
      accumulate(yr, yr, squares);
      accumulate(b, b, squares);
      accumulate(yr, model_yr, products);
      accumulate(b, model_b, products);
    }
    const auto add_up = [&](auto yr, auto b, Channels& sums16) {
      accumulate(yr, one_low, sums16.luma);
      accumulate(yr, one_high, sums16.cr);
      accumulate(b, one_low, sums16.cb);
    };
    add_up(image_yr, image_b, of_image);
    add_up(seen_yr, seen_b, of_model);
  }
  const auto total = [&](auto v) { return static_cast<std::int64_t>(hn::GetLane(hn::SumOfLanes(d32, v))); };
  sums = {total(of_image.luma), total(of_image.cb),   total(of_image.cr),
          total(squares),       total(products),      facing,
          total(seen),          total(of_model.luma), total(of_model.cb),
          total(of_model.cr)};
}

}  // namespace vergence::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vergence {

HWY_EXPORT(correlation_sums);

namespace {

constexpr std::int64_t kNoiseVariance = 20;  // of a bare wall, a point

}  // namespace

void build_correlation_model(const PhotoModel& photo, int level, int points, HiddenPoints hidden,
                             CorrelationModel& model) {
  model = CorrelationModel{};
  model.level = level;
  model.hidden = hidden;
  const int available = points < photo.inner ? points : photo.inner;
  model.points = available >= 16 ? available / 16 * 16 : 0;
  const PointColours& colours = photo.colour[static_cast<unsigned>(level)];
  std::int64_t n = 0;
  for (unsigned i = 0; i < static_cast<unsigned>(model.points); ++i) {
    const int luma = colours.luma[i] - 128;
    const int cb = 2 * (colours.cb[i] - 128);
    const int cr = 2 * (colours.cr[i] - 128);
    model.luma_cr[2 * i] = static_cast<std::int16_t>(luma);
    model.luma_cr[2 * i + 1] = static_cast<std::int16_t>(cr);
    model.cb[2 * i] = static_cast<std::int16_t>(cb);
    if (photo.left_out_mm[i] > 0) continue;
    ++n;
    model.sum_luma += luma;
    model.sum_cb += cb;
    model.sum_cr += cr;
    model.sum_squares += luma * luma + cb * cb + cr * cr;
  }
  if (n == 0) {
    model.points = 0;
    return;
  }
  const double of_all = static_cast<double>(model.points) / static_cast<double>(n);
  model.deviation =
      of_all * std::sqrt(static_cast<double>(n * model.sum_squares -
                                             (model.sum_luma * model.sum_luma + model.sum_cb * model.sum_cb +
                                              model.sum_cr * model.sum_cr) +
                                             n * n * kNoiseVariance));
}

std::int64_t correlation(const CorrelationModel& model, const PhotoModel& photo, const CameraModel& camera,
                         const ColourLevel& image, const Transform& T_C_M) {
  if (model.points == 0) return 0;
  CorrelationSums s;
  HWY_DYNAMIC_DISPATCH(correlation_sums)(model, photo, camera, image, T_C_M, s);
  if (s.seen == 0) return 0;
  // Times n^2, over the points that are seen: sum ab - sum a sum b / seen, by the share that is seen; and
  // what is seen varies about its own mean.
  const std::int64_t n = s.facing;
  const std::int64_t covariance =
      s.seen * s.products - (s.luma * s.model_luma + s.cb * s.model_cb + s.cr * s.model_cr);
  const double means = static_cast<double>(n) / static_cast<double>(s.seen) *
                       static_cast<double>(s.luma * s.luma + s.cb * s.cb + s.cr * s.cr);
  const double variance = static_cast<double>(n * s.squares + n * n * kNoiseVariance) - means;
  const double facing = static_cast<double>(n) / static_cast<double>(model.points);
  const double scale = std::sqrt(variance) * (model.deviation * facing);
  return static_cast<std::int64_t>(static_cast<double>(covariance) / scale *
                                   static_cast<double>(kCorrelationOne));
}

}  // namespace vergence
#endif
