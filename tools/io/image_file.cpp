#include "tools/io/image_file.hpp"

#include <png.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "tools/io/input_error.hpp"

namespace vergence::tools {
namespace {

constexpr png_uint_32 kMaxSide = 8192;  // far more than any camera here has

void read_png(const std::filesystem::path& file, png_uint_32 format, int& width, int& height,
              std::vector<std::uint8_t>& data) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    throw InputError(file, "", "no such image", "expected a PNG file there");
  }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, file.c_str()) == 0) {
    throw InputError(file, "", std::string("not a readable PNG: ") + png.message);
  }
  if (png.width > kMaxSide || png.height > kMaxSide) {
    const std::string size = std::to_string(png.width) + " x " + std::to_string(png.height);
    png_image_free(&png);
    throw InputError(file, "", "is " + size + " pixels large",
                     "at most " + std::to_string(kMaxSide) + " a side");
  }
  png.format = format;
  data.resize(PNG_IMAGE_SIZE(png));
  width = static_cast<int>(png.width);
  height = static_cast<int>(png.height);
  if (png_image_finish_read(&png, nullptr, data.data(), 0, nullptr) == 0) {
    throw InputError(file, "", std::string("damaged PNG: ") + png.message);
  }
}

void write_png(const std::filesystem::path& file, png_uint_32 format, int width, int height,
               const std::vector<std::uint8_t>& data) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(width);
  png.height = static_cast<png_uint_32>(height);
  png.format = format;
  png.flags = PNG_IMAGE_FLAG_FAST;  // a quarter of the time for 1.7 times the size, with camera noise
  if (png_image_write_to_file(&png, file.c_str(), 0, data.data(), 0, nullptr) == 0) {
    throw InputError(file, "", std::string("cannot write: ") + png.message);
  }
}

}  // namespace

RgbImage read_png_rgb(const std::filesystem::path& file) {
  RgbImage image;
  read_png(file, PNG_FORMAT_RGB, image.width_px, image.height_px, image.data);
  return image;
}

GreyImage read_png_grey(const std::filesystem::path& file) {
  GreyImage image;
  read_png(file, PNG_FORMAT_GRAY, image.width_px, image.height_px, image.data);
  return image;
}

void write_png(const std::filesystem::path& file, const RgbImage& image) {
  write_png(file, PNG_FORMAT_RGB, image.width_px, image.height_px, image.data);
}

void write_png(const std::filesystem::path& file, const GreyImage& image) {
  write_png(file, PNG_FORMAT_GRAY, image.width_px, image.height_px, image.data);
}

}  // namespace vergence::tools
