#include "tests/support/small_dataset.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "algo/camera_model.hpp"
#include "tools/io/image_file.hpp"

namespace vergence::test {
namespace {

using tools::RgbImage;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocalLength_px = 400;
constexpr double kHalfBaseline_mm = 60;
constexpr int kCardWidth = 100;  // px in the photo, at whose distance a pixel is 1 mm
constexpr int kCardHeight = 80;
constexpr int kCardX = 110;
constexpr int kCardY = 80;

constexpr std::uint8_t kBackground[3] = {60, 100, 150};

void paint(RgbImage& image, int x, int y, const std::uint8_t* rgb) {
  std::copy(rgb, rgb + 3, image.at(x, y));
}

// Colour of the card at card pixel (i, j): patches of several sizes.
void card_colour(int i, int j, std::uint8_t* rgb) {
  constexpr std::uint8_t kPaints[6][3] = {{200, 40, 40},  {230, 200, 40}, {40, 160, 60},
                                          {220, 120, 30}, {190, 60, 160}, {120, 200, 60}};
  const int patch = (i / 25) * 5 + (j / 20) * 3 + ((i / 9) * (j / 7)) % 4;
  std::copy(kPaints[patch % 6], kPaints[patch % 6] + 3, rgb);
}

CameraModel camera(bool left) {
  CameraModel camera;
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  camera.fx_px = camera.fy_px = kFocalLength_px;
  camera.cx_px = 0.5 * (kWidth - 1);
  camera.cy_px = 0.5 * (kHeight - 1);
  camera.T_H_C.t_mm = {left ? -kHalfBaseline_mm : kHalfBaseline_mm, 0, 0};
  return camera;
}

RgbImage plain() {
  RgbImage image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) paint(image, x, y, kBackground);
  }
  return image;
}

RgbImage card_photo() {
  RgbImage image = plain();
  for (int j = 0; j < kCardHeight; ++j) {
    for (int i = 0; i < kCardWidth; ++i) card_colour(i, j, image.at(kCardX + i, kCardY + j));
  }
  return image;
}

// The upright card in front of a camera, pixel by pixel.
RgbImage card_image(const CameraModel& camera, const Pose& T_H_M) {
  RgbImage image = plain();
  const Vector3 centre = T_H_M.position_mm - camera.T_H_C.t_mm;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double X = (x - camera.cx_px) * centre[2] / camera.fx_px - centre[0];
      const double Y = (y - camera.cy_px) * centre[2] / camera.fy_px - centre[1];
      const int i = static_cast<int>(std::floor(X + 0.5 * kCardWidth));
      const int j = static_cast<int>(std::floor(Y + 0.5 * kCardHeight));
      if (i >= 0 && j >= 0 && i < kCardWidth && j < kCardHeight) card_colour(i, j, image.at(x, y));
    }
  }
  return image;
}

struct PaintedBall {
  Vector3 centre_mm;
  std::uint8_t rgb[3];
  int hue_deg;
};

const PaintedBall kBalls[] = {
    {{0, 0, 0}, {220, 20, 20}, 0}, {{70, 0, 0}, {20, 200, 20}, 120}, {{0, 70, 0}, {20, 20, 230}, 240}};
constexpr double kBallRadius_mm = 20;

RgbImage ball_image(const CameraModel& camera, const Pose& T_H_M) {
  RgbImage image(kWidth, kHeight);
  image.data.assign(image.data.size(), 90);  // grey: no hue
  for (const PaintedBall& ball : kBalls) {
    const Vector3 p = T_H_M.position_mm + ball.centre_mm - camera.T_H_C.t_mm;
    Vector2 uv;
    if (!project(camera, p, uv)) continue;
    const double radius = camera.fx_px * kBallRadius_mm / p[2];
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if ((Vector2(x, y) - uv).norm() <= radius) paint(image, x, y, ball.rgb);
      }
    }
  }
  return image;
}

