// Conversion and halving, once per instruction set (Highway); integers, so every set gives the same bytes.
#include "algo/colour_pyramid.hpp"

#include <cstddef>

#include "algo/colour.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "algo/colour_pyramid.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vergence::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

ColourPixel pack(YCbCr c) {
  return static_cast<ColourPixel>(c.luma | (c.cb << 8) | (c.cr << 16));
}

void pack_rgb_row(const std::uint8_t* HWY_RESTRICT rgb, int width, ColourPixel* HWY_RESTRICT out) {
  const hn::ScalableTag<std::int16_t> d16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const int lanes = static_cast<int>(hn::Lanes(d16));
  const auto set = [&](int value) { return hn::Set(d16, static_cast<std::int16_t>(value)); };
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    hn::Vec<decltype(d8)> r8;
    hn::Vec<decltype(d8)> g8;
    hn::Vec<decltype(d8)> b8;
    hn::LoadInterleaved3(d8, rgb + 3 * x, r8, g8, b8);
    const auto r = hn::PromoteTo(d16, r8);
    const auto g = hn::PromoteTo(d16, g8);
    const auto b = hn::PromoteTo(d16, b8);
    // Luma needs 16 bits unsigned: the sums wrap as signed and the logical shift puts them right.
    const hn::RebindToUnsigned<decltype(d16)> du16;
    const auto y_sum =
        hn::Add(hn::Add(hn::Mul(r, set(77)), hn::Mul(g, set(150))), hn::Add(hn::Mul(b, set(29)), set(128)));
    const auto y = hn::BitCast(d16, hn::ShiftRight<8>(hn::BitCast(du16, y_sum)));
    const auto cb_sum =
        hn::Sub(hn::Add(hn::Mul(b, set(128)), set(127)), hn::Add(hn::Mul(r, set(43)), hn::Mul(g, set(85))));
    const auto cr_sum =
        hn::Sub(hn::Add(hn::Mul(r, set(128)), set(127)), hn::Add(hn::Mul(g, set(107)), hn::Mul(b, set(21))));
    const auto cb = hn::Add(hn::ShiftRight<8>(cb_sum), set(128));
    const auto cr = hn::Add(hn::ShiftRight<8>(cr_sum), set(128));
    hn::StoreInterleaved4(hn::DemoteTo(d8, y), hn::DemoteTo(d8, cb), hn::DemoteTo(d8, cr), hn::Zero(d8), d8,
                          reinterpret_cast<std::uint8_t*>(out + x));
  }
  for (; x < width; ++x) out[x] = pack(ycbcr_from_rgb(rgb[3 * x], rgb[3 * x + 1], rgb[3 * x + 2]));
}

// Two pixels share a pair of chroma bytes; luma bytes are `luma_step` apart.
void pack_yuv_row(const std::uint8_t* HWY_RESTRICT luma, int luma_step, const std::uint8_t* HWY_RESTRICT u,
                  const std::uint8_t* HWY_RESTRICT v, int chroma_step, int width,
                  ColourPixel* HWY_RESTRICT out) {
  for (int x = 0; x < width; x += 2) {
    const int chroma = (u[(x / 2) * chroma_step] << 8) | (v[(x / 2) * chroma_step] << 16);
    out[x] = static_cast<ColourPixel>(luma[x * luma_step] | chroma);
    out[x + 1] = static_cast<ColourPixel>(luma[(x + 1) * luma_step] | chroma);
  }
}

void pack_raw_rgb_row(const std::uint8_t* HWY_RESTRICT rgb, int width, ColourPixel* HWY_RESTRICT out) {
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes = static_cast<int>(hn::Lanes(d8));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    hn::Vec<decltype(d8)> r;
    hn::Vec<decltype(d8)> g;
    hn::Vec<decltype(d8)> b;
    hn::LoadInterleaved3(d8, rgb + 3 * x, r, g, b);
    hn::StoreInterleaved4(r, g, b, hn::Zero(d8), d8, reinterpret_cast<std::uint8_t*>(out + x));
  }
  for (; x < width; ++x) {
    const int packed = rgb[3 * x] | (rgb[3 * x + 1] << 8) | (rgb[3 * x + 2] << 16);
    out[x] = static_cast<ColourPixel>(packed);
  }
}

// kRaw: RGB stays RGB.
template <bool kRaw>
void pack_row(const ImageView& image, int y, ColourPixel* out) {
  const std::uint8_t* row = image.data + static_cast<std::size_t>(y) * image.stride_bytes;
  switch (image.format) {
    case PixelFormat::kRgb24:
      if constexpr (kRaw) {
        pack_raw_rgb_row(row, image.width_px, out);
      } else {
        pack_rgb_row(row, image.width_px, out);
      }
      break;
    case PixelFormat::kYuyv: pack_yuv_row(row, 2, row + 1, row + 3, 4, image.width_px, out); break;
    case PixelFormat::kUyvy: pack_yuv_row(row + 1, 2, row, row + 2, 4, image.width_px, out); break;
    case PixelFormat::kNv12: {
      const std::uint8_t* uv = image.chroma + static_cast<std::size_t>(y / 2) * image.chroma_stride_bytes;
      pack_yuv_row(row, 1, uv, uv + 1, 2, image.width_px, out);
      break;
    }
  }
}

