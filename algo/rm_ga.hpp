// RM-GA, the real-time multi-step genetic algorithm [3.5, 5.4]: a population of 20 bit strings of 72 bits,
// six genes of 12, evolved within one frame and carried over to the next.
//
// Every random number is a function of (seed, frame, position in the frame), so a frame's outcome depends on
// nothing but (seed, frame number, images, previous population).
#pragma once

#include <array>
#include <cstdint>

#include "algo/limits.hpp"
#include "algo/pose.hpp"
#include "algo/status.hpp"

namespace vergence {

// 72 bits; gene g occupies bits [12 g, 12 g + 12), least significant bit first.
struct Chromosome {
  std::uint64_t low = 0;   // bits 0..63
  std::uint64_t high = 0;  // bits 64..71

  [[nodiscard]] std::uint32_t gene(int index) const;  // 0..4095
  void set_gene(int index, std::uint32_t value);
  friend bool operator==(const Chromosome&, const Chromosome&) = default;
};

enum class GeneCoding : std::uint8_t {
  kGray,    // neighbouring values differ in one bit: no Hamming cliffs
  kBinary,  // the thesis
};

[[nodiscard]] constexpr std::uint32_t gray_from_binary(std::uint32_t value) {
  return value ^ (value >> 1);
}
[[nodiscard]] constexpr std::uint32_t binary_from_gray(std::uint32_t value) {
  value ^= value >> 1;
  value ^= value >> 2;
  value ^= value >> 4;
  value ^= value >> 8;
  return value;
}

// The box the genes span: centre +- half_range, [x y z] in mm and [e1 e2 e3].
struct SearchBox {
  std::array<double, kGenes> centre{0, 0, 500, 0, 0, 0};
  std::array<double, kGenes> half_range{180, 180, 180, 0.35, 0.35, 0.35};
};

// kBadSearchBox where a value is not finite, a half range is not > 0, or an e of the box's centre is not
// inside the unit ball. (Corners beyond the unit ball are allowed; such e are scaled to length 1.)
[[nodiscard]] Status check(const SearchBox& box);

// A gene's value v in 0..4095 stands for centre + half_range (2 v / 4095 - 1); encoding takes the nearest,
// and clamps what lies beside the box.
[[nodiscard]] Pose decode(const Chromosome& chromosome, const SearchBox& box, GeneCoding coding);
[[nodiscard]] Chromosome encode(const Pose& pose, const SearchBox& box, GeneCoding coding);

struct GaSettings {
  GeneCoding coding = GeneCoding::kGray;
  int survivors = 12;           // fittest kept each generation (60 %), 2..19
  int mutation_per_1024 = 102;  // probability of a bit to flip (10 %)
};

// Random 64-bit numbers by position: SplitMix64's mixer over key + position * golden ratio.
class CounterRandom {
 public:
  CounterRandom() = default;
  CounterRandom(std::uint64_t seed, std::uint64_t frame);
  [[nodiscard]] std::uint64_t next();
  [[nodiscard]] std::uint32_t below(std::uint32_t bound);  // 0..bound-1, by multiply-shift
  [[nodiscard]] std::uint64_t position() const { return position_; }

 private:
  std::uint64_t key_ = 0;
  std::uint64_t position_ = 0;
};

struct Individual {
  Chromosome chromosome;
  std::int64_t score = 0;  // the larger the fitter
};

// Sorted by falling score after every step; equal scores keep their order, so the sort is one on every
// machine.
struct Population {
  std::array<Individual, kPopulation> individual{};
};

[[nodiscard]] Chromosome random_chromosome(CounterRandom& random);

// Two points of the 72-bit string are drawn; `child` is `a` with the bits between them from `b`.
[[nodiscard]] Chromosome two_point_crossover(const Chromosome& a, const Chromosome& b, CounterRandom& random);

// Flips every bit with probability mutation_per_1024 / 1024, with the same work for any outcome.
[[nodiscard]] Chromosome mutate(const Chromosome& chromosome, int mutation_per_1024, CounterRandom& random);

void sort_by_score(Population& population);

// One generation on a sorted population: keep the fittest `survivors`, refill to 20 by crossover of two of
// them (drawn with linear rank weights) and mutation, evaluate ONLY the new ones with `score(chromosome) ->
// int64`, and sort. Does the same work whatever the scores.
template <class Score>
void evolve_generation(Population& population, const GaSettings& settings, CounterRandom& random,
                       Score&& score);

// Draws 20 times `founders` chromosomes at random, evaluates them, and keeps the fittest of each `founders`.
// With one it is the first generation of the thesis.
template <class Score>
void found_population(Population& population, int founders, CounterRandom& random, Score&& score);

// The same, drawn by `draw() -> Chromosome`.
template <class Draw, class Score>
void found_population_from(Population& population, int founders, Draw&& draw, Score&& score);

// Evaluates all 20 again, as when a new pair of images has come, and sorts.
template <class Score>
void evaluate_population(Population& population, Score&& score);

// Rank of a parent among `survivors`, linear weights: the fittest is drawn `survivors` times as often as the
// last.
[[nodiscard]] int draw_parent(int survivors, CounterRandom& random);

// ---- templates ------------------------------------------------------------------------------------------

template <class Score>
void evolve_generation(Population& population, const GaSettings& settings, CounterRandom& random,
                       Score&& score) {
  for (int i = settings.survivors; i < kPopulation; ++i) {
    const auto& a = population.individual[static_cast<unsigned>(draw_parent(settings.survivors, random))];
    const auto& b = population.individual[static_cast<unsigned>(draw_parent(settings.survivors, random))];
    auto& child = population.individual[static_cast<unsigned>(i)];
    child.chromosome =
        mutate(two_point_crossover(a.chromosome, b.chromosome, random), settings.mutation_per_1024, random);
    child.score = score(child.chromosome);
  }
  sort_by_score(population);
}

template <class Score>
void found_population(Population& population, int founders, CounterRandom& random, Score&& score) {
  found_population_from(
      population, founders, [&] { return random_chromosome(random); }, score);
}

template <class Draw, class Score>
void found_population_from(Population& population, int founders, Draw&& draw, Score&& score) {
  for (auto& individual : population.individual) {
    individual.chromosome = draw();
    individual.score = score(individual.chromosome);
    for (int k = 1; k < founders; ++k) {
      Individual other{draw(), 0};
      other.score = score(other.chromosome);
      if (other.score > individual.score) individual = other;
    }
  }
  sort_by_score(population);
}

template <class Score>
void evaluate_population(Population& population, Score&& score) {
  for (auto& individual : population.individual) individual.score = score(individual.chromosome);
  sort_by_score(population);
}

}  // namespace vergence
