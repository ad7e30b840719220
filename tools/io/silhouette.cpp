#include "tools/io/silhouette.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tools/photo_model/find_target.hpp"
#include "tools/photo_model/plain_background.hpp"

namespace vergence::tools {
namespace {

std::optional<Silhouette> if_some_of(const GreyImage& found, const Rectangle& roi) {
  constexpr double kLeastShare = 0.08;
  constexpr double kLargestShare = 0.98;
  Silhouette silhouette = with_rim(found, roi);
  const auto inside = std::count_if(silhouette.target.data.begin(), silhouette.target.data.end(),
                                    [](auto v) { return v != 0; });
  const double share = static_cast<double>(inside) / (static_cast<double>(roi.width) * roi.height);
  if (share < kLeastShare || share > kLargestShare) return std::nullopt;
  return silhouette;
}

}  // namespace

Silhouette with_rim(const GreyImage& target, const Rectangle& roi) {
  constexpr double kRim = 0.12;  // of the rectangle's mean side
  const GreyImage nothing{target.width_px, target.height_px,
                          std::vector<std::uint8_t>(target.data.size(), 0)};
  Silhouette result{nothing, nothing};
  const int rim_px = std::max(2, static_cast<int>(kRim * 0.5 * (roi.width + roi.height)));
  for (int y = roi.y; y < roi.y + roi.height; ++y) {
    for (int x = roi.x; x < roi.x + roi.width; ++x) {
      const auto i = static_cast<std::size_t>(y * target.width_px + x);
      if (target.data[i] == 0) continue;
      result.target.data[i] = 255;
      for (int v = std::max(roi.y, y - rim_px); v <= std::min(roi.y + roi.height - 1, y + rim_px); ++v) {
        const int half = static_cast<int>(std::sqrt(rim_px * rim_px - (v - y) * (v - y)));
        const auto row = result.with_rim.data.begin() + std::ptrdiff_t{v} * target.width_px;
        std::fill(row + std::max(roi.x, x - half), row + std::min(roi.x + roi.width - 1, x + half) + 1,
                  std::uint8_t{255});
      }
    }
  }
  return result;
}

std::optional<Silhouette> silhouette_before(const RgbImage& background, const RgbImage& photo,
                                            const Rectangle& roi) {
  if (background.width_px != photo.width_px || background.height_px != photo.height_px) return std::nullopt;
  return if_some_of(find_target(photo, background).mask, roi);
}

std::optional<Silhouette> silhouette_before_plain(double hue_deg, const RgbImage& photo,
                                                  const Rectangle& roi) {
  const std::optional<RgbImage> background = plain_background(photo, roi, hue_deg);
  if (!background) return std::nullopt;
  return if_some_of(find_target(photo, *background).mask, roi);
}

}  // namespace vergence::tools
