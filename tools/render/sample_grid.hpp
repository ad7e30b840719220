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
#include "tools/render/mesh.hpp"

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
  void add(const Corner& a, const Corner& b, const Corner& c, Turn turn, bool target, const Colours& colours);

  // Over what is behind; ends the picture.
  void resolve(LinearImage& image, Visibility* visibility);

 private:
  struct Seen {
    Rgb colour;
    bool target = false;
  };
  // Every pattern has one sample in each of as many rows as it has samples, evenly spaced.
  struct Row {
    double x;  // from the pixel's centre
    double y;
    // Added to the ends of a span and cut to whole numbers: the pixels whose sample may lie in it.
    double to_first;
    double to_last;
    std::size_t sample;  // which of the pattern
  };
  static constexpr std::size_t kMost = 16;

  static double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }
  static int floor_of(double v) { return static_cast<int>(std::floor(v)); }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - y0_) * stride_ + (static_cast<std::size_t>(x - x0_) << shift_);
  }

  int x0_ = 0;
  int y0_ = 0;
  int x1_ = 0;
  int y1_ = 0;
  // Beyond these nothing is on the grid, and numbers stay small.
  double low_x_ = 0;
  double low_y_ = 0;
  double high_x_ = 0;
  double high_y_ = 0;
  std::size_t stride_ = 0;         // samples of a row of pixels
  std::size_t samples_ = 4;        // of a pixel
  int shift_ = 2;                  // two to the power of it are `samples_`
  std::array<Row, kMost> rows_{};  // from top to bottom
  // As `to_first` and `to_last`, of rows.
  double to_first_row_ = 0;
  double to_last_row_ = 0;
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
void SampleGrid::add(const Corner& a, const Corner& b, const Corner& c, Turn turn, bool target,
                     const Colours& colours) {
  const double area = cross(b.uv_px - a.uv_px, c.uv_px - a.uv_px);
  if (area == 0 || turn == (area < 0 ? Turn::kRight : Turn::kLeft)) return;
  const double left = std::min(std::min(a.uv_px[0], b.uv_px[0]), c.uv_px[0]);
  const double right = std::max(std::max(a.uv_px[0], b.uv_px[0]), c.uv_px[0]);
  const double top = std::min(std::min(a.uv_px[1], b.uv_px[1]), c.uv_px[1]);
  const double bottom = std::max(std::max(a.uv_px[1], b.uv_px[1]), c.uv_px[1]);
  if (right < low_x_ || left > high_x_ || bottom < low_y_ || top > high_y_) return;

  // Rounding moves the edges of a sound triangle by less than 1e-6 px, and its depths by less than 1e-6 of
  // them: samples further off need not be tried. Of a sliver nothing is taken for granted; the pixels tried
  // are those it reaches into.
  const double size = right - left + bottom - top + 2;
  const bool sound = size * size * size < 1e9 * std::abs(area);
  const auto n = static_cast<int>(samples_);
  int min_x = x0_;
  int max_x = x1_ - 1;
  int from_row = n * y0_;
  int to_row = n * y1_ - 1;
  double first_x = std::max(left, low_x_);
  double last_x = std::min(right, high_x_);
  if (sound) {
    from_row = std::max(from_row, static_cast<int>(n * std::max(top, low_y_) + to_first_row_));
    to_row = std::min(to_row, static_cast<int>(n * std::min(bottom, high_y_) + to_last_row_));
  } else {
    min_x = std::max(min_x, floor_of(std::max(left, low_x_) + 0.5));
    max_x = std::min(max_x, floor_of(std::min(right, high_x_) + 0.5));
    from_row = std::max(from_row, n * floor_of(std::max(top, low_y_) + 0.5));
    to_row = std::min(to_row, n * floor_of(std::min(bottom, high_y_) + 0.5) + n - 1);
    first_x = min_x - 1.0;
    last_x = max_x + 1.0;
  }

  const auto nearest =
      sound ? static_cast<float>(std::max(std::max(a.inverse_depth, b.inverse_depth), c.inverse_depth) *
                                 (1 + 1e-5))
            : std::numeric_limits<float>::infinity();
  const double scale = 1 / area;
  const Vector2 bc = c.uv_px - b.uv_px;
  const Vector2 ca = a.uv_px - c.uv_px;
  const Rgb* corner_colours[3] = {};
  for (int i = from_row; i <= to_row; ++i) {
    const Row& row = rows_[static_cast<std::size_t>(i) & (samples_ - 1)];
    const int row_from = std::max(min_x, static_cast<int>(first_x + row.to_first));
    const int row_to = std::min(max_x, static_cast<int>(last_x + row.to_last));
    if (row_from > row_to) continue;
    const int y = i >> shift_;
    std::size_t at = index(row_from, y) + row.sample;
    for (int x = row_from; x <= row_to; ++x, at += samples_) {
      if (nearest <= inverse_depth_[at]) continue;
      const double py = y + row.y;
      const double px = x + row.x;
      const double wa = (bc[0] * (py - b.uv_px[1]) - bc[1] * (px - b.uv_px[0])) * scale;
      const double wb = (ca[0] * (py - c.uv_px[1]) - ca[1] * (px - c.uv_px[0])) * scale;
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
}

}  // namespace vergence::render
