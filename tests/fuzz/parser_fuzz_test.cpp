// Whatever is in a file, its reader gives a value or an InputError: no crash, no other exception.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>

#include "tests/fuzz/mutator.hpp"
#include "tests/support/small_dataset.hpp"
#include "tools/io/csv.hpp"
#include "tools/io/dataset.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/toml_reader.hpp"

namespace vergence::test {
namespace {

using std::filesystem::path;

constexpr int kMutations = 3000;

struct Outcomes {
  int accepted = 0;
  int refused = 0;
};

// Damages `file` again and again and reads it; every accepted value must satisfy the checks within `read`.
Outcomes fuzz(const path& file, int mutations, const std::function<void()>& read) {
  const std::string good = read_file(file);
  read();
  Outcomes outcomes;
  Mutator mutator(2026);
  for (int i = 0; i < mutations; ++i) {
    const std::string damaged = mutator.mutate(good);
    write_file(file, damaged);
    try {
      read();
      ++outcomes.accepted;
    } catch (const tools::InputError&) {
      ++outcomes.refused;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "mutation " << i << ": " << error.what() << "\n" << damaged;
      break;
    }
  }
  write_file(file, good);
  return outcomes;
}

void expect_both(const Outcomes& outcomes) {
  EXPECT_GT(outcomes.accepted, 0);
  EXPECT_GT(outcomes.refused, outcomes.accepted / 10);
}

tools::RgbImage colourful(int width, int height) {
  tools::RgbImage image(width, height);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<std::uint8_t>(60 + i * 37 % 150);
  return image;
}

TEST(ParserFuzz, Rig) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  expect_both(fuzz(directory / "rig.toml", kMutations, [&] {
    const StereoRig rig = tools::read_rig(directory / "rig.toml");
    for (const CameraModel& camera : {rig.left, rig.right}) {
      ASSERT_GT(camera.fx_px, 0);
      ASSERT_GT(camera.width_px, 0);
      ASSERT_LE(camera.width_px, kMaxImageWidth);
      ASSERT_TRUE(std::isfinite(camera.cx_px + camera.cy_px + camera.T_H_C.t_mm.sum()));
      ASSERT_LT((camera.T_H_C.R * camera.T_H_C.R.transpose() - Matrix3::Identity()).norm(), 1e-9);
    }
  }));
}

TEST(ParserFuzz, SearchBox) {
  const TempDirectory directory;
  write_small_photo_dataset(directory.path());
  expect_both(fuzz(directory / "search.toml", kMutations, [&] {
    ASSERT_EQ(check(tools::read_search_box(directory / "search.toml")), Status::kOk);
  }));
}

TEST(ParserFuzz, MarkerModel) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  expect_both(fuzz(directory / "model/model.toml", kMutations, [&] {
    tools::Dataset dataset;
    dataset.target = tools::read_target(directory / "model");
    if (dataset.target.kind == TargetKind::kPhoto) return;
    MarkerModel model;
    tools::build_model(dataset, {}, model);
    ASSERT_GT(model.balls, 0);
  }));
}

TEST(ParserFuzz, PhotoModel) {
  const TempDirectory directory;
  write_file(directory / "model.toml",
             "kind = \"photo\"\n[photo]\nimage = \"photo.png\"\nbackground = \"background.png\"\n"
             "roi = [4, 4, 16, 16]\ndistance_mm = 400.0\nmask = \"photo.png\"\n"
             "[camera]\nfx = 400.0\nfy = 400.0\ncx = 12\ncy = 12\n");
  write_png(directory / "photo.png", colourful(24, 24));
  write_png(directory / "background.png", colourful(8, 8));
  const auto model = std::make_unique<PhotoModel>();
  expect_both(fuzz(directory / "model.toml", kMutations, [&] {
    tools::Dataset dataset;
    dataset.target = tools::read_target(directory.path());
    if (dataset.target.kind == TargetKind::kMarker) return;
    PhotoOptions options;
    options.points = 60;
    tools::build_model(dataset, options, {}, *model);
    ASSERT_GT(model->inner, 0);
    for (unsigned i = 0; i < static_cast<unsigned>(model->points()); ++i)
      ASSERT_TRUE(std::isfinite(model->x_mm[i]));
  }));
}

