#include "tools/calibrate/picture_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <string>

#include <jpeglib.h>  // after cstdio, which it needs

#include "tools/io/input_error.hpp"

namespace vergence::calibrate {
namespace {

std::string ending(const std::filesystem::path& file) {
  std::string text = file.extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// libjpeg reports an error by a function that must not return.
struct JpegErrors {
  jpeg_error_mgr manager;  // first: libjpeg knows only this part
  std::jmp_buf back;
  std::array<char, JMSG_LENGTH_MAX> message;
};

void leave(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  errors->manager.format_message(jpeg, errors->message.data());
  std::longjmp(errors->back, 1);
}

// A warning is damage as well: libjpeg fills what is missing of a truncated file with grey.
void judge_message(j_common_ptr jpeg, int level) {
  if (level < 0) leave(jpeg);
}

// False, with a message in `errors`, where it is not a good JPEG. Nothing with a destructor is made in here:
// an error jumps out.
bool decode(std::FILE* file, jpeg_decompress_struct& jpeg, JpegErrors& errors, tools::GreyImage& image) {
  if (setjmp(errors.back) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_stdio_src(&jpeg, file);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  image.width_px = static_cast<int>(jpeg.output_width);
  image.height_px = static_cast<int>(jpeg.output_height);
  image.data.resize(static_cast<std::size_t>(jpeg.output_width) * jpeg.output_height);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = image.data.data() + static_cast<std::size_t>(jpeg.output_scanline) * jpeg.output_width;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

tools::GreyImage read_jpeg(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (file == nullptr) throw tools::InputError(path, "", "no such image", "expected a JPEG file there");
  JpegErrors errors{};
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = leave;
  errors.manager.emit_message = judge_message;
  tools::GreyImage image;
  const bool good = decode(file.get(), jpeg, errors, image);
  jpeg_destroy_decompress(&jpeg);
  if (!good) {
    throw tools::InputError(path, "", std::string("not a readable JPEG: ") + errors.message.data(),
                            "copy it again, or leave the pair out");
  }
  return image;
}

}  // namespace

bool is_picture(const std::filesystem::path& file) {
  const std::string end = ending(file);
  return end == ".png" || end == ".jpg" || end == ".jpeg";
}

tools::GreyImage read_picture(const std::filesystem::path& file) {
  return ending(file) == ".png" ? tools::read_png_grey(file) : read_jpeg(file);
}

}  // namespace vergence::calibrate
