// One number proves behaviour unchanged: the bits of every estimate of a few runs, hashed. The number is the
// same on every instruction set, on x86-64 and on arm64. Where a change of behaviour is meant, replace the
// numbers by those the test prints, and say why in the commit.
#include <gtest/gtest.h>

#include <bit>

#include "tests/differential/every_target.hpp"
#include "tests/support/small_world.hpp"

namespace vergence {
namespace {

class Signature {
 public:
  void add(std::uint64_t value) {  // FNV-1a over bytes
    for (int i = 0; i < 8; ++i) {
      hash_ ^= (value >> (8 * i)) & 0xFF;
      hash_ *= 0x100000001B3ULL;
    }
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Estimate& e) {
    for (int i = 0; i < 3; ++i) {
      add(e.pose.position_mm[i]);
      add(e.pose.e[i]);
    }
    add(e.fitness);
    add(e.confidence);
    add(static_cast<std::uint64_t>(e.state));
    add(static_cast<std::uint64_t>(e.evaluations));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

struct Golden {
  TargetKind kind;
  Method method;
  std::uint64_t signature;
};

class GoldenTest : public ::testing::TestWithParam<Golden> {};

INSTANTIATE_TEST_SUITE_P(
    Runs, GoldenTest,
    ::testing::Values(Golden{TargetKind::kMarker, Method::kThesis, 0xC622CA858F364EA9ULL},
                      Golden{TargetKind::kMarker, Method::kVergence, 0xA936830405AF95DDULL},
                      Golden{TargetKind::kPhoto, Method::kThesis, 0xDD9DAB3457DF6EEBULL},
                      Golden{TargetKind::kPhoto, Method::kVergence, 0x69369F371659F8C0ULL}));

TEST_P(GoldenTest, EstimatesKeepTheirBits) {
  for_every_target([] {
    Signature signature;
    testing::Bench bench(testing::World(GetParam().kind), 7, GetParam().method);
    for (int frame = 0; frame < 4; ++frame) {
      const Transform truth = to_transform({{10.0 + 3 * frame, -5, 480}, {0.05, -0.1, 0.08}});
      signature.add(bench.step(truth, frame == 0 ? 200 : 40));
    }
    EXPECT_EQ(signature.value(), GetParam().signature)
        << "0x" << std::hex << std::uppercase << signature.value() << "ULL";
  });
}

}  // namespace
}  // namespace vergence
