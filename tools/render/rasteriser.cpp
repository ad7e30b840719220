#include "tools/render/rasteriser.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vergence::render {
namespace {

constexpr double kNear_mm = 10;

struct Offset {
  double x;
  double y;
};

// In sixteenths of a pixel from its centre.
constexpr std::array<Offset, 4> kRotatedGrid{{{-2, -6}, {6, -2}, {-6, 2}, {2, 6}}};
constexpr std::array<Offset, 8> kEightRooks{
    {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}}};
constexpr std::array<Offset, 16> kSixteen{{{1, 1},
                                           {-1, -3},
                                           {-3, 2},
                                           {4, -1},
                                           {-5, -2},
                                           {2, 5},
                                           {5, 3},
                                           {3, -5},
                                           {-2, 6},
                                           {0, -7},
                                           {-4, -6},
                                           {-6, 4},
                                           {-8, 0},
                                           {7, -4},
                                           {6, 7},
                                           {-7, -8}}};

std::vector<Offset> offsets(Sampling sampling) {
  std::vector<Offset> result;
  switch (sampling) {
    case Sampling::k4: result.assign(kRotatedGrid.begin(), kRotatedGrid.end()); break;
    case Sampling::k8: result.assign(kEightRooks.begin(), kEightRooks.end()); break;
    case Sampling::k16: result.assign(kSixteen.begin(), kSixteen.end()); break;
  }
  Offset mean{0, 0};
  for (Offset& o : result) {
    o = {o.x / 16, o.y / 16};
    mean = {mean.x + o.x / static_cast<double>(result.size()),
            mean.y + o.y / static_cast<double>(result.size())};
  }
  for (Offset& o : result) o = {o.x - mean.x, o.y - mean.y};
  return result;
}

struct Corner {
  Vector2 uv_px;
  double inverse_depth = 0;  // 0: not drawn
  Rgb colour;
};

struct Sample {
  float inverse_depth = 0;
  bool target = false;
  Rgb colour;
};

// The samples of a rectangle of pixels.
class SampleGrid {
 public:
  SampleGrid(int x0, int y0, int x1, int y1, Sampling sampling)
      : x0_(x0), y0_(y0), x1_(x1), y1_(y1), offsets_(offsets(sampling)) {
    const int width = std::max(0, x1 - x0);
    const int height = std::max(0, y1 - y0);
    samples_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * offsets_.size());
  }

  void add(const Corner& a, const Corner& b, const Corner& c, bool target) {
    const double area = cross(b.uv_px - a.uv_px, c.uv_px - a.uv_px);
    if (area == 0) return;
    const auto [left, right] = std::minmax({a.uv_px[0], b.uv_px[0], c.uv_px[0]});
    const auto [top, bottom] = std::minmax({a.uv_px[1], b.uv_px[1], c.uv_px[1]});
    if (right < x0_ - 1 || left > x1_ || bottom < y0_ - 1 || top > y1_) return;
    const int from_x = std::max(x0_, static_cast<int>(std::floor(left + 0.5)));
    const int to_x = std::min(x1_ - 1, static_cast<int>(std::floor(right + 0.5)));
    const int from_y = std::max(y0_, static_cast<int>(std::floor(top + 0.5)));
    const int to_y = std::min(y1_ - 1, static_cast<int>(std::floor(bottom + 0.5)));
    const double scale = 1 / area;
    for (int y = from_y; y <= to_y; ++y) {
      for (int x = from_x; x <= to_x; ++x) {
        Sample* sample = at(x, y);
        for (const Offset& o : offsets_) {
          const Vector2 p(x + o.x, y + o.y);
          const double wa = cross(c.uv_px - b.uv_px, p - b.uv_px) * scale;
          const double wb = cross(a.uv_px - c.uv_px, p - c.uv_px) * scale;
          const double wc = 1 - wa - wb;
          if (wa >= 0 && wb >= 0 && wc >= 0) {
            const auto depth =
                static_cast<float>(wa * a.inverse_depth + wb * b.inverse_depth + wc * c.inverse_depth);
            if (depth > sample->inverse_depth) {
              // Weights on the surface, not on the image.
              const auto s = 1 / depth;
              const float ka = static_cast<float>(wa * a.inverse_depth) * s;
              const float kb = static_cast<float>(wb * b.inverse_depth) * s;
              const float kc = static_cast<float>(wc * c.inverse_depth) * s;
              *sample = {depth, target, a.colour * ka + b.colour * kb + c.colour * kc};
            }
          }
          ++sample;
        }
      }
    }
  }

  void resolve(LinearImage& image, Visibility* visibility) const {
    const auto n = offsets_.size();
    const float share = 1 / static_cast<float>(n);
    const Sample* sample = samples_.data();
    for (int y = y0_; y < y1_; ++y) {
      for (int x = x0_; x < x1_; ++x) {
        Rgb sum;
        std::size_t hits = 0;
        std::size_t on_target = 0;
        float depth = 0;
        for (std::size_t i = 0; i < n; ++i, ++sample) {
          if (sample->inverse_depth <= 0) continue;
          sum += sample->colour;
          ++hits;
          if (!sample->target) continue;
          ++on_target;
          depth += 1 / sample->inverse_depth;
        }
        if (hits == 0) continue;
        Rgb& pixel = image.at(x, y);
        pixel = sum * share + pixel * (share * static_cast<float>(n - hits));
        if (visibility != nullptr && on_target > 0) {
          visibility->coverage[image.index(x, y)] = share * static_cast<float>(on_target);
          visibility->depth_mm[image.index(x, y)] = depth / static_cast<float>(on_target);
        }
      }
    }
  }

 private:
  static double cross(const Vector2& a, const Vector2& b) { return a[0] * b[1] - a[1] * b[0]; }
  Sample* at(int x, int y) {
    const auto pixel = static_cast<std::size_t>(y - y0_) * static_cast<std::size_t>(x1_ - x0_) +
                       static_cast<std::size_t>(x - x0_);
    return &samples_[pixel * offsets_.size()];
  }

  int x0_, y0_, x1_, y1_;
  std::vector<Offset> offsets_;
  std::vector<Sample> samples_;
};

