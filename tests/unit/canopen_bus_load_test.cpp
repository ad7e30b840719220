// The load of the bus: how long a frame may become, and that what is counted is what travels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/bus_load.hpp"
#include "tests/support/canopen_robot.hpp"
#include "tests/support/random.hpp"

namespace vergence::canopen {
namespace {

using testing::CanopenRobot;
using testing::config_of_drives;
using testing::config_of_two_buses;
using testing::Random;

constexpr std::int64_t kBitPerS = 1'000'000;

// A frame bit by bit [ISO 11898-1], stuffed as a controller does it: after five equal bits one of the other
// kind, which counts for the next five. From the start of frame to the pause after it.
std::int64_t bits_on_the_wire(std::uint32_t id, std::span<const std::uint8_t> data) {
  std::array<bool, 128> bits{};
  std::size_t count = 0;
  const auto put = [&](std::uint32_t value, int width) {
    for (int bit = width - 1; bit >= 0; --bit) bits[count++] = (value >> bit & 1) != 0;
  };
  put(0, 1);  // start of frame
  put(id, 11);
  put(0, 3);  // no remote frame, no extension, reserved
  put(static_cast<std::uint32_t>(data.size()), 4);
  for (const std::uint8_t byte : data) put(byte, 8);
  std::uint32_t crc = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool feedback = bits[i] != ((crc >> 14 & 1) != 0);
    crc = (crc << 1 & 0x7FFF) ^ (feedback ? 0x4599U : 0U);
  }
  put(crc, 15);
  std::int64_t stuffed = 0;
  int run = 0;
  bool last = true;  // of the idle bus, which does not count
  for (std::size_t i = 0; i < count; ++i) {
    run = i > 0 && bits[i] == last ? run + 1 : 1;
    last = bits[i];
    if (run < 5) continue;
    ++stuffed;
    last = !last;
    run = 1;
  }
  // Delimiter of the checksum, acknowledgement and its delimiter, end of frame, pause.
  return static_cast<std::int64_t>(count) + stuffed + 1 + 2 + 7 + 3;
}

// Frames of which many have five equal bits again and again.
void expect_none_is_longer(std::size_t size, std::int64_t& longest) {
  Random random(17 + size);
  std::array<std::uint8_t, 8> data{};
  const auto try_frame = [&](std::uint32_t id) {
    const std::int64_t bits = bits_on_the_wire(id, std::span(data).first(size));
    longest = std::max(longest, bits);
    ASSERT_LE(bits, longest_frame_bits(static_cast<std::int64_t>(size))) << id;
  };
  for (int i = 0; i < 300'000; ++i) {
    // Five of a kind, then four and four in turn, is the most there can be; some bits of it are turned.
    const int phase = random.below(8);
    const int turned = random.below(4);
    std::uint32_t id = 0;
    for (int bit = 0; bit < 11; ++bit) id |= static_cast<std::uint32_t>((bit + phase) / 4 % 2) << bit;
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      const auto at =
          bit + static_cast<std::size_t>(random.below(8) == 0 ? 1 : 0) + static_cast<std::size_t>(phase);
      const auto mask = static_cast<std::uint8_t>(0x80 >> bit % 8);
      data[bit / 8] =
          static_cast<std::uint8_t>(at / 4 % 2 == 0 ? data[bit / 8] & ~mask : data[bit / 8] | mask);
    }
    for (int k = 0; k < turned && size > 0; ++k) {
      data[static_cast<std::size_t>(random.below(static_cast<int>(size)))] ^=
          static_cast<std::uint8_t>(1 << random.below(8));
    }
    if (i % 3 == 0) id = static_cast<std::uint32_t>(random.below(0x800));
    try_frame(id);
  }
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t noise = random.bits();
    for (std::size_t byte = 0; byte < size; ++byte) data[byte] = static_cast<std::uint8_t>(noise >> 8 * byte);
    try_frame(static_cast<std::uint32_t>(random.below(0x800)));
  }
}

