// The photo-model from a photograph: which points of the target plane, in which order, with which colours.
#include <cmath>

#include "algo/backdrop.hpp"
#include "algo/colour.hpp"
#include "algo/target_model.hpp"

namespace vergence {
namespace {

// A square grid of sample pixels over the rectangle and the strip around it.
struct Grid {
  double step_px;
  int margin;  // cells of strip on each side
  int columns;
  int rows;
  const PhotoSource* source;
  double strip_px;

  [[nodiscard]] int column_px(int i) const { return place(source->roi.x, source->roi.width, columns, i); }
  [[nodiscard]] int row_px(int j) const { return place(source->roi.y, source->roi.height, rows, j); }

 private:
  // Cells are centred on the rectangle; the result may lie beside the photo.
  [[nodiscard]] int place(int first, int length, int cells, int i) const {
    const double centre = first + 0.5 * (length - 1);
    return static_cast<int>(std::floor(centre + (i - 0.5 * (cells - 1)) * step_px + 0.5));
  }
};

bool in_rectangle(const Rectangle& r, int x, int y) {
  return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
}

bool on_target(const PhotoSource& source, int x, int y) {
  if (!in_rectangle(source.roi, x, y)) return false;
  return source.mask == nullptr || source.mask[y * source.photo.width_px + x] != 0;
}

// Beside the target, but no farther from it than the strip is wide.
bool in_strip(const PhotoSource& source, int x, int y, double strip_px) {
  if (on_target(source, x, y)) return false;
  const int reach = static_cast<int>(strip_px);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy <= strip_px * strip_px && on_target(source, x + dx, y + dy)) return true;
    }
  }
  return false;
}

Grid make_grid(const PhotoSource& source, double step_px, double strip_px) {
  const int margin = static_cast<int>(std::ceil(strip_px / step_px));
  const auto cells = [&](int length) {
    const int inside = static_cast<int>(std::floor(length / step_px));
    return (inside < 1 ? 1 : inside) + 2 * margin;
  };
  return {step_px, margin, cells(source.roi.width), cells(source.roi.height), &source, strip_px};
}

enum class Place : std::uint8_t {
  kNowhere,
  kInner,
  kOuter
};

Place classify(const Grid& grid, int i, int j) {
  const int x = grid.column_px(i);
  const int y = grid.row_px(j);
  if (on_target(*grid.source, x, y)) return Place::kInner;
  return in_strip(*grid.source, x, y, grid.strip_px) ? Place::kOuter : Place::kNowhere;
}

int count_points(const Grid& grid) {
  int count = 0;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) count += classify(grid, i, j) != Place::kNowhere ? 1 : 0;
  }
  return count;
}

// Cell number `index` of the Hilbert curve over a square of `side` (a power of two) cells.
void hilbert_cell(int side, std::int64_t index, int& x, int& y) {
  x = 0;
  y = 0;
  for (int s = 1; s < side; s *= 2) {
    const int rx = static_cast<int>(1 & (index / 2));
    const int ry = static_cast<int>(1 & (index ^ rx));
    if (ry == 0) {
      if (rx == 1) {
        x = s - 1 - x;
        y = s - 1 - y;
      }
      const int swap = x;
      x = y;
      y = swap;
    }
    x += s * rx;
    y += s * ry;
    index /= 4;
  }
}

