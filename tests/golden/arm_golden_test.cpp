// The bits of the arm's kinematics over a few hundred configurations, hashed: the same on x86-64 and arm64.
// Where a change of behaviour is meant, replace the number by the one the test prints, and say why in the
// commit.
#include <gtest/gtest.h>

#include <bit>

#include "algo/iterative_inverse.hpp"
#include "algo/pa10.hpp"
#include "tests/support/random_arm.hpp"

namespace vergence {
namespace {

class Signature {
 public:
  void add(double value) {  // FNV-1a over bytes
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) {
      hash_ ^= (bits >> (8 * i)) & 0xFF;
      hash_ *= 0x100000001B3ULL;
    }
  }
  template <typename Matrix>
  void add_all(const Matrix& m) {
    for (int i = 0; i < m.size(); ++i) add(m(i % m.rows(), i / m.rows()));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
};

TEST(ArmGolden, KinematicsKeepTheirBits) {
  Signature signature;
  testing::RandomArm random(7);
  for (int n = 0; n < 300; ++n) {
    const SerialArm arm = n % 3 == 0 ? random.arm(4 + n % 4) : pa10();
    JointVector q = random.angles(arm);
    if (n % 5 == 0) q[3] = 0;
    if (n % 7 == 0) q[5] = 0;
    const ArmFrames frames = forward_kinematics(arm, q);
    const ArmJacobian J = geometric_jacobian(arm, frames);
    signature.add_all(frames.T_W_H.R);
    signature.add_all(frames.T_W_H.t_mm);
    signature.add_all(J);
    Vector6 twist;
    twist << random.vector(200), random.vector(1);
    signature.add_all(damped_joint_velocity(arm, J, twist).velocity_rad_per_s);
    const JointVector near = random.near(arm, q, 0.2);
    const IkSolution iterated = solve_ik_damped(arm, frames.T_W_H, near);
    signature.add(static_cast<double>(iterated.result));
    signature.add_all(iterated.q_rad);
    const Pa10Inverse inverse = inverse_pa10(arm, frames.T_W_H, near);
    for (const Pa10Solution& solution : inverse.solutions) signature.add_all(solution.q_rad);
    signature.add(static_cast<double>(inverse.count));
  }
  EXPECT_EQ(signature.value(), 0xC823C5649F3764CAULL)
      << "0x" << std::hex << std::uppercase << signature.value() << "ULL";
}

}  // namespace
}  // namespace vergence