void write_common(const std::filesystem::path& directory) {
  for (const char* folder : {"left", "right", "model"})
    std::filesystem::create_directories(directory / folder);
  std::ostringstream rig;
  rig << "[image]\nwidth = " << kWidth << "\nheight = " << kHeight << "\n";
  for (const bool left : {true, false}) {
    const CameraModel c = camera(left);
    rig << (left ? "[left]" : "[right]") << "\nfx = 400.0\nfy = 400.0\ncx = " << c.cx_px
        << "\ncy = " << c.cy_px << "\nT_H_C = [1,0,0," << c.T_H_C.t_mm[0] << ", 0,1,0,0, 0,0,1,0, 0,0,0,1]\n";
  }
  write_file(directory / "rig.toml", rig.str());
  write_file(directory / "search.toml",
             "centre = [0, 0, 500, 0, 0, 0]\nhalf_range = [100, 100, 120, 0.2, 0.2, 0.2]\n");
  std::ostringstream truth;
  truth << "frame,x_mm,y_mm,z_mm,e1,e2,e3\n";
  for (int frame = 0; frame < kSmallFrames; ++frame) {
    const Vector3 p = small_pose(frame).position_mm;
    truth << frame << ',' << p[0] << ',' << p[1] << ',' << p[2] << ",0,0,0\n";
  }
  write_file(directory / "truth.csv", truth.str());
}

template <class Draw>
void write_frames(const std::filesystem::path& directory, Draw&& draw) {
  for (int frame = 0; frame < kSmallFrames; ++frame) {
    const std::string name = "00000" + std::to_string(frame) + ".png";
    write_png(directory / "left" / name, draw(camera(true), small_pose(frame)));
    write_png(directory / "right" / name, draw(camera(false), small_pose(frame)));
  }
}

}  // namespace

TempDirectory::TempDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "vergence-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary directory");
  path_ = name;
}

TempDirectory::~TempDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Pose small_pose(int frame) {
  return {{12.0 + 4 * frame, -9, 480}, Vector3::Zero()};
}

void write_small_photo_dataset(const std::filesystem::path& directory) {
  write_common(directory);
  write_file(directory / "model" / "model.toml",
             "kind = \"photo\"\n[photo]\nimage = \"photo.png\"\nbackground = \"background.png\"\n"
             "roi = [110, 80, 100, 80]\ndistance_mm = 400.0\n"
             "[camera]\nfx = 400.0\nfy = 400.0\ncx = 159.5\ncy = 119.5\n");
  write_png(directory / "model" / "photo.png", card_photo());
  write_png(directory / "model" / "background.png", plain());
  write_frames(directory, card_image);
}

void write_small_marker_dataset(const std::filesystem::path& directory) {
  write_common(directory);
  std::ostringstream model;
  model << "kind = \"marker\"\n";
  for (const PaintedBall& ball : kBalls) {
    model << "[[ball]]\nname = \"ball\"\ncentre_mm = [" << ball.centre_mm[0] << ", " << ball.centre_mm[1]
          << ", 0]\nradius_mm = 20.0\nhue_deg = " << ball.hue_deg << ".0\n";
  }
  write_file(directory / "model" / "model.toml", model.str());
  write_frames(directory, ball_image);
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  std::stringstream content;
  content << in.rdbuf();
  return content.str();
}

void write_file(const std::filesystem::path& file, std::string_view content) {
  // Anew rather than truncated: ext4 flushes what was truncated, and fuzzing writes often.
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  std::ofstream out(file, std::ios::binary);
  out << content;
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

void replace_in_file(const std::filesystem::path& file, std::string_view from, std::string_view to) {
  std::string content = read_file(file);
  const std::size_t at = content.find(from);
  if (at == std::string::npos) throw std::runtime_error(file.string() + " has no " + std::string(from));
  content.replace(at, from.size(), to);
  write_file(file, content);
}

}  // namespace vergence::test
