// Two targets in one frame: whatever axes are on whichever bus, each drive gets its own and no other's, and
// what is counted of a frame is what its drives map of it.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/bus_load.hpp"
#include "hal/canopen/objects.hpp"
#include "tests/support/canopen_robot.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::config_of_two_buses;

// Seven axes spread over two buses at random, neither empty.
CanopenArmConfig any_arm() {
  CanopenArmConfig config = config_of_two_buses();
  config.mode = *rc::gen::element(CyclicMode::kVelocity, CyclicMode::kPosition);
  config.share_targets = *rc::gen::weightedElement<bool>({{4, true}, {1, false}});
  const int mask = *rc::gen::inRange(1, 127);
  for (std::size_t i = 0; i < kMaxJoints; ++i) {
    config.axis[i].bus = static_cast<std::uint8_t>(mask >> i & 1);
    config.axis[i].node_id = static_cast<std::uint8_t>(11 + i);
  }
  return config;
}

RC_GTEST_PROP(CanopenSharedTargets, EachDriveGetsItsOwn, ()) {
  const CanopenArmConfig config = any_arm();
  CanopenRobot robot(config);
  RC_ASSERT(robot.found == ConfigFinding::kNone);
  RC_ASSERT(robot.boot());
  RC_ASSERT(robot.enable());
  for (int step = 0; step < 5; ++step) {
    std::array<double, kMaxJoints> wanted{};
    for (std::size_t i = 0; i < kMaxJoints; ++i) wanted[i] = 0.001 * *rc::gen::inRange(-1500, 1501);
    robot.velocity_rad_per_s = wanted;
    std::array<std::int32_t, kMaxJoints> before{};
    for (std::size_t i = 0; i < kMaxJoints; ++i) {
      before[i] = static_cast<std::int32_t>(robot.drives[i].objects().number(kTargetPosition, 0));
    }
    robot.run(2);  // is sent, and acts with the SYNC after
    for (std::size_t i = 0; i < kMaxJoints; ++i) {
      const DriveObjects& objects = robot.drives[i].objects();
      if (config.mode == CyclicMode::kVelocity) {
        const auto units = static_cast<std::int32_t>(objects.number(kTargetVelocity, 0));
        RC_ASSERT(std::abs(units - wanted[i] * config.axis[i].velocity_units_per_rad_per_s) <= 0.5);
      } else if (step > 0) {
        // One period of the old velocity and one of the new, or two of the new.
        const double most = 2 * 1.5 * std::abs(config.axis[i].counts_per_rad) * 1e-3 + 2;
        const auto counts = static_cast<std::int32_t>(objects.number(kTargetPosition, 0));
        RC_ASSERT(std::abs(counts - before[i]) <= most);
      }
    }
  }
  RC_ASSERT(robot.fault().kind == ArmFaultKind::kNone);
}

// The drives of a frame agree on its length, map disjoint parts, and leave nothing of it unmapped.
RC_GTEST_PROP(CanopenSharedTargets, DrivesOfAFrameMapAllOfItOnce, ()) {
  const CanopenArmConfig config = any_arm();
  RC_ASSERT(check(config).finding == ConfigFinding::kNone);
  std::map<std::pair<int, std::uint32_t>, std::array<int, 8>> mapped;  // how often each byte of a frame is
  std::map<std::pair<int, std::uint32_t>, std::size_t> length;
  for (int i = 0; i < kMaxJoints; ++i) {
    const PdoConfig target = axis_pdos(config, i).target;
    const std::pair<int, std::uint32_t> frame{config.axis[static_cast<std::size_t>(i)].bus, target.cob_id};
    RC_ASSERT(length.try_emplace(frame, pdo_bytes(target)).first->second == pdo_bytes(target));
    RC_ASSERT(!pdo_writes(target).empty());
    std::size_t at = 0;
    for (const PdoEntry& entry : target.entries) {
      const bool is_own = entry.index != kDummyUnsigned32;
      if (is_own) RC_ASSERT(at == target_offset(config, i));
      for (std::size_t byte = 0; byte < entry.bits / 8U; ++byte) mapped[frame][at + byte] += is_own ? 1 : 0;
      at += entry.bits / 8U;
    }
  }
  std::array<std::int64_t, kMaxBuses> target_bits{};
  for (const auto& [frame, bytes] : length) {
    for (std::size_t byte = 0; byte < bytes; ++byte) RC_ASSERT(mapped[frame][byte] == 1);
    target_bits[static_cast<std::size_t>(frame.first)] +=
        longest_frame_bits(static_cast<std::int64_t>(bytes));
  }
  // The load, summed up once more from the frames.
  for (int bus = 0; bus < kMaxBuses; ++bus) {
    const auto axes =
        std::count_if(config.axis.begin(), config.axis.end(), [&](const auto& a) { return a.bus == bus; });
    const std::int64_t a_period =
        longest_frame_bits(0) + axes * longest_frame_bits(4) + target_bits[static_cast<std::size_t>(bus)];
    const std::int64_t a_second =
        1000 * a_period + 50 * (axes + 1) * longest_frame_bits(1) + 10 * axes * longest_frame_bits(2);
    RC_ASSERT(bus_load_permille(config, bus, 1'000'000) == a_second / 1000);
  }
}

}  // namespace
}  // namespace vergence::canopen
