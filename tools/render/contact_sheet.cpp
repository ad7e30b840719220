#include "tools/render/contact_sheet.hpp"

#include <algorithm>

#include "tools/render/creatures.hpp"

namespace vergence::render {
namespace {

constexpr int kColumns = 3;  // creatures a row
constexpr int kGap_px = 4;

// Each pixel the mean of shrink x shrink.
void paste(const tools::RgbImage& image, int shrink, int x0, int y0, tools::RgbImage& sheet) {
  for (int y = 0; y < image.height_px / shrink; ++y) {
    for (int x = 0; x < image.width_px / shrink; ++x) {
      for (int k = 0; k < 3; ++k) {
        int sum = 0;
        for (int i = 0; i < shrink * shrink; ++i)
          sum += image.at(x * shrink + i % shrink, y * shrink + i / shrink)[k];
        sheet.at(x0 + x, y0 + y)[k] = static_cast<std::uint8_t>(sum / (shrink * shrink));
      }
    }
  }
}

}  // namespace

tools::RgbImage contact_sheet(const std::filesystem::path& scene_file, SceneOverrides overrides, int shrink) {
  tools::RgbImage sheet;
  int place = 0;
  for (const Creature& creature : creatures()) {
    overrides.target = std::string(creature.code);
    const Scene scene = load_scene(scene_file, overrides);
    tools::RgbImage left;
    render_eye(scene, state_at(scene, 0), Eye::kLeft, scene.seed, left);
    const tools::RgbImage photo = take_model_photo(scene).photo;
    const int width = (std::max(photo.width_px, left.width_px) / shrink) + kGap_px;
    const int height = (std::max(photo.height_px, left.height_px) / shrink) + kGap_px;
    if (place == 0) {
      const int rows = (static_cast<int>(creatures().size()) + kColumns - 1) / kColumns;
      sheet = tools::RgbImage(kColumns * 2 * width, rows * height);
      std::fill(sheet.data.begin(), sheet.data.end(), std::uint8_t{255});
    }
    const int x = place % kColumns * 2 * width;
    const int y = place / kColumns * height;
    paste(photo, shrink, x, y, sheet);
    paste(left, shrink, x + width, y, sheet);
    ++place;
  }
  return sheet;
}

}  // namespace vergence::render
