#include "tools/render/random.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace

double value_noise(const Vector3& p, std::uint64_t seed, int period) {
  int cell[3];
  double t[3];
  for (int i = 0; i < 3; ++i) {
    const double floor = std::floor(p[i]);
    cell[i] = static_cast<int>(floor);
    const double f = p[i] - floor;
    t[i] = f * f * (3 - 2 * f);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1;
    const int dy = corner >> 1 & 1;
    const int dz = corner >> 2;
    const double weight = (dx ? t[0] : 1 - t[0]) * (dy ? t[1] : 1 - t[1]) * (dz ? t[2] : 1 - t[2]);
    if (weight == 0) continue;
    sum +=
        weight * unit(cell_hash(wrap(cell[0] + dx, period), wrap(cell[1] + dy, period), cell[2] + dz, seed));
  }
  return 2 * sum - 1;
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
