// Pictures for calibration: both kinds of files, both ways to name pairs.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include <jpeglib.h>  // after cstdio, which it needs

#include "tests/support/small_dataset.hpp"
#include "tools/calibrate/picture_file.hpp"
#include "tools/calibrate/picture_pairs.hpp"
#include "tools/io/input_error.hpp"

namespace vergence::test {
namespace {

using tools::GreyImage;

GreyImage slope(int width, int height) {
  GreyImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.data.push_back(static_cast<std::uint8_t>(2 * x + y));
  }
  return image;
}

// As a file in memory; grey, or the same level in all three colours.
std::string jpeg_of(const GreyImage& image, bool colour) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  jpeg_mem_dest(&jpeg, &bytes, &count);
  jpeg.image_width = static_cast<JDIMENSION>(image.width_px);
  jpeg.image_height = static_cast<JDIMENSION>(image.height_px);
  jpeg.input_components = colour ? 3 : 1;
  jpeg.in_color_space = colour ? JCS_RGB : JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < image.height_px; ++y) {
    std::string line;
    for (int x = 0; x < image.width_px; ++x)
      line.append(colour ? 3 : 1,
                  static_cast<char>(image.data[static_cast<std::size_t>(y * image.width_px + x)]));
    auto* row = reinterpret_cast<JSAMPROW>(line.data());
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string file(reinterpret_cast<const char*>(bytes), count);
  std::free(bytes);
  return file;
}

TEST(CalibratePicture, OfEitherKindIsRead) {
  const TempDirectory directory;
  const GreyImage image = slope(70, 50);
  write_png(directory / "a.png", image);
  EXPECT_EQ(calibrate::read_picture(directory / "a.png").data, image.data);
  for (const bool colour : {false, true}) {
    write_file(directory / "a.JPG", jpeg_of(image, colour));
    const GreyImage back = calibrate::read_picture(directory / "a.JPG");
    ASSERT_EQ(back.width_px, 70);
    ASSERT_EQ(back.height_px, 50);
    for (std::size_t i = 0; i < image.data.size(); ++i) ASSERT_NEAR(back.data[i], image.data[i], 4);
  }
}

TEST(CalibratePicture, ThatIsDamagedIsRefused) {
  const TempDirectory directory;
  const std::string whole = jpeg_of(slope(70, 50), false);
  for (const std::size_t kept :
       {std::size_t{0}, std::size_t{3}, whole.size() / 4, whole.size() / 2, whole.size() - 9}) {
    write_file(directory / "a.jpg", whole.substr(0, kept));
    EXPECT_THROW((void)calibrate::read_picture(directory / "a.jpg"), tools::InputError) << kept;
  }
  EXPECT_THROW((void)calibrate::read_picture(directory / "none.jpg"), tools::InputError);
  EXPECT_THROW((void)calibrate::read_picture(directory / "none.png"), tools::InputError);
}

TEST(CalibratePicture, PairsAreFoundInFoldersAndFlat) {
  const TempDirectory directory;
  for (const char* name :
       {"left01.jpg", "left11.jpg", "right01.jpg", "right11.jpg", "left.txt", "leftover.png"})
    write_file(directory / name, "");
  const auto flat = calibrate::list_pairs(directory.path());
  ASSERT_EQ(flat.size(), 2U);
  EXPECT_EQ(flat[1].number, 11);
  EXPECT_EQ(flat[1].files[1].filename(), "right11.jpg");
  for (const char* side : {"left", "right"}) {
    std::filesystem::create_directory(directory / side);
    write_file(directory / side / "000007.png", "");
  }
  const auto in_folders = calibrate::list_pairs(directory.path());
  ASSERT_EQ(in_folders.size(), 1U);
  EXPECT_EQ(in_folders[0].number, 7);
}

}  // namespace
}  // namespace vergence::test
