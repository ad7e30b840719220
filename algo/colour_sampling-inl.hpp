// Colours of an image between its pixels, four lanes at a time on every machine: what refinement and relief
// read. Sums of floats depend on their order, so the order must not depend on the width of the vectors. To be
// included by files that are compiled for the least processor alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "algo/colour_pyramid.hpp"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace vergence {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

inline constexpr int kLanes = 4;
using D4 = hn::FixedTag<float, kLanes>;
using V4 = hn::Vec<D4>;
inline constexpr D4 d4;

HWY_INLINE V4 set(double value) {
  return hn::Set(d4, static_cast<float>(value));
}

// Colour of a pixel: luma, 2 cb, 2 cr, centred, and a zero.
HWY_INLINE V4 colour_of(ColourPixel pixel) {
  constexpr float kChromaWeight = 2;
  const hn::FixedTag<std::uint8_t, kLanes> d8;
  const hn::FixedTag<std::int32_t, kLanes> d32;
  alignas(4) std::uint8_t bytes[kLanes];
  std::memcpy(bytes, &pixel, sizeof bytes);
  alignas(16) static constexpr float kCentre[kLanes] = {128, 128, 128, 0};
  alignas(16) static constexpr float kScale[kLanes] = {1, kChromaWeight, kChromaWeight, 0};
  const V4 value = hn::ConvertTo(d4, hn::PromoteTo(d32, hn::Load(d8, bytes)));
  return hn::Mul(hn::Sub(value, hn::Load(d4, kCentre)), hn::Load(d4, kScale));
}

// Between four colours, fu to the right and fv down.
HWY_INLINE V4 blend(V4 fu, V4 fv, V4 a00, V4 a10, V4 a01, V4 a11) {
  const V4 top = hn::Add(a00, hn::Mul(fu, hn::Sub(a10, a00)));
  const V4 bottom = hn::Add(a01, hn::Mul(fu, hn::Sub(a11, a01)));
  return hn::Add(top, hn::Mul(fv, hn::Sub(bottom, top)));
}

// Colour at (u, v), bilinear, into four floats. Needs a border of one pixel, to the right and below.
[[maybe_unused]] HWY_INLINE void sample_value(const ColourLevel& image, float u, float v, float* value) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const ColourPixel* row = image.pixel + static_cast<std::ptrdiff_t>(y) * image.width_px + x;
  const ColourPixel* below = row + image.width_px;
  hn::Store(blend(hn::Set(d4, u - static_cast<float>(x)), hn::Set(d4, v - static_cast<float>(y)),
                  colour_of(row[0]), colour_of(row[1]), colour_of(below[0]), colour_of(below[1])),
            d4, value);
}

// And its slopes, from central differences. Needs a border of one pixel.
HWY_INLINE void sample_colour(const ColourLevel& image, float u, float v, float* value, float* slope_u,
                              float* slope_v) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const V4 fu = hn::Set(d4, u - static_cast<float>(x));
  const V4 fv = hn::Set(d4, v - static_cast<float>(y));
  const ColourPixel* row0 = image.pixel + static_cast<std::ptrdiff_t>(y - 1) * image.width_px + x;
  const ColourPixel* row1 = row0 + image.width_px;
  const ColourPixel* row2 = row1 + image.width_px;
  const ColourPixel* row3 = row2 + image.width_px;
  const V4 a00 = colour_of(row1[0]);
  const V4 a10 = colour_of(row1[1]);
  const V4 a01 = colour_of(row2[0]);
  const V4 a11 = colour_of(row2[1]);
  const V4 half = set(0.5);
  hn::Store(blend(fu, fv, a00, a10, a01, a11), d4, value);
  hn::Store(hn::Mul(half, blend(fu, fv, hn::Sub(a10, colour_of(row1[-1])), hn::Sub(colour_of(row1[2]), a00),
                                hn::Sub(a11, colour_of(row2[-1])), hn::Sub(colour_of(row2[2]), a01))),
            d4, slope_u);
  hn::Store(hn::Mul(half, blend(fu, fv, hn::Sub(a01, colour_of(row0[0])), hn::Sub(a11, colour_of(row0[1])),
                                hn::Sub(colour_of(row3[0]), a00), hn::Sub(colour_of(row3[1]), a10))),
            d4, slope_v);
}

}  // namespace
}  // namespace vergence
HWY_AFTER_NAMESPACE();