TEST(BusLoadTest, AFrameIsAsLongAsTheStandardSays) {
  EXPECT_EQ(longest_frame_bits(0), 55);
  EXPECT_EQ(longest_frame_bits(4), 95);
  EXPECT_EQ(longest_frame_bits(8), 135);
  // Where bits alternate, only the head and the checksum can be stuffed.
  const std::array<std::uint8_t, 8> calm = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55};
  EXPECT_LE(bits_on_the_wire(0x555, calm), 47 + 64 + 4);
}

// Every identifier there is, alone and with every byte; beyond that, at random and by design.
TEST(BusLoadTest, NoFrameIsLongerThanTheLongest) {
  std::int64_t longest = 0;
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    longest = std::max(longest, bits_on_the_wire(id, {}));
    for (int byte = 0; byte < 256; ++byte) {
      const std::array<std::uint8_t, 1> data = {static_cast<std::uint8_t>(byte)};
      ASSERT_LE(bits_on_the_wire(id, data), longest_frame_bits(1)) << id << " " << byte;
    }
  }
  EXPECT_LE(longest, longest_frame_bits(0));
  for (const std::size_t size : {2U, 4U, 6U, 8U}) {
    longest = 0;
    expect_none_is_longer(size, longest);
    // And not much is given away.
    EXPECT_GE(longest, longest_frame_bits(static_cast<std::int64_t>(size)) - 4) << size;
  }
}

