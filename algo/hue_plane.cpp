// Rows of pixels to hue codes, once per instruction set (Highway).
//
// Rows have no scalar tail: the last vector overlaps the one before, so that the work depends on the width
// alone. Only a row narrower than one vector goes pixel by pixel.
#include "algo/hue_plane.hpp"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "algo/hue_plane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vergence::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// hue_code_rgb for a row. The quotient is taken in single precision: numerator and denominator are integers
// below 2^15 and 2^9, so a quotient that is not whole is at least 1/510 from any whole number, far more than
// rounding.
void rgb_row(const std::uint8_t* HWY_RESTRICT rgb, int width, const HueLimits& limits,
             std::uint8_t* HWY_RESTRICT out) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> d32;
  const hn::Repartition<std::int16_t, decltype(df)> d16;
  const hn::Half<decltype(d16)> d16half;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto set = [&](int value) { return hn::Set(d16, static_cast<std::int16_t>(value)); };
  const auto thousand = hn::Set(df, 1000.0F);
  const auto permille = hn::Set(df, static_cast<float>(limits.min_saturation_permille));

  if (width < lanes) {
    for (int x = 0; x < width; ++x) out[x] = hue_code_rgb(rgb[3 * x], rgb[3 * x + 1], rgb[3 * x + 2], limits);
    return;
  }
  for (int next = 0; next < width; next += lanes) {
    const int x = HWY_MIN(next, width - lanes);
    hn::Vec<decltype(d8)> r8;
    hn::Vec<decltype(d8)> g8;
    hn::Vec<decltype(d8)> b8;
    hn::LoadInterleaved3(d8, rgb + 3 * x, r8, g8, b8);
    const auto r = hn::PromoteTo(d16, r8);
    const auto g = hn::PromoteTo(d16, g8);
    const auto b = hn::PromoteTo(d16, b8);
    const auto V = hn::Max(hn::Max(r, g), b);
    const auto v = hn::Min(hn::Min(r, g), b);
    const auto C = hn::Sub(V, v);
    const auto is_red = hn::Eq(V, r);
    const auto is_green = hn::Eq(V, g);
    const auto difference =
        hn::IfThenElse(is_red, hn::Sub(g, b), hn::IfThenElse(is_green, hn::Sub(b, r), hn::Sub(r, g)));
    const auto below_red = hn::IfThenElse(hn::Lt(g, b), set(kHueSteps), hn::Zero(d16));
    const auto sector = hn::IfThenElse(is_red, below_red, hn::IfThenElse(is_green, set(84), set(168)));
    const auto numerator = hn::Add(hn::Mul(difference, set(84)), C);
    const auto denominator = hn::Max(hn::Add(C, C), set(1));

    const auto half = [&](auto n16, auto d16_, auto V16) {
      const auto n = hn::ConvertTo(df, hn::PromoteTo(d32, n16));
      const auto d = hn::ConvertTo(df, hn::PromoteTo(d32, d16_));
      const auto step = hn::Floor(hn::Div(n, d));
      // 1000 C < permille V, with C = d / 2 (or d = 1 where C is zero: no hue either way).
      const auto gated = hn::Lt(hn::Mul(thousand, hn::Mul(d, hn::Set(df, 0.5F))),
                                hn::Mul(permille, hn::ConvertTo(df, hn::PromoteTo(d32, V16))));
      const auto marked = hn::IfThenElse(gated, hn::Set(df, 1000.0F), step);  // told from any step below
      return hn::DemoteTo(d16half, hn::ConvertTo(d32, marked));
    };
    const auto lower = half(hn::LowerHalf(d16half, numerator), hn::LowerHalf(d16half, denominator),
                            hn::LowerHalf(d16half, V));
    const auto upper = half(hn::UpperHalf(d16half, numerator), hn::UpperHalf(d16half, denominator),
                            hn::UpperHalf(d16half, V));
    const auto step = hn::Combine(d16, upper, lower);
    auto code = hn::Add(step, sector);
    code = hn::IfThenElse(hn::Gt(code, set(kHueSteps - 1)), hn::Sub(code, set(kHueSteps)), code);
    const auto undefined = hn::Or(hn::Eq(C, hn::Zero(d16)), hn::Eq(step, set(1000)));
    code = hn::IfThenElse(undefined, set(kHueUndefined), code);
    code = hn::IfThenElse(hn::Gt(v, set(limits.bright_from - 1)), set(kHueBright), code);
    code = hn::IfThenElse(hn::Lt(V, set(limits.dark_below)), set(kHueDark), code);
    hn::StoreU(hn::DemoteTo(d8, code), d8, out + x);
  }
}