std::vector<Corner> project_corners(const CameraModel& camera, const Transform& T_W_C, const Placed& placed,
                                    const Light& light) {
  const Transform T_C_M = T_W_C.inverse() * placed.T_W;
  const Vector3 viewer = placed.T_W.inverse() * T_W_C.t_mm;  // in the mesh's frame
  Light local = light;
  local.towards_lamp = placed.T_W.R.transpose() * light.towards_lamp;
  std::vector<Corner> corners(placed.mesh->vertices.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vertex& vertex = placed.mesh->vertices[i];
    const Vector3 p = T_C_M * vertex.position_mm;
    if (!(p[2] >= kNear_mm) || !project(camera, p, corners[i].uv_px)) continue;
    corners[i].inverse_depth = 1 / p[2];
    corners[i].colour = shade(local, vertex.albedo, vertex.openness, placed.mesh->gloss, vertex.normal,
                              (viewer - vertex.position_mm).normalized());
  }
  return corners;
}

}  // namespace

void draw(const CameraModel& camera, const Transform& T_W_C, std::span<const Placed> meshes,
          const Light& light, Sampling sampling, LinearImage& image, Visibility* visibility) {
  if (visibility != nullptr) {
    visibility->coverage.assign(image.data.size(), 0);
    visibility->depth_mm.assign(image.data.size(), 0);
  }
  std::vector<std::vector<Corner>> corners;
  Vector2 low(1e9, 1e9);
  Vector2 high(-1e9, -1e9);
  for (const Placed& placed : meshes) {
    corners.push_back(project_corners(camera, T_W_C, placed, light));
    for (const Corner& corner : corners.back()) {
      if (corner.inverse_depth <= 0) continue;
      low = low.cwiseMin(corner.uv_px);
      high = high.cwiseMax(corner.uv_px);
    }
  }
  const auto bound = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  SampleGrid grid(bound(low[0] - 1, image.width_px), bound(low[1] - 1, image.height_px),
                  bound(high[0] + 2, image.width_px), bound(high[1] + 2, image.height_px), sampling);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    for (const auto& t : meshes[i].mesh->triangles) {
      const Corner& a = corners[i][t[0]];
      const Corner& b = corners[i][t[1]];
      const Corner& c = corners[i][t[2]];
      if (a.inverse_depth > 0 && b.inverse_depth > 0 && c.inverse_depth > 0)
        grid.add(a, b, c, meshes[i].target);
    }
  }
  grid.resolve(image, visibility);
}

}  // namespace vergence::render