TEST(ParserFuzz, Csv) {
  const TempDirectory directory;
  const path file = directory / "truth.csv";
  write_file(file, "frame,t_s,x_mm\r\n0, 0.5, 1.5e2\n\n1,0.7,-3\n");
  expect_both(fuzz(file, kMutations, [&] {
    for (const tools::CsvRow& row : tools::read_csv(file).rows) {
      for (const double value : row.values) ASSERT_TRUE(std::isfinite(value));
    }
  }));
}

TEST(ParserFuzz, TruthAndMotionOfADataset) {
  const TempDirectory directory;
  write_small_marker_dataset(directory.path());
  write_file(directory / "motion.csv",
             "frame,x_mm,y_mm,z_mm,e1,e2,e3,tilt_rad,pan_right_rad,pan_left_rad\n"
             "0,1,2,3,0,0,0,0,0,0\n1,1,2,3,0,0,0,0,0.3,0.2\n2,1,2,3,0,0,0,0.1,0,0\n");
  for (const char* name : {"truth.csv", "motion.csv"}) {
    expect_both(fuzz(directory / name, kMutations / 3, [&] {
      const tools::Dataset dataset = tools::read_dataset(directory.path());
      for (const tools::Frame& frame : dataset.frames) {
        const FrameMotion motion = dataset.motion_of(frame.number);
        ASSERT_TRUE(is_valid(to_pose(motion.T_W_H)));
        ASSERT_TRUE(is_valid(to_pose(motion.T_H_CL)));
      }
    }));
  }
}

// CRC-32 of PNG chunks, so that damage gets past it.
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320U : 0);
  }
  return ~crc;
}

std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
          static_cast<char>(value)};
}

constexpr std::size_t kHeader = 12;        // of the IHDR chunk's type, in the file
constexpr std::size_t kHeaderLength = 17;  // type and data

void mend_header_crc(std::string& png) {
  if (png.size() < kHeader + kHeaderLength + 4) return;
  png.replace(kHeader + kHeaderLength, 4,
              big_endian(crc32(std::string_view(png).substr(kHeader, kHeaderLength))));
}

TEST(ParserFuzz, Png) {
  const TempDirectory directory;
  const path file = directory / "image.png";
  write_png(file, colourful(9, 7));
  const auto outcomes = fuzz(file, kMutations, [&] {
    const tools::RgbImage image = tools::read_png_rgb(file);
    ASSERT_EQ(image.data.size(), static_cast<std::size_t>(image.width_px * image.height_px) * 3);
    ASSERT_EQ(tools::read_png_grey(file).data.size() * 3, image.data.size());
  });
  EXPECT_GT(outcomes.refused, 0);
}

TEST(ParserFuzz, PngHeadersWithGoodChecksums) {
  const TempDirectory directory;
  const path file = directory / "image.png";
  write_png(file, colourful(9, 7));
  const std::string good = read_file(file);
  Mutator mutator(7);
  int refused = 0;
  for (int i = 0; i < kMutations; ++i) {
    std::string damaged = good;
    // Width, height, bit depth, colour type, compression, filter, interlace.
    const std::size_t at = kHeader + 4 + mutator.below(13);
    damaged[at] = static_cast<char>(mutator.below(256));
    mend_header_crc(damaged);
    write_file(file, damaged);
    try {
      static_cast<void>(tools::read_png_rgb(file));
    } catch (const tools::InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, kMutations / 2);
}

TEST(ParserFuzz, AGiganticPngIsRefusedBeforeMemoryIsAsked) {
  const TempDirectory directory;
  const path file = directory / "image.png";
  write_png(file, colourful(9, 7));
  std::string png = read_file(file);
  png.replace(kHeader + 4, 8, big_endian(900'000) + big_endian(900'000));
  mend_header_crc(png);
  write_file(file, png);
  try {
    static_cast<void>(tools::read_png_rgb(file));
    FAIL() << "accepted";
  } catch (const tools::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("900000 x 900000"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vergence::test