int greatest_common_divisor(int a, int b) {
  while (b != 0) {
    const int rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

// A stride near n / golden ratio without common divisor: visiting every stride-th point of a curve, around
// and around, spreads every leading part evenly along the curve, and so over the plane.
int golden_stride(int n) {
  int stride = static_cast<int>(n * 0.6180339887498949);
  if (stride < 1) stride = 1;
  while (greatest_common_divisor(n, stride) != 1) ++stride;
  return stride;
}

const std::uint8_t* pixel(const ImageView& photo, int x, int y) {
  return photo.data + static_cast<std::size_t>(y) * photo.stride_bytes + static_cast<std::size_t>(x) * 3;
}

bool shows_background(const PhotoSource& source, int x, int y) {
  return source.target != nullptr && source.target[y * source.photo.width_px + x] == 0;
}

struct Square {
  YCbCr colour{};      // mean
  YCbCr behind{};      // mean of what is not of the target
  std::uint8_t share;  // of 255, that is not
};

// The size x size pixels around (x, y), as far as they lie in the photo. From size 4 on it is
// centred on the pixel: the outermost of size + 1 count half. At size 2 that would blur the photo half as
// much again as cameras' images are when they are halved, which led alignment astray; there it is the pixel
// and those after it.
Square look_at_square(const PhotoSource& source, int x, int y, int size) {
  const ImageView& photo = source.photo;
  const int reach = size / 2;
  const auto weight = [&](int d) {
    if (size <= 2) return d < 0 ? 0 : 2;
    return d == reach || d == -reach ? 1 : 2;
  };
  struct {
    int sum[3] = {0, 0, 0};
    int count = 0;
  } all, behind;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const int px = x + dx;
      const int py = y + dy;
      if (px < 0 || py < 0 || px >= photo.width_px || py >= photo.height_px) continue;
      const std::uint8_t* rgb = pixel(photo, px, py);
      const int w = weight(dx) * weight(dy);
      const auto add = [&](auto& to) {
        for (int c = 0; c < 3; ++c) to.sum[c] += w * rgb[c];
        to.count += w;
      };
      add(all);
      if (shows_background(source, px, py)) add(behind);
    }
  }
  const auto mean = [](const auto& of) {
    const int count = of.count > 0 ? of.count : 1;
    const auto channel = [&](int c) { return (2 * of.sum[c] + count) / (2 * count); };
    return ycbcr_from_rgb(channel(0), channel(1), channel(2));
  };
  return {mean(all), mean(behind),
          static_cast<std::uint8_t>((2 * 255 * behind.count + all.count) / (2 * all.count))};
}

Status check(const PhotoSource& source, const PhotoOptions& options) {
  const ImageView& photo = source.photo;
  const Rectangle& roi = source.roi;
  if (photo.data == nullptr || photo.format != PixelFormat::kRgb24) return Status::kBadImage;
  if (!(source.camera.fx_px > 0) || !(source.camera.fy_px > 0)) return Status::kBadCamera;
  if (roi.width < 2 || roi.height < 2 || roi.x < 0 || roi.y < 0 || roi.x > photo.width_px - roi.width ||
      roi.y > photo.height_px - roi.height) {
    return Status::kBadRoi;
  }
  if (!(source.distance_mm > 0) || !std::isfinite(source.distance_mm)) return Status::kBadModel;
  if (options.points < 20 || options.points > kMaxPhotoPoints) return Status::kBadModel;
  if (!(options.strip_width > 0 && options.strip_width <= 1)) return Status::kBadModel;
  return Status::kOk;
}

void add_point(const PhotoSource& source, const HueLimits& limits, int x, int y, bool inner,
               PhotoModel& model) {
  const auto k = static_cast<unsigned>(model.points());
  const double uc = source.roi.x + 0.5 * (source.roi.width - 1);
  const double vc = source.roi.y + 0.5 * (source.roi.height - 1);
  model.x_mm[k] = static_cast<float>((x - uc) * source.distance_mm / source.camera.fx_px);
  model.y_mm[k] = static_cast<float>((y - vc) * source.distance_mm / source.camera.fy_px);
  if (!inner) {
    ++model.outer;
    return;
  }
  model.normals.z[k] = -1;  // flat, facing the camera
  const std::uint8_t* rgb = pixel(source.photo, x, y);
  model.weight[k] = source.target == nullptr || source.target[y * source.photo.width_px + x] != 0 ? 1 : 0;
  model.hue[k] = hue_code_rgb(rgb[0], rgb[1], rgb[2], limits);
  const auto set = [k](PointColours& colours, const YCbCr& colour) {
    colours.luma[k] = colour.luma;
    colours.cb[k] = colour.cb;
    colours.cr[k] = colour.cr;
  };
  for (unsigned level = 0; level < kColourLevels; ++level) {
    const Square square = look_at_square(source, x, y, 1 << level);
    set(model.colour[level], square.colour);
    set(model.backdrop.colour[level], square.behind);
    model.backdrop.share[level][k] = square.share;
  }
  ++model.inner;
}