TEST(BusLoadTest, SevenAxesFitAt500HzAndNotAt1kHz) {
  CanopenArmConfig config = config_of_drives();
  ASSERT_EQ(check(config).finding, ConfigFinding::kNone);
  for (const CyclicMode mode : {CyclicMode::kVelocity, CyclicMode::kPosition}) {
    config.mode = mode;
    // 55 + 14 * 95 bits each 2 ms, 8 heartbeats of 65 each 20 ms, 7 statuswords of 75 each 100 ms.
    EXPECT_EQ(bus_load_permille(config, 0, kBitPerS), (692'500 + 26'000 + 5'250) / 1000);
  }
  EXPECT_LT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
  config.sync_period_ns = 1'000'000;
  ASSERT_EQ(check(config).finding, ConfigFinding::kNone);
  EXPECT_GT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
  config.axes = 4;
  EXPECT_GT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
  config.axes = 3;
  EXPECT_LT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
  config.axes = 7;
  config.sync_period_ns = 2'000'000;
  EXPECT_GT(bus_load_permille(config, 0, kBitPerS / 2), kMostBusLoad_permille);
}

// The arithmetic of docs/canopen.md: what a drive of its own frame costs, and what one that shares it.
TEST(BusLoadTest, SevenAxesFitAt1kHzOverTwoBusesThatShareTargets) {
  CanopenArmConfig config = config_of_two_buses();
  ASSERT_EQ(check(config).finding, ConfigFinding::kNone);
  for (const CyclicMode mode : {CyclicMode::kVelocity, CyclicMode::kPosition}) {
    config.mode = mode;
    // SYNC 55, 4 positions of 95, 2 frames of two targets of 135 each ms, 5 heartbeats, 4 statuswords.
    EXPECT_EQ(bus_load_permille(config, 0, kBitPerS), (705'000 + 16'250 + 3'000) / 1000);
    // SYNC 55, 3 positions of 95, a frame of two targets and one of one each ms, 4 heartbeats, 3 statuswords.
    EXPECT_EQ(bus_load_permille(config, 1, kBitPerS), (570'000 + 13'000 + 2'250) / 1000);
  }
  config.axis[4].bus = 0;
  config.axis[4].node_id = 15;
  EXPECT_EQ(bus_load_permille(config, 0, kBitPerS), (895'000 + 19'500 + 3'750) / 1000);  // five are too many
  config.axis[4].bus = 1;
  config.share_targets = false;
  EXPECT_EQ(bus_load_permille(config, 0, kBitPerS), (815'000 + 16'250 + 3'000) / 1000);
  EXPECT_GT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
  EXPECT_LT(bus_load_permille(config, 1, kBitPerS), kMostBusLoad_permille);
  // Sharing alone is not enough for one bus at 1 kHz, and spares a tenth of it at 500 Hz.
  config = config_of_drives();
  config.share_targets = true;
  EXPECT_EQ(bus_load_permille(config, 0, kBitPerS), (610'000 + 26'000 + 5'250) / 1000);
  config.sync_period_ns = 1'000'000;
  EXPECT_GT(bus_load_permille(config, 0, kBitPerS), kMostBusLoad_permille);
}

// Frames counted on the bus, each taken as its longest: over a second of steady motion that is the load.
TEST(BusLoadTest, IsWhatTravels) {
  for (const int axes : {7, 4}) {
    CanopenArmConfig config = config_of_drives();
    config.axes = axes;
    config.statusword_timer_ns = 50'000'000;
    CanopenRobot robot(config);
    ASSERT_TRUE(robot.move(0.2));
    (void)robot.heard();
    std::int64_t bits = 0;
    for (int period = 0; period < 500; ++period) {
      robot.period();
      for (const CanFrame& frame : robot.heard()) bits += longest_frame_bits(frame.size);
    }
    EXPECT_NEAR(static_cast<double>(bits) / 1000, static_cast<double>(bus_load_permille(config, 0, kBitPerS)),
                1.001);
  }
}

TEST(BusLoadTest, IsWhatTravelsOnEachOfTwoBuses) {
  CanopenArmConfig config = config_of_two_buses();
  config.statusword_timer_ns = 50'000'000;
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.move(0.2));
  std::array<std::int64_t, 2> bits{};
  for (const int bus : {0, 1}) (void)robot.heard(bus);
  for (int period = 0; period < 1000; ++period) {
    robot.period();
    for (const int bus : {0, 1}) {
      for (const CanFrame& frame : robot.heard(bus)) {
        bits[static_cast<std::size_t>(bus)] += longest_frame_bits(frame.size);
      }
    }
  }
  for (const int bus : {0, 1}) {
    EXPECT_NEAR(static_cast<double>(bits[static_cast<std::size_t>(bus)]) / 1000,
                static_cast<double>(bus_load_permille(config, bus, kBitPerS)), 1.001)
        << bus;
  }
}

// What a drive is told to map is what is counted.
class BusLoadMappingTest : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Targets, BusLoadMappingTest, ::testing::Bool(),
                         [](const auto& shared) { return shared.param ? "Shared" : "OfTheirOwn"; });

TEST_P(BusLoadMappingTest, CountsWhatDrivesAreToldToMap) {
  const CanopenArmConfig config = GetParam() ? config_of_two_buses() : config_of_drives();
  CanopenRobot robot(config);
  ASSERT_TRUE(robot.boot());
  for (int i = 0; i < config.axes; ++i) {
    const DriveObjects& objects = robot.drives[static_cast<std::size_t>(i)].objects();
    const AxisPdos pdos = axis_pdos(config, i);
    for (const PdoConfig* pdo : pdos.all()) {
      const int base = pdo->direction == PdoDirection::kToDrive ? 0x1400 : 0x1800;
      const auto communication = static_cast<std::uint16_t>(base + pdo->number - 1);
      const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
      std::uint32_t mapped_bits = 0;
      for (std::uint32_t entry = 1; entry <= objects.number(mapping, 0); ++entry) {
        mapped_bits += objects.number(mapping, static_cast<std::uint8_t>(entry)) & 0xFF;
      }
      EXPECT_EQ(mapped_bits, 8 * pdo_bytes(*pdo));
      EXPECT_EQ(objects.number(communication, 1) & 0x7FF, pdo->cob_id);
      EXPECT_EQ(objects.number(communication, 2), pdo->transmission);
    }
  }
}

}  // namespace
}  // namespace vergence::canopen
