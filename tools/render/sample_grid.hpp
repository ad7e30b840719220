// The samples of a rectangle of pixels: which triangle each of them sees, and in what colour.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "algo/pose.hpp"
#include "tools/render/colour_math.hpp"
#include "tools/render/linear_image.hpp"

namespace vergence::render {

// Samples of a pixel: a rotated grid of 4, an eight-rooks pattern of 8, or 16. Their mean is the pixel's
// centre.
enum class Sampling {
  k4 = 4,
  k8 = 8,
  k16 = 16,
};

// What the camera sees of the target, per pixel.
struct Visibility {
  std::vector<float> coverage;  // share of the pixel's samples on the target
  std::vector<float> depth_mm;  // their mean depth; 0 where none
};

// Of a triangle, in the picture.
struct Corner {
  Vector2 uv_px = Vector2::Zero();
  double inverse_depth = 0;  // 0: not drawn
};

class SampleGrid {
 public:
  // The pixels [x0, x1) x [y0, y1).
  void start(int x0, int y0, int x1, int y1, Sampling sampling);

  // `colours()`, the three corners', is asked for only where the triangle is seen.
  template <typename Colours>
  void add(const Corner& a, const Corner& b, const Corner& c, bool target, const Colours& colours);

  // Over what is behind; ends the picture.
  void resolve(LinearImage& image, Visibility* visibility);

 private:
  struct Seen {
    Rgb colour;
    bool target = false;
  };
  // Every pattern has one sample in each of as many rows as it has samples, evenly spaced: its place from the
  // pixel's centre, and which of the pattern it is.
  struct Row {
    double x;
    double y;
    std::size_t sample;
  };

  static double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }
  static int floor_of(double v) { return static_cast<int>(std::floor(v)); }
  static int ceil_of(double v) { return static_cast<int>(std::ceil(v)); }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return (static_cast<std::size_t>(y - y0_) * static_cast<std::size_t>(x1_ - x0_) +
            static_cast<std::size_t>(x - x0_)) *
           rows_.size();
  }

  int x0_ = 0;
  int y0_ = 0;
  int x1_ = 0;
  int y1_ = 0;
  std::vector<Row> rows_;  // from top to bottom
  // Pixel by pixel. The depth is apart, as most triangles end there; between pictures it is 0 throughout.
  std::vector<float> inverse_depth_;
  std::vector<Seen> seen_;
  // The pixels of each row that may have been drawn on.
  struct Span {
    int from;
    int to;
  };
  std::vector<Span> drawn_;
};

template <typename Colours>
void SampleGrid::add(const Corner& a, const Corner& b, const Corner& c, bool target, const Colours& colours) {
  const double area = cross(b.uv_px - a.uv_px, c.uv_px - a.uv_px);
  if (area == 0) return;
  const double left = std::min(std::min(a.uv_px[0], b.uv_px[0]), c.uv_px[0]);
  const double right = std::max(std::max(a.uv_px[0], b.uv_px[0]), c.uv_px[0]);
  const double top = std::min(std::min(a.uv_px[1], b.uv_px[1]), c.uv_px[1]);
  const double bottom = std::max(std::max(a.uv_px[1], b.uv_px[1]), c.uv_px[1]);
  if (right < x0_ - 1 || left > x1_ || bottom < y0_ - 1 || top > y1_) return;
  const int from_x = std::max(x0_, floor_of(left + 0.5));
  const int to_x = std::min(x1_ - 1, floor_of(right + 0.5));
  const int from_y = std::max(y0_, floor_of(top + 0.5));
  const int to_y = std::min(y1_ - 1, floor_of(bottom + 0.5));

  // Rounding moves the edges of a sound triangle by less than 1e-6 px, and its depths by less than 1e-6 of
  // them. Of a sliver nothing is taken for granted: every sample of these pixels is tried.
  const double size = right - left + bottom - top + 2;
  const bool sound = size * size * size < 1e9 * std::abs(area);
  const double slack = sound ? 1e-4 : 2;  // px
  const auto n = static_cast<int>(rows_.size());
  const double middle = (n - 1) / 2.0;
  const int from_row = std::max(n * from_y, ceil_of(n * (std::max(top, from_y - 1.0) - slack) + middle));
  const int to_row =
      std::min(n * to_y + n - 1, floor_of(n * (std::min(bottom, to_y + 1.0) + slack) + middle));
  const double first_x = std::max(left, from_x - 1.0) - slack;
  const double last_x = std::min(right, to_x + 1.0) + slack;

  const double scale = 1 / area;
  const Vector2 bc = c.uv_px - b.uv_px;
  const Vector2 ca = a.uv_px - c.uv_px;
  const auto nearest =
      sound ? static_cast<float>(std::max(std::max(a.inverse_depth, b.inverse_depth), c.inverse_depth) *
                                 (1 + 1e-5))
            : std::numeric_limits<float>::infinity();
  const Rgb* corner_colours[3] = {};
  int y = from_row / n;
  auto row = rows_.begin() + from_row % n;
  for (int i = from_row; i <= to_row; ++i) {
    const int row_from = std::max(from_x, ceil_of(first_x - row->x));
    const int row_to = std::min(to_x, floor_of(last_x - row->x));
    if (row_from <= row_to) {
      const double py = y + row->y;
      const double wa_y = bc[0] * (py - b.uv_px[1]);
      const double wb_y = ca[0] * (py - c.uv_px[1]);
      std::size_t at = index(row_from, y) + row->sample;
      for (int x = row_from; x <= row_to; ++x, at += rows_.size()) {
        if (nearest <= inverse_depth_[at]) continue;
        const double px = x + row->x;
        const double wa = (wa_y - bc[1] * (px - b.uv_px[0])) * scale;
        const double wb = (wb_y - ca[1] * (px - c.uv_px[0])) * scale;
        const double wc = 1 - wa - wb;
        if (!((wa >= 0) & (wb >= 0) & (wc >= 0))) continue;
        const auto depth =
            static_cast<float>(wa * a.inverse_depth + wb * b.inverse_depth + wc * c.inverse_depth);
        if (!(depth > inverse_depth_[at])) continue;
        if (corner_colours[0] == nullptr) colours(corner_colours);
        // Weights on the surface, not on the image.
        const auto s = 1 / depth;
        const float ka = static_cast<float>(wa * a.inverse_depth) * s;
        const float kb = static_cast<float>(wb * b.inverse_depth) * s;
        const float kc = static_cast<float>(wc * c.inverse_depth) * s;
        inverse_depth_[at] = depth;
        seen_[at] = {*corner_colours[0] * ka + *corner_colours[1] * kb + *corner_colours[2] * kc, target};
        Span& drawn = drawn_[static_cast<std::size_t>(y - y0_)];
        drawn = {std::min(drawn.from, x), std::max(drawn.to, x + 1)};
      }
    }
    if (++row == rows_.end()) {
      row = rows_.begin();
      ++y;
    }
  }
}

}  // namespace vergence::render
