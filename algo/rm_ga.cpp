#include "algo/rm_ga.hpp"

#include <cmath>

namespace vergence {
namespace {

constexpr std::uint32_t kGeneMask = (1U << kGeneBits) - 1;
constexpr std::uint64_t kHighMask = (1ULL << (kChromosomeBits - 64)) - 1;

// The low 64 bits set at positions >= n, and the high part accordingly: a run of ones from bit n to bit 71.
Chromosome ones_from(std::uint32_t n) {
  if (n >= 64) return {0, kHighMask & ~((1ULL << (n - 64)) - 1)};
  return {~((1ULL << n) - 1), kHighMask};
}

std::uint64_t mix(std::uint64_t z) {  // SplitMix64's finalizer
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;

}  // namespace

std::uint32_t Chromosome::gene(int index) const {
  const int first = index * kGeneBits;
  if (first + kGeneBits <= 64) return static_cast<std::uint32_t>(low >> first) & kGeneMask;
  // Only the last gene straddles the two words.
  return static_cast<std::uint32_t>((low >> first) | (high << (64 - first))) & kGeneMask;
}

void Chromosome::set_gene(int index, std::uint32_t value) {
  const int first = index * kGeneBits;
  const std::uint64_t bits = value & kGeneMask;
  low = (low & ~(std::uint64_t{kGeneMask} << first)) | (bits << first);
  if (first + kGeneBits > 64) {
    const int in_low = 64 - first;
    high = (high & ~(std::uint64_t{kGeneMask} >> in_low)) | (bits >> in_low);
  }
}

Status check(const SearchBox& box) {
  double e_squared = 0;
  for (unsigned i = 0; i < kGenes; ++i) {
    if (!std::isfinite(box.centre[i]) || !std::isfinite(box.half_range[i]) || !(box.half_range[i] > 0)) {
      return Status::kBadSearchBox;
    }
    if (i >= 3) e_squared += box.centre[i] * box.centre[i];
  }
  return e_squared < 1 ? Status::kOk : Status::kBadSearchBox;
}

Pose decode(const Chromosome& chromosome, const SearchBox& box, GeneCoding coding) {
  double value[kGenes];
  for (int i = 0; i < kGenes; ++i) {
    const std::uint32_t gene = chromosome.gene(i);
    const std::uint32_t level = coding == GeneCoding::kGray ? binary_from_gray(gene) : gene;
    const auto g = static_cast<unsigned>(i);
    value[i] = box.centre[g] + box.half_range[g] * (2.0 * level / kGeneMask - 1.0);
  }
  return {{value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
}

Chromosome encode(const Pose& pose, const SearchBox& box, GeneCoding coding) {
  Chromosome chromosome;
  for (int i = 0; i < kGenes; ++i) {
    const double value = i < 3 ? pose.position_mm[i] : pose.e[i - 3];
    const auto g = static_cast<unsigned>(i);
    const double scaled = ((value - box.centre[g]) / box.half_range[g] + 1.0) * (kGeneMask / 2.0);
    const double clamped = scaled > 0 ? (scaled < kGeneMask ? scaled : kGeneMask) : 0;  // NaN becomes 0
    const auto level = static_cast<std::uint32_t>(clamped + 0.5);
    chromosome.set_gene(i, coding == GeneCoding::kGray ? gray_from_binary(level) : level);
  }
  return chromosome;
}

CounterRandom::CounterRandom(std::uint64_t seed, std::uint64_t frame)
    : key_(mix(mix(seed + kGolden) ^ (frame * kGolden + 1))) {}

std::uint64_t CounterRandom::next() {
  return mix(key_ + (++position_) * kGolden);
}

std::uint32_t CounterRandom::below(std::uint32_t bound) {
  return static_cast<std::uint32_t>(((next() >> 32) * bound) >> 32);
}

Chromosome random_chromosome(CounterRandom& random) {
  const std::uint64_t low = random.next();
  return {low, random.next() & kHighMask};
}

Chromosome two_point_crossover(const Chromosome& a, const Chromosome& b, CounterRandom& random) {
  const std::uint32_t p = random.below(kChromosomeBits + 1);
  const std::uint32_t q = random.below(kChromosomeBits + 1);
  // Ones between the two points: the runs from each differ there and nowhere else.
  const Chromosome from_p = ones_from(p);
  const Chromosome from_q = ones_from(q);
  const std::uint64_t low = from_p.low ^ from_q.low;
  const std::uint64_t high = from_p.high ^ from_q.high;
  return {(a.low & ~low) | (b.low & low), (a.high & ~high) | (b.high & high)};
}

Chromosome mutate(const Chromosome& chromosome, int mutation_per_1024, CounterRandom& random) {
  // 64 coins of probability m / 2^10 at once: going through m's bits from the least, OR with random bits
  // where the bit is one and AND where it is zero halves the distance to the wanted probability at each step.
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  for (int bit = 0; bit < 10; ++bit) {
    const std::uint64_t random_low = random.next();
    const std::uint64_t random_high = random.next();
    const std::uint64_t one = ~((static_cast<std::uint64_t>(mutation_per_1024 >> bit) & 1) - 1);
    low = (low & random_low) | (one & (low | random_low));
    high = (high & random_high) | (one & (high | random_high));
  }
  return {chromosome.low ^ low, chromosome.high ^ (high & kHighMask)};
}

void sort_by_score(Population& population) {
  // Rank = number of fitter individuals, or equally fit ones that come earlier: each pair is compared once
  // whatever the scores, so that the work of a generation does not depend on the image.
  const auto unsorted = population.individual;
  std::array<unsigned, kPopulation> rank{};
  for (unsigned i = 0; i < kPopulation; ++i) {
    for (unsigned j = i + 1; j < kPopulation; ++j) {
      const auto later_is_fitter = static_cast<unsigned>(unsorted[j].score > unsorted[i].score);
      rank[i] += later_is_fitter;
      rank[j] += 1 - later_is_fitter;
    }
  }
  for (unsigned i = 0; i < kPopulation; ++i) population.individual[rank[i]] = unsorted[i];
}

int draw_parent(int survivors, CounterRandom& random) {
  // Linear weights n, n-1, .., 1 = the smaller of two uniform draws, nearly: min of ranks a, b over a
  // triangle.
  const std::uint32_t n = static_cast<std::uint32_t>(survivors);
  const std::uint32_t ticket = random.below(n * (n + 1) / 2);
  // Rank r owns n - r tickets. Count, without branches, how many ranks end at or before the ticket.
  std::uint32_t rank = 0;
  std::uint32_t end = 0;
  for (std::uint32_t r = 0; r + 1 < n; ++r) {
    end += n - r;
    rank += static_cast<std::uint32_t>(ticket >= end);
  }
  return static_cast<int>(rank);
}

}  // namespace vergence