// Adds every grid point of one kind, in an order whose every leading part is spread over the target.
void add_points(const Grid& grid, Place kind, const HueLimits& limits, PhotoModel& model) {
  struct Cell {
    std::int16_t i;
    std::int16_t j;
  };
  std::array<Cell, kMaxPhotoPoints> along_curve;
  int count = 0;
  int side = 1;
  while (side < grid.columns || side < grid.rows) side *= 2;
  for (std::int64_t h = 0; h < std::int64_t{side} * side; ++h) {
    int i = 0;
    int j = 0;
    hilbert_cell(side, h, i, j);
    if (i >= grid.columns || j >= grid.rows || classify(grid, i, j) != kind) continue;
    along_curve[static_cast<unsigned>(count++)] = {static_cast<std::int16_t>(i),
                                                   static_cast<std::int16_t>(j)};
  }
  if (count == 0) return;
  const int stride = golden_stride(count);
  for (int k = 0, at = 0; k < count; ++k, at = (at + stride) % count) {
    const Cell cell = along_curve[static_cast<unsigned>(at)];
    add_point(*grid.source, limits, grid.column_px(cell.i), grid.row_px(cell.j), kind == Place::kInner,
              model);
  }
}

}  // namespace

Status build_photo_model(const PhotoSource& source, const PhotoOptions& options, const HueLimits& limits,
                         PhotoModel& model) {
  if (const Status status = check(source, options); status != Status::kOk) return status;

  model = PhotoModel{};
  model.votes = options.votes;
  model.masked = source.mask != nullptr || source.target != nullptr;
  model.background_hue = hue_code_from_degrees(source.background_hue_deg);
  const double uc = source.roi.x + 0.5 * (source.roi.width - 1);
  const double vc = source.roi.y + 0.5 * (source.roi.height - 1);
  model.optical_centre_mm = {-(uc - source.camera.cx_px) * source.distance_mm / source.camera.fx_px,
                             -(vc - source.camera.cy_px) * source.distance_mm / source.camera.fy_px,
                             -source.distance_mm};

  // The finest grid that keeps to the wanted number of points, but no finer than pixels.
  const double strip_px = std::fmax(1.0, options.strip_width * 0.5 * (source.roi.width + source.roi.height));
  double step_px =
      std::sqrt((source.roi.width + 2 * strip_px) * (source.roi.height + 2 * strip_px) / options.points);
  if (step_px < 1) step_px = 1;
  for (int pass = 0; pass < 12; ++pass) {
    const int count = count_points(make_grid(source, step_px, strip_px));
    if (count == 0) return Status::kBadRoi;
    const double next = step_px * std::sqrt(static_cast<double>(count) / options.points);
    if (next <= 1 || (count <= options.points && count * 50 >= options.points * 49)) break;
    step_px = next;
  }
  Grid grid = make_grid(source, step_px, strip_px);
  while (count_points(grid) > options.points) {
    step_px *= 1.01;
    grid = make_grid(source, step_px, strip_px);
  }
  add_points(grid, Place::kInner, limits, model);
  add_points(grid, Place::kOuter, limits, model);

  sum_up_backdrop(model.inner, model.backdrop);
  int with_hue = 0;
  for (int k = 0; k < model.inner; ++k) with_hue += is_hue(model.hue[static_cast<unsigned>(k)]) ? 1 : 0;
  return with_hue * 10 >= model.inner && model.inner > 0 ? Status::kOk : Status::kNoHue;
}

}  // namespace vergence
