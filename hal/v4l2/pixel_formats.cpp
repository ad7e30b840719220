#include "hal/v4l2/pixel_formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>

namespace vergence::v4l2 {
namespace {

constexpr std::array kKnown = {
    KnownFormat{V4L2_PIX_FMT_YUYV, PixelFormat::kYuyv, 1, 2},
    KnownFormat{V4L2_PIX_FMT_UYVY, PixelFormat::kUyvy, 1, 2},
    KnownFormat{V4L2_PIX_FMT_NV12, PixelFormat::kNv12, 1, 1},
    KnownFormat{V4L2_PIX_FMT_NV12M, PixelFormat::kNv12, 2, 1},
    KnownFormat{V4L2_PIX_FMT_RGB24, PixelFormat::kRgb24, 1, 3},
};

constexpr std::uint32_t kCompressed[] = {
    V4L2_PIX_FMT_MJPEG,       V4L2_PIX_FMT_JPEG,       V4L2_PIX_FMT_DV,       V4L2_PIX_FMT_MPEG,
    V4L2_PIX_FMT_H264,        V4L2_PIX_FMT_H264_NO_SC, V4L2_PIX_FMT_H264_MVC, V4L2_PIX_FMT_H263,
    V4L2_PIX_FMT_MPEG1,       V4L2_PIX_FMT_MPEG2,      V4L2_PIX_FMT_MPEG4,    V4L2_PIX_FMT_XVID,
    V4L2_PIX_FMT_VC1_ANNEX_G, V4L2_PIX_FMT_VP8,        V4L2_PIX_FMT_VP9,      V4L2_PIX_FMT_HEVC,
    V4L2_PIX_FMT_PJPG};

constexpr std::uint32_t kGrey[] = {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_Y4,     V4L2_PIX_FMT_Y6,
                                   V4L2_PIX_FMT_Y10,  V4L2_PIX_FMT_Y12,    V4L2_PIX_FMT_Y14,
                                   V4L2_PIX_FMT_Y16,  V4L2_PIX_FMT_Y16_BE, V4L2_PIX_FMT_Y10BPACK,
                                   V4L2_PIX_FMT_Y10P, V4L2_PIX_FMT_Y8I,    V4L2_PIX_FMT_Y12I};

constexpr std::uint32_t kDepth[] = {V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_INZI};

constexpr std::uint32_t kBayer[] = {
    V4L2_PIX_FMT_SBGGR8,   V4L2_PIX_FMT_SGBRG8,   V4L2_PIX_FMT_SGRBG8,   V4L2_PIX_FMT_SRGGB8,
    V4L2_PIX_FMT_SBGGR10,  V4L2_PIX_FMT_SGBRG10,  V4L2_PIX_FMT_SGRBG10,  V4L2_PIX_FMT_SRGGB10,
    V4L2_PIX_FMT_SBGGR10P, V4L2_PIX_FMT_SGBRG10P, V4L2_PIX_FMT_SGRBG10P, V4L2_PIX_FMT_SRGGB10P,
    V4L2_PIX_FMT_SBGGR12,  V4L2_PIX_FMT_SGBRG12,  V4L2_PIX_FMT_SGRBG12,  V4L2_PIX_FMT_SRGGB12,
    V4L2_PIX_FMT_SBGGR16,  V4L2_PIX_FMT_SGBRG16,  V4L2_PIX_FMT_SGRBG16,  V4L2_PIX_FMT_SRGGB16};

constexpr std::uint32_t kOtherOrder[] = {
    V4L2_PIX_FMT_YVYU,   V4L2_PIX_FMT_VYUY,   V4L2_PIX_FMT_NV21,    V4L2_PIX_FMT_NV21M,
    V4L2_PIX_FMT_NV16,   V4L2_PIX_FMT_NV61,   V4L2_PIX_FMT_NV16M,   V4L2_PIX_FMT_NV24,
    V4L2_PIX_FMT_YUV420, V4L2_PIX_FMT_YVU420, V4L2_PIX_FMT_YUV420M, V4L2_PIX_FMT_YUV422P,
    V4L2_PIX_FMT_BGR24,  V4L2_PIX_FMT_RGB565, V4L2_PIX_FMT_BGR32,   V4L2_PIX_FMT_RGB32,
    V4L2_PIX_FMT_XBGR32, V4L2_PIX_FMT_XRGB32, V4L2_PIX_FMT_ABGR32,  V4L2_PIX_FMT_ARGB32};

template <std::size_t N>
bool is_in(const std::uint32_t (&list)[N], std::uint32_t fourcc) {
  return std::find(std::begin(list), std::end(list), fourcc) != std::end(list);
}

}  // namespace

std::optional<KnownFormat> known_format(std::uint32_t fourcc) {
  for (const KnownFormat& each : kKnown)
    if (each.fourcc == fourcc) return each;
  return std::nullopt;
}

const char* refusal(std::uint32_t fourcc) {
  if (known_format(fourcc)) return nullptr;
  if (is_in(kCompressed, fourcc)) return "compressed: unpacking takes time and blurs colour";
  if (is_in(kGrey, fourcc)) return "grey: it carries no colour, and targets are found by their hue";
  if (is_in(kDepth, fourcc)) return "depth: it carries no colour, and targets are found by their hue";
  if (is_in(kBayer, fourcc)) return "raw Bayer pattern: its colours are not put together yet";
  if (is_in(kOtherOrder, fourcc)) return "colour in an order that is not read";
  return "unknown";
}

std::array<char, 5> spell(std::uint32_t fourcc) {
  std::array<char, 5> text{};
  for (unsigned i = 0; i < 4; ++i) {
    const std::uint32_t letter = (fourcc >> (8 * i)) & 0xFFU;
    text[i] = letter >= 32 && letter < 127 ? static_cast<char>(letter) : '?';
  }
  return text;
}

}  // namespace vergence::v4l2
