// The genetic algorithm: bit strings, coding, operators, and that nothing but scores and random numbers
// counts.
#include "algo/rm_ga.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace vergence {
namespace {

Chromosome any_chromosome() {
  CounterRandom random(*rc::gen::arbitrary<std::uint64_t>(), 0);
  return random_chromosome(random);
}

int differing_bits(const Chromosome& a, const Chromosome& b) {
  return std::popcount(a.low ^ b.low) + std::popcount(a.high ^ b.high);
}

TEST(GrayCode, IsABijectionWhoseNeighboursDifferInOneBit) {
  std::set<std::uint32_t> seen;
  for (std::uint32_t value = 0; value < 4096; ++value) {
    const std::uint32_t gray = gray_from_binary(value);
    EXPECT_LT(gray, 4096U);
    EXPECT_EQ(binary_from_gray(gray), value);
    seen.insert(gray);
    if (value > 0) {
      EXPECT_EQ(std::popcount(gray ^ gray_from_binary(value - 1)), 1);
    }
  }
  EXPECT_EQ(seen.size(), 4096U);
}

TEST(Chromosome, GenesAreIndependentTwelveBitFields) {
  ASSERT_TRUE(rc::check([] {
    Chromosome chromosome = any_chromosome();
    const Chromosome before = chromosome;
    const int changed = *rc::gen::inRange(0, kGenes);
    const auto value = static_cast<std::uint32_t>(*rc::gen::inRange(0, 4096));
    chromosome.set_gene(changed, value);
    for (int g = 0; g < kGenes; ++g) RC_ASSERT(chromosome.gene(g) == (g == changed ? value : before.gene(g)));
    RC_ASSERT(chromosome.high < 256U);
  }));
}

TEST(Coding, PosesInTheBoxComeBackWithinHalfAStep) {
  for (const GeneCoding coding : {GeneCoding::kGray, GeneCoding::kBinary}) {
    ASSERT_TRUE(rc::check([coding] {
      SearchBox box;
      Pose pose;
      for (unsigned i = 0; i < kGenes; ++i) {
        box.centre[i] = (i < 3 ? 1000.0 : 0.5) * (*rc::gen::inRange(-1000, 1001)) / 1000.0;
        box.half_range[i] = (i < 3 ? 300.0 : 0.4) * (*rc::gen::inRange(1, 1001)) / 1000.0;
        const double share = *rc::gen::inRange(-1000, 1001) / 1000.0;
        const double value = box.centre[i] + box.half_range[i] * share;
        (i < 3 ? pose.position_mm[i] : pose.e[i - 3]) = value;
      }
      const Pose back = decode(encode(pose, box, coding), box, coding);
      for (unsigned i = 0; i < kGenes; ++i) {
        const double error =
            i < 3 ? back.position_mm[i] - pose.position_mm[i] : back.e[i - 3] - pose.e[i - 3];
        RC_ASSERT(std::abs(error) <= box.half_range[i] / 4095 * (1 + 1e-9));
      }
    }));
  }
}

TEST(Coding, WhatLiesBesideTheBoxIsClamped) {
  const SearchBox box;
  const Pose far{{1e9, -1e9, std::nan("")}, {0, 0, 0}};
  const Pose back = decode(encode(far, box, GeneCoding::kGray), box, GeneCoding::kGray);
  EXPECT_DOUBLE_EQ(back.position_mm[0], 180);
  EXPECT_DOUBLE_EQ(back.position_mm[1], -180);
  EXPECT_DOUBLE_EQ(back.position_mm[2], 320);
}

TEST(Crossover, EveryBitComesFromAParentAndAtMostTwoSeams) {
  ASSERT_TRUE(rc::check([] {
    const Chromosome a{0, 0};
    const Chromosome b{~0ULL, 0xFF};
    CounterRandom random(*rc::gen::arbitrary<std::uint64_t>(), 1);
    const Chromosome child = two_point_crossover(a, b, random);
    int seams = 0;
    for (int bit = 1; bit < kChromosomeBits; ++bit) {
      const auto at = [&](int i) { return (i < 64 ? child.low >> i : child.high >> (i - 64)) & 1; };
      seams += at(bit) != at(bit - 1) ? 1 : 0;
    }
    RC_ASSERT(seams <= 2);
    const Chromosome c = any_chromosome();
    RC_ASSERT(two_point_crossover(c, c, random) == c);
  }));
}

TEST(Mutation, FlipsBitsAtItsRate) {
  for (const int rate : {0, 20, 51, 102, 512, 1023}) {
    CounterRandom random(7, static_cast<std::uint64_t>(rate));
    long flips = 0;
    constexpr int kTrials = 20000;
    for (int i = 0; i < kTrials; ++i) {
      const Chromosome before = random_chromosome(random);
      flips += differing_bits(before, mutate(before, rate, random));
    }
    const double p = rate / 1024.0;
    const double bits = static_cast<double>(kTrials) * kChromosomeBits;
    const double sigma = std::sqrt(bits * p * (1 - p));
    EXPECT_NEAR(static_cast<double>(flips), bits * p, 5 * sigma) << rate;
  }
}

TEST(Sort, IsStableAndFalls) {
  ASSERT_TRUE(rc::check([] {
    Population population;
    for (unsigned i = 0; i < kPopulation; ++i) {
      population.individual[i].score = *rc::gen::inRange(-3, 4);
      population.individual[i].chromosome.low = i;  // remembers the place
    }
    Population oracle = population;
    std::stable_sort(oracle.individual.begin(), oracle.individual.end(),
                     [](const Individual& a, const Individual& b) { return a.score > b.score; });
    sort_by_score(population);
    for (unsigned i = 0; i < kPopulation; ++i) {
      RC_ASSERT(population.individual[i].score == oracle.individual[i].score);
      RC_ASSERT(population.individual[i].chromosome == oracle.individual[i].chromosome);
    }
  }));
}

TEST(Parents, AreDrawnByLinearRank) {
  CounterRandom random(3, 0);
  std::array<int, 12> drawn{};
  constexpr int kDraws = 78000;
  for (int i = 0; i < kDraws; ++i) ++drawn[static_cast<unsigned>(draw_parent(12, random))];
  for (unsigned rank = 0; rank < 12; ++rank) {
    const double expected = kDraws * (12.0 - rank) / 78.0;
    EXPECT_NEAR(drawn[rank], expected, 5 * std::sqrt(expected)) << rank;
  }
}

TEST(Evolution, EvaluatesOnlyTheNewOnesAndNeverLosesTheBest) {
  ASSERT_TRUE(rc::check([] {
    const std::uint64_t seed = *rc::gen::arbitrary<std::uint64_t>();
    GaSettings settings;
    settings.survivors = *rc::gen::inRange(2, kPopulation);
    int evaluations = 0;
    const auto count_ones = [&](const Chromosome& c) {
      ++evaluations;
      return static_cast<std::int64_t>(std::popcount(c.low) + std::popcount(c.high));
    };
    CounterRandom random(seed, 5);
    Population population;
    found_population(population, 1, random, count_ones);
    RC_ASSERT(evaluations == kPopulation);
    for (int generation = 0; generation < 30; ++generation) {
      const std::int64_t best = population.individual[0].score;
      evaluations = 0;
      evolve_generation(population, settings, random, count_ones);
      RC_ASSERT(evaluations == kPopulation - settings.survivors);
      RC_ASSERT(population.individual[0].score >= best);
      for (const Individual& individual : population.individual) {
        RC_ASSERT(individual.score == count_ones(individual.chromosome));
      }
    }
  }));
}

TEST(Evolution, FoundsFromTheFittestOfWhatIsDrawn) {
  ASSERT_TRUE(rc::check([](std::uint64_t seed) {
    const int founders = *rc::gen::inRange(1, 6);
    CounterRandom random(seed, 9);
    std::vector<std::int64_t> fittest;
    int draws = 0;
    const auto score = [](const Chromosome& c) { return static_cast<std::int64_t>(c.low >> 1); };
    Population population;
    found_population_from(
        population, founders,
        [&] {
          const Chromosome drawn = random_chromosome(random);
          if (draws % founders == 0) fittest.push_back(score(drawn));
          fittest.back() = std::max(fittest.back(), score(drawn));
          ++draws;
          return drawn;
        },
        score);
    RC_ASSERT(draws == kPopulation * founders);
    std::sort(fittest.rbegin(), fittest.rend());
    for (unsigned i = 0; i < kPopulation; ++i) RC_ASSERT(population.individual[i].score == fittest[i]);
  }));
}

TEST(Evolution, DrawsTheSameRandomNumbersWhateverTheScores) {
  const auto position_after = [](auto&& score) {
    CounterRandom random(1, 2);
    Population population;
    found_population(population, 1, random, score);
    for (int i = 0; i < 20; ++i) evolve_generation(population, GaSettings{}, random, score);
    return random.position();
  };
  EXPECT_EQ(position_after([](const Chromosome&) { return std::int64_t{0}; }),
            position_after([](const Chromosome& c) { return static_cast<std::int64_t>(c.low >> 1); }));
}

TEST(SearchBox, RefusesWhatCannotBeSearched) {
  SearchBox box;
  EXPECT_EQ(check(box), Status::kOk);
  box.half_range[2] = 0;
  EXPECT_EQ(check(box), Status::kBadSearchBox);
  box = {};
  box.centre[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(check(box), Status::kBadSearchBox);
  box = {};
  box.centre[4] = 1.0;
  EXPECT_EQ(check(box), Status::kBadSearchBox);
}

}  // namespace
}  // namespace vergence