// Rounded means of 2 x 2 pixels, all four bytes at once.
void halve_row(const ColourPixel* HWY_RESTRICT top, const ColourPixel* HWY_RESTRICT bottom, int out_width,
               ColourPixel* HWY_RESTRICT out) {
  constexpr std::uint32_t kEven = 0x00FF00FF;
  for (int x = 0; x < out_width; ++x) {
    const std::uint32_t a = top[2 * x];
    const std::uint32_t b = top[2 * x + 1];
    const std::uint32_t c = bottom[2 * x];
    const std::uint32_t d = bottom[2 * x + 1];
    const std::uint32_t even = (a & kEven) + (b & kEven) + (c & kEven) + (d & kEven) + 0x00020002;
    const std::uint32_t odd =
        ((a >> 8) & kEven) + ((b >> 8) & kEven) + ((c >> 8) & kEven) + ((d >> 8) & kEven) + 0x00020002;
    out[x] = ((even >> 2) & kEven) | (((odd >> 2) & kEven) << 8);
  }
}

template <class Finer, class Coarser>
void halve(const Finer& finer, Coarser& coarser) {
  coarser.width_px = finer.width_px / 2;
  coarser.height_px = finer.height_px / 2;
  for (int y = 0; y < coarser.height_px; ++y) {
    const ColourPixel* top = finer.pixel.data() + static_cast<std::ptrdiff_t>(2 * y) * finer.width_px;
    halve_row(top, top + finer.width_px, coarser.width_px,
              coarser.pixel.data() + static_cast<std::ptrdiff_t>(y) * coarser.width_px);
  }
  coarser.pixel[static_cast<std::size_t>(coarser.width_px * coarser.height_px)] = kNeutralPixel;
}

}  // namespace

template <bool kRaw>
void fill_full(const ImageView& image, ColourPyramid& pyramid) {
  pyramid.full.width_px = image.width_px;
  pyramid.full.height_px = image.height_px;
  for (int y = 0; y < image.height_px; ++y) {
    pack_row<kRaw>(image, y, pyramid.full.pixel.data() + static_cast<std::ptrdiff_t>(y) * image.width_px);
  }
  pyramid.full.pixel[static_cast<std::size_t>(image.width_px * image.height_px)] = kNeutralPixel;
}

void fill_raw(const ImageView& image, ColourPyramid& pyramid) {
  fill_full<true>(image, pyramid);
}

void fill_pyramid(const ImageView& image, ColourPyramid& pyramid) {
  fill_full<false>(image, pyramid);
  halve(pyramid.full, pyramid.half);
  halve(pyramid.half, pyramid.quarter);
  halve(pyramid.quarter, pyramid.eighth);
}

}  // namespace vergence::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vergence {

HWY_EXPORT(fill_raw);
HWY_EXPORT(fill_pyramid);

ColourLevel level_of(const ColourPyramid& pyramid, int level) {
  const auto view = [](const auto& plane) {
    return ColourLevel{plane.pixel.data(), plane.width_px, plane.height_px};
  };
  if (level == 0) return view(pyramid.full);
  if (level == 1) return view(pyramid.half);
  return level == 2 ? view(pyramid.quarter) : view(pyramid.eighth);
}

CameraModel camera_at_level(const CameraModel& camera, int level) {
  const double scale = 1.0 / (1 << level);
  CameraModel scaled = camera;
  scaled.width_px = camera.width_px >> level;
  scaled.height_px = camera.height_px >> level;
  scaled.fx_px = camera.fx_px * scale;
  scaled.fy_px = camera.fy_px * scale;
  // The centre of a coarse pixel lies between the centres of the finer ones.
  scaled.cx_px = (camera.cx_px + 0.5) * scale - 0.5;
  scaled.cy_px = (camera.cy_px + 0.5) * scale - 0.5;
  return scaled;
}

namespace {

Status check_image(const ImageView& image) {
  const bool yuv = image.format != PixelFormat::kRgb24;
  if (image.data == nullptr || (image.format == PixelFormat::kNv12 && image.chroma == nullptr)) {
    return Status::kBadImage;
  }
  if (image.width_px < 4 || image.height_px < 4 || image.width_px > kMaxImageWidth ||
      image.height_px > kMaxImageHeight || (yuv && (image.width_px % 2 != 0))) {
    return Status::kBadImage;
  }
  return Status::kOk;
}

}  // namespace

Status make_raw_colour(const ImageView& image, ColourPyramid& pyramid) {
  if (const Status status = check_image(image); status != Status::kOk) return status;
  HWY_DYNAMIC_DISPATCH(fill_raw)(image, pyramid);
  return Status::kOk;
}

Status make_colour_pyramid(const ImageView& image, ColourPyramid& pyramid) {
  if (const Status status = check_image(image); status != Status::kOk) return status;
  HWY_DYNAMIC_DISPATCH(fill_pyramid)(image, pyramid);
  return Status::kOk;
}

}  // namespace vergence
#endif
