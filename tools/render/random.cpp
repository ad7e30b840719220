#include "tools/render/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vergence::render {
namespace {

std::uint64_t cell_hash(int x, int y, int z, std::uint64_t seed) {
  const auto bits = [](int v) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) & 0x1fffff);
  };
  return hash(seed, bits(x) | bits(y) << 21 | bits(z) << 42);
}

double unit(std::uint64_t bits) {
  return static_cast<double>(bits & 0xffff) / 65535;
}

int wrap(int v, int period) {
  return period > 0 ? ((v % period) + period) % period : v;
}

// A coordinate: its cell, and how far it is through it, smoothed.
struct Along {
  explicit Along(double v) {
    const double floor = std::floor(v);
    cell = static_cast<int>(floor);
    const double f = v - floor;
    t = f * f * (3 - 2 * f);
  }
  int cell;
  double t;
};

std::array<double, 8> cell_corners(int x, int y, int z, std::uint64_t seed, int period) {
  std::array<double, 8> values;
  for (int corner = 0; corner < 8; ++corner) {
    values[static_cast<std::size_t>(corner)] = unit(cell_hash(
        wrap(x + (corner & 1), period), wrap(y + (corner >> 1 & 1), period), z + (corner >> 2), seed));
  }
  return values;
}

double blend(const std::array<double, 8>& corners, double tx, double ty, double tz) {
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    sum += ((i & 1) != 0 ? tx : 1 - tx) * ((i & 2) != 0 ? ty : 1 - ty) * ((i & 4) != 0 ? tz : 1 - tz) *
           corners[i];
  }
  return 2 * sum - 1;
}

}  // namespace

double value_noise(const Vector3& p, std::uint64_t seed, int period) {
  const Along x(p[0]);
  const Along y(p[1]);
  const Along z(p[2]);
  return blend(cell_corners(x.cell, y.cell, z.cell, seed, period), x.t, y.t, z.t);
}

void value_noise(std::span<const double> xs, std::span<const double> ys, double z_of_all, std::uint64_t seed,
                 int period, std::span<double> out) {
  constexpr std::size_t kChunk = 64;
  const Along z(z_of_all);
  std::array<int, kChunk> cell_x;
  std::array<int, kChunk> cell_y;
  std::array<double, kChunk> tx;
  std::array<double, kChunk> ty;
  for (std::size_t first = 0; first < out.size(); first += kChunk) {
    const std::size_t count = std::min(kChunk, out.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      const Along x(xs[first + i]);
      const Along y(ys[first + i]);
      cell_x[i] = x.cell;
      cell_y[i] = y.cell;
      tx[i] = x.t;
      ty[i] = y.t;
    }
    for (std::size_t i = 0; i < count;) {
      std::size_t end = i + 1;  // of those in the same cell
      while (end < count && cell_x[end] == cell_x[i] && cell_y[end] == cell_y[i]) ++end;
      const std::array<double, 8> corners = cell_corners(cell_x[i], cell_y[i], z.cell, seed, period);
      for (; i < end; ++i) out[first + i] = blend(corners, tx[i], ty[i], z.t);
    }
  }
}

double fractal_noise(const Vector3& p, std::uint64_t seed, int octaves, int period) {
  double sum = 0;
  double total = 0;
  double strength = 1;
  double size = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += strength *
           value_noise(p * size, seed + static_cast<std::uint64_t>(i), period * static_cast<int>(size));
    total += strength;
    strength /= 2;
    size *= 2;
  }
  return sum / total;
}

void fractal_noise(std::span<const double> xs, std::span<const double> ys, double z, std::uint64_t seed,
                   int octaves, int period, std::span<double> out) {
  std::vector<double> finer_xs(xs.begin(), xs.end());
  std::vector<double> finer_ys(ys.begin(), ys.end());
  std::vector<double> octave(out.size());
  std::fill(out.begin(), out.end(), 0.0);
  double total = 0;
  double strength = 1;
  double size = 1;
  for (int i = 0; i < octaves; ++i) {
    value_noise(finer_xs, finer_ys, z * size, seed + static_cast<std::uint64_t>(i),
                period * static_cast<int>(size), octave);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += strength * octave[k];
    total += strength;
    strength /= 2;
    size *= 2;
    for (std::size_t k = 0; k < out.size(); ++k) {
      finer_xs[k] = xs[k] * size;
      finer_ys[k] = ys[k] * size;
    }
  }
  for (double& v : out) v /= total;
}

double nearest_point_distance(const Vector3& p, std::uint64_t seed) {
  double nearest = 9;
  const int x = static_cast<int>(std::floor(p[0]));
  const int y = static_cast<int>(std::floor(p[1]));
  const int z = static_cast<int>(std::floor(p[2]));
  for (int i = 0; i < 27; ++i) {
    const int cx = x + i % 3 - 1;
    const int cy = y + i / 3 % 3 - 1;
    const int cz = z + i / 9 - 1;
    const std::uint64_t bits = cell_hash(cx, cy, cz, seed);
    const Vector3 point(cx + unit(bits), cy + unit(bits >> 16), cz + unit(bits >> 32));
    nearest = std::min(nearest, (point - p).squaredNorm());
  }
  return std::sqrt(nearest);
}

}  // namespace vergence::render