// Codes of pairs of pixels that share U and V: `luma` holds Y0 | Y1 << 16 a lane, `index` 256 U + V.
template <class DU32, class V32 = hn::Vec<DU32>>
HWY_INLINE void store_pairs(DU32 du32, V32 luma, V32 index, const std::uint32_t* HWY_RESTRICT table,
                            std::uint8_t* HWY_RESTRICT out) {
  const hn::RebindToSigned<DU32> d32;
  const hn::Repartition<std::int16_t, DU32> d16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const V32 entry = hn::GatherIndex(du32, table, hn::BitCast(d32, index));
  const V32 byte = hn::Set(du32, 0xFFU);
  const auto twice = [&](V32 value) { return hn::BitCast(d16, hn::Or(value, hn::ShiftLeft<16>(value))); };
  const auto hue = twice(hn::And(entry, byte));
  const auto dark_below = twice(hn::And(hn::ShiftRight<8>(entry), byte));
  const auto undefined_above = twice(hn::And(hn::ShiftRight<16>(entry), byte));
  const auto bright_above = twice(hn::ShiftRight<24>(entry));
  const auto y = hn::BitCast(d16, luma);
  auto code = hn::IfThenElse(hn::Gt(y, undefined_above), hn::Set(d16, kHueUndefined), hue);
  code = hn::IfThenElse(hn::Gt(y, bright_above), hn::Set(d16, kHueBright), code);
  code = hn::IfThenElse(hn::Lt(y, dark_below), hn::Set(d16, kHueDark), code);
  hn::StoreU(hn::DemoteTo(d8, code), d8, out);
}

// Packed 4:2:2: a little-endian word holds two pixels. kLumaShift: 0 for YUYV, 8 for UYVY.
template <int kLumaShift>
void packed_row(const std::uint8_t* HWY_RESTRICT row, int width, const YuvHueTable& table,
                std::uint8_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::uint32_t> du32;
  const hn::Repartition<std::uint8_t, decltype(du32)> d8;
  const int lanes = static_cast<int>(hn::Lanes(du32));
  const int pairs = width / 2;
  const auto even_bytes = hn::Set(du32, 0x00FF00FFU);
  if (pairs < lanes) {
    for (int i = 0; i < pairs; ++i) {
      const std::uint8_t* p = row + 4 * i;
      const int u = kLumaShift == 0 ? p[1] : p[0];
      const int v = kLumaShift == 0 ? p[3] : p[2];
      out[2 * i] = table.code(kLumaShift == 0 ? p[0] : p[1], u, v);
      out[2 * i + 1] = table.code(kLumaShift == 0 ? p[2] : p[3], u, v);
    }
    return;
  }
  for (int next = 0; next < pairs; next += lanes) {
    const int i = HWY_MIN(next, pairs - lanes);
    const auto word = hn::BitCast(du32, hn::LoadU(d8, row + 4 * i));
    const auto luma = hn::And(hn::ShiftRight<kLumaShift>(word), even_bytes);
    const auto chroma = hn::And(hn::ShiftRight<8 - kLumaShift>(word), even_bytes);  // U | V << 16
    const auto index =
        hn::Or(hn::ShiftLeft<8>(hn::And(chroma, hn::Set(du32, 0xFFU))), hn::ShiftRight<16>(chroma));
    store_pairs(du32, luma, index, table.entries(), out + 2 * i);
  }
}

void nv12_row(const std::uint8_t* HWY_RESTRICT luma_row, const std::uint8_t* HWY_RESTRICT chroma_row,
              int width, const YuvHueTable& table, std::uint8_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::uint32_t> du32;
  const hn::Rebind<std::uint16_t, decltype(du32)> du16;
  const hn::Repartition<std::uint8_t, decltype(du16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(du32));
  const int pairs = width / 2;
  const auto byte = hn::Set(du32, 0xFFU);
  const auto words = [&](const std::uint8_t* p) {
    return hn::PromoteTo(du32, hn::BitCast(du16, hn::LoadU(d8, p)));
  };
  if (pairs < lanes) {
    for (int i = 0; i < pairs; ++i) {
      const int u = chroma_row[2 * i];
      const int v = chroma_row[2 * i + 1];
      out[2 * i] = table.code(luma_row[2 * i], u, v);
      out[2 * i + 1] = table.code(luma_row[2 * i + 1], u, v);
    }
    return;
  }
  for (int next = 0; next < pairs; next += lanes) {
    const int i = HWY_MIN(next, pairs - lanes);
    const auto y = words(luma_row + 2 * i);
    const auto uv = words(chroma_row + 2 * i);
    const auto luma = hn::Or(hn::And(y, byte), hn::ShiftLeft<16>(hn::ShiftRight<8>(y)));
    const auto index = hn::Or(hn::ShiftLeft<8>(hn::And(uv, byte)), hn::ShiftRight<8>(uv));
    store_pairs(du32, luma, index, table.entries(), out + 2 * i);
  }
}

}  // namespace

