// RGB and grey images in memory, and PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "algo/image.hpp"

namespace vergence::tools {

struct RgbImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> data;  // r g b, rows packed

  RgbImage() = default;
  RgbImage(int width, int height)
      : width_px(width),
        height_px(height),
        data(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3) {}

  [[nodiscard]] std::uint8_t* at(int x, int y) {
    return &data[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
                  static_cast<std::size_t>(x)) *
                 3];
  }
  [[nodiscard]] const std::uint8_t* at(int x, int y) const {
    return &data[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
                  static_cast<std::size_t>(x)) *
                 3];
  }
  [[nodiscard]] ImageView view() const {
    return {data.data(),         width_px, height_px, static_cast<std::size_t>(width_px) * 3,
            PixelFormat::kRgb24, nullptr,  0};
  }
};

struct GreyImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> data;  // rows packed
};

// 8-bit images of any PNG colour type are converted. Throws InputError (missing, unreadable, not a PNG,
// empty).
[[nodiscard]] RgbImage read_png_rgb(const std::filesystem::path& file);
[[nodiscard]] GreyImage read_png_grey(const std::filesystem::path& file);

// Throws InputError where the file cannot be written.
void write_png(const std::filesystem::path& file, const RgbImage& image);
void write_png(const std::filesystem::path& file, const GreyImage& image);

}  // namespace vergence::tools
