// Random numbers by counter, not by sequence: the value belongs to (seed, index), so it is the same whatever
// thread asks and in whatever order. And smooth noise made of them.
#pragma once

#include <cstdint>
#include <span>

#include "algo/pose.hpp"

namespace vergence::render {

// 64 well-mixed bits of a counter (the finalizer of SplitMix64).
[[nodiscard]] constexpr std::uint64_t hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}
[[nodiscard]] constexpr std::uint64_t hash(std::uint64_t seed, std::uint64_t index) {
  return hash(hash(seed) ^ index);
}

// In [0, 1).
[[nodiscard]] constexpr double uniform(std::uint64_t seed, std::uint64_t index) {
  return static_cast<double>(hash(seed, index) >> 11) * 0x1.0p-53;
}

// The sum of four uniforms of 16 bits, as a whole number.
[[nodiscard]] constexpr std::int32_t sum_of_four(std::uint64_t bits) {
  constexpr std::uint64_t kEveryOther = 0x0000ffff0000ffffULL;
  const std::uint64_t two = (bits & kEveryOther) + (bits >> 16 & kEveryOther);
  return static_cast<std::int32_t>((two & 0xffffffff) + (two >> 32));
}
// Of it: near-normal, zero mean, variance one, never beyond 3.5.
[[nodiscard]] inline float normal_of(std::int32_t sum) {
  return static_cast<float>(sum - 131070) * (1.7320508F / 65536.0F);
}
[[nodiscard]] inline float normal(std::uint64_t bits) {
  return normal_of(sum_of_four(bits));
}

// Smooth noise in [-1, 1] with features of size one; `period` > 0 repeats it over that many cells of x and y.
[[nodiscard]] double value_noise(const Vector3& p, std::uint64_t seed, int period = 0);

// The same at points of one z, as many as `out` holds. Neighbours in one cell share the work on it.
void value_noise(std::span<const double> xs, std::span<const double> ys, double z, std::uint64_t seed,
                 int period, std::span<double> out);

// `octaves` of it, each of half the size and half the strength; in [-1, 1].
[[nodiscard]] double fractal_noise(const Vector3& p, std::uint64_t seed, int octaves, int period = 0);
void fractal_noise(std::span<const double> xs, std::span<const double> ys, double z, std::uint64_t seed,
                   int octaves, int period, std::span<double> out);

// Distance to the nearest of points scattered one to a cell of size one.
[[nodiscard]] double nearest_point_distance(const Vector3& p, std::uint64_t seed);

}  // namespace vergence::render