void hue_row(const ImageView& image, int y, const HueLimits& limits, const YuvHueTable& table,
             std::uint8_t* out) {
  const std::uint8_t* row = image.data + static_cast<std::size_t>(y) * image.stride_bytes;
  switch (image.format) {
    case PixelFormat::kRgb24: rgb_row(row, image.width_px, limits, out); break;
    case PixelFormat::kYuyv: packed_row<0>(row, image.width_px, table, out); break;
    case PixelFormat::kUyvy: packed_row<8>(row, image.width_px, table, out); break;
    case PixelFormat::kNv12:
      nv12_row(row, image.chroma + static_cast<std::size_t>(y / 2) * image.chroma_stride_bytes,
               image.width_px, table, out);
      break;
  }
}

}  // namespace vergence::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vergence {

HWY_EXPORT(hue_row);

void YuvHueTable::build(const HueLimits& limits) {
  constexpr double kLumaGain = 255.0 / 219.0;
  const auto ceiling = [](double value) {  // smallest whole number >= value, at least 0, at most 256
    if (!(value > 0)) return 0;
    const int truncated = value < 256 ? static_cast<int>(value) : 256;
    return truncated < value && truncated < 256 ? truncated + 1 : truncated;
  };
  for (int u = 0; u < 256; ++u) {
    for (int v = 0; v < 256; ++v) {
      // r, g, b less the common grey kLumaGain (Y - 16).
      const double pb = (u - 128) / 112.0;
      const double pr = (v - 128) / 112.0;
      const double r = 255 * 0.701 * pr;
      const double b = 255 * 0.886 * pb;
      const double g = -255 * (0.886 * 0.114 / 0.587 * pb + 0.701 * 0.299 / 0.587 * pr);
      const double larger = r > g ? r : g;
      const double smaller = r < g ? r : g;
      const double V = larger > b ? larger : b;
      const double least = smaller < b ? smaller : b;
      const double C = V - least;
      std::uint32_t hue = kHueUndefined;
      if (u != 128 || v != 128) {
        const double sixths = V == r ? (g - b) / C : (V == g ? 2 + (b - r) / C : 4 + (r - g) / C);
        hue = hue_code_from_degrees(60 * sixths);
      }
      // Y at which grey + V reaches a level, as the first whole Y at or beyond it.
      const auto first_y = [&](double level, double chroma) {
        return ceiling((level - chroma) / kLumaGain + 16);
      };
      const int dark_below = first_y(limits.dark_below, V);
      const int bright_from = first_y(limits.bright_from, least);
      // 1000 C < s V: the first Y BEYOND the level V = 1000 C / s.
      int undefined_above = 255;
      if (limits.min_saturation_permille > 0) {
        const double y = (1000 * C / limits.min_saturation_permille - V) / kLumaGain + 16;
        undefined_above = y < 255 ? (y > 0 ? static_cast<int>(y) : 0) : 255;
      }
      const auto byte = [](int value) {
        return static_cast<std::uint32_t>(value < 0 ? 0 : (value > 255 ? 255 : value));
      };
      entry_[static_cast<std::size_t>(u * 256 + v)] =
          hue | byte(dark_below) << 8 | byte(undefined_above) << 16 | byte(bright_from - 1) << 24;
    }
  }
}

std::uint8_t YuvHueTable::code(int y, int u, int v) const {
  const std::uint32_t entry = entry_[static_cast<std::size_t>(u * 256 + v)];
  const auto field = [entry](int shift) { return static_cast<int>((entry >> shift) & 0xFF); };
  if (y < field(8)) return kHueDark;
  if (y > field(24)) return kHueBright;
  return y > field(16) ? kHueUndefined : static_cast<std::uint8_t>(field(0));
}

namespace {

bool is_usable(const ImageView& image) {
  if (image.data == nullptr || image.width_px < 1 || image.height_px < 1 || image.width_px > kMaxImageWidth ||
      image.height_px > kMaxImageHeight) {
    return false;
  }
  const auto width = static_cast<std::size_t>(image.width_px);
  const bool even = width % 2 == 0;
  switch (image.format) {
    case PixelFormat::kRgb24: return image.stride_bytes >= 3 * width;
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy: return even && image.stride_bytes >= 2 * width;
    case PixelFormat::kNv12:
      return even && image.stride_bytes >= width && image.chroma != nullptr &&
             image.chroma_stride_bytes >= width;
  }
  return false;  // no format of ours
}

}  // namespace

Status make_hue_plane(const ImageView& image, const HueLimits& limits, const YuvHueTable& table,
                      HuePlane& plane) {
  if (!is_usable(image)) return Status::kBadImage;
  plane.width_px = image.width_px;
  plane.height_px = image.height_px;
  for (int y = 0; y < image.height_px; ++y) {
    HWY_DYNAMIC_DISPATCH(hue_row)
    (image, y, limits, table, plane.code.data() + static_cast<std::ptrdiff_t>(y) * image.width_px);
  }
  std::fill_n(plane.code.begin() + plane.outside_index(), kHuePadding, kHueOutside);
  return Status::kOk;
}

}  // namespace vergence
#endif
