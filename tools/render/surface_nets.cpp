#include "tools/render/surface_nets.hpp"

#include <cmath>
#include <limits>

namespace vergence::render {
namespace {

constexpr int kBlock = 8;
constexpr int kLeast = 2;  // smaller blocks would not pay
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Grid {
  std::array<int, 3> size{};  // corners
  std::vector<float> value;

  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }
};

// What a grid is filled with.
struct Filling {
  const Field& field;
  Vector3 low;
  double cell;
  double trust;
};

// Corners of a block of `size` on a side: all at once where the surface is far, else by the blocks in it.
void fill_block(Grid& grid, const Filling& filling, const std::array<int, 3>& from, int size) {
  std::array<int, 3> to{};
  for (std::size_t i = 0; i < 3; ++i) {
    to[i] = std::min(from[i] + size, grid.size[i]);
    if (from[i] >= to[i]) return;
  }
  const double half = filling.cell * size / 2;
  const double reach = half * 1.75;  // a bit more than half a block's diagonal
  const Vector3 middle =
      filling.low + filling.cell * Vector3(from[0], from[1], from[2]) + Vector3::Constant(half);
  if (size == kBlock) filling.field.come_near(middle, reach);
  const double there = filling.field.at(middle);
  const bool far = std::abs(there) > reach / filling.trust;
  if (!far && size > kLeast) {
    const int part = size / 2;
    for (int k = 0; k < 8; ++k) {
      fill_block(grid, filling,
                 {from[0] + (k & 1) * part, from[1] + (k >> 1 & 1) * part, from[2] + (k >> 2) * part}, part);
    }
    return;
  }
  for (int z = from[2]; z < to[2]; ++z) {
    for (int y = from[1]; y < to[1]; ++y) {
      for (int x = from[0]; x < to[0]; ++x) {
        const double value = far ? there : filling.field.at(filling.low + filling.cell * Vector3(x, y, z));
        grid.value[grid.index(x, y, z)] = static_cast<float>(value);
      }
    }
  }
}

}  // namespace

Surface surface_nets(const Field& field, const Vector3& low_mm, const Vector3& high_mm, double cell_mm,
                     double trust) {
  Grid grid;
  for (int i = 0; i < 3; ++i) {
    grid.size[static_cast<std::size_t>(i)] =
        static_cast<int>(std::ceil((high_mm[i] - low_mm[i]) / cell_mm)) + 2;
  }
  grid.value.resize(grid.index(0, 0, grid.size[2]));
  for (int z = 0; z < grid.size[2]; z += kBlock) {
    for (int y = 0; y < grid.size[1]; y += kBlock) {
      for (int x = 0; x < grid.size[0]; x += kBlock) {
        fill_block(grid, {field, low_mm, cell_mm, trust}, {x, y, z}, kBlock);
      }
    }
  }

  Surface surface;
  std::vector<std::uint32_t> vertex(grid.value.size(), kNone);  // of the cell at its lowest corner
  for (int z = 0; z + 1 < grid.size[2]; ++z) {
    for (int y = 0; y + 1 < grid.size[1]; ++y) {
      for (int x = 0; x + 1 < grid.size[0]; ++x) {
        float v[8];
        int inside = 0;
        for (int c = 0; c < 8; ++c) {
          v[c] = grid.value[grid.index(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))];
          inside += v[c] < 0 ? 1 : 0;
        }
        if (inside == 0 || inside == 8) continue;
        Vector3 sum = Vector3::Zero();
        int crossings = 0;
        for (int c = 0; c < 8; ++c) {
          for (int axis = 0; axis < 3; ++axis) {
            const int other = c | 1 << axis;
            if (other == c || (v[c] < 0) == (v[other] < 0)) continue;
            Vector3 p(c & 1, c >> 1 & 1, c >> 2);
            p[axis] = static_cast<double>(v[c]) / static_cast<double>(v[c] - v[other]);
            sum += p;
            ++crossings;
          }
        }
        vertex[grid.index(x, y, z)] = static_cast<std::uint32_t>(surface.points.size());
        surface.points.push_back(low_mm + cell_mm * (Vector3(x, y, z) + sum / crossings));
      }
    }
  }

  // A quad around each grid edge that crosses the surface.
  for (int z = 1; z + 1 < grid.size[2]; ++z) {
    for (int y = 1; y + 1 < grid.size[1]; ++y) {
      for (int x = 1; x + 1 < grid.size[0]; ++x) {
        const bool here = grid.value[grid.index(x, y, z)] < 0;
        const auto quad = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
          surface.triangles.push_back({vertex[a], vertex[b], vertex[c]});
          surface.triangles.push_back({vertex[a], vertex[c], vertex[d]});
        };
        if (here != (grid.value[grid.index(x + 1, y, z)] < 0)) {
          quad(grid.index(x, y, z), grid.index(x, y - 1, z), grid.index(x, y - 1, z - 1),
               grid.index(x, y, z - 1));
        }
        if (here != (grid.value[grid.index(x, y + 1, z)] < 0)) {
          quad(grid.index(x, y, z), grid.index(x - 1, y, z), grid.index(x - 1, y, z - 1),
               grid.index(x, y, z - 1));
        }
        if (here != (grid.value[grid.index(x, y, z + 1)] < 0)) {
          quad(grid.index(x, y, z), grid.index(x - 1, y, z), grid.index(x - 1, y - 1, z),
               grid.index(x, y - 1, z));
        }
      }
    }
  }
  return surface;
}

}  // namespace vergence::render
