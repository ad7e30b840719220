// What the master must be told of an arm's drives and their bus.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <span>

#include "algo/limits.hpp"
#include "hal/canopen/can_frame.hpp"

namespace vergence::canopen {

enum class CyclicMode : std::uint8_t {
  kVelocity,
  kPosition,  // velocities are summed up here
};

// Each is a network of its own: node ids and COB-IDs are unique on one of them.
inline constexpr int kMaxBuses = 2;

struct CanopenAxisConfig {
  std::uint8_t node_id = 0;  // 1 to 127
  std::uint8_t bus = 0;      // from 0
  // Counts of the encoder per radian of the joint, gear included; negative where the two turn opposite ways.
  double counts_per_rad = 0x1p20 / (2 * std::numbers::pi);
  std::int32_t zero_counts = 0;  // where the joint's angle is zero
  // Units of object 0x60FF per rad/s, with the sign of counts_per_rad; of 0x6085 per rad/s^2, without.
  double velocity_units_per_rad_per_s = 0x1p20 / (2 * std::numbers::pi);
  double min_rad = -std::numbers::pi;  // at an end, no velocity leads outwards
  double max_rad = std::numbers::pi;
  double max_velocity_rad_per_s = 2;  // commands beyond it are clamped
  double quick_stop_rad_per_s2 = 20;
  double following_error_rad = 0.1;
  std::uint32_t rpdo1_cob_id = 0;  // of the target; 0: 0x200 + node, the standard's default
  std::uint32_t rpdo2_cob_id = 0;  // of the controlword; 0: 0x300 + node
  std::uint32_t tpdo1_cob_id = 0;  // of the position; 0: 0x180 + node
  std::uint32_t tpdo2_cob_id = 0;  // of the statusword; 0: 0x280 + node
  std::uint32_t vendor_id = 0;     // 0: any
};

struct CanopenArmConfig {
  int axes = kMaxJoints;
  std::array<CanopenAxisConfig, kMaxJoints> axis{};
  CyclicMode mode = CyclicMode::kVelocity;
  // Of two axes in one frame, where there are two on a bus; drives must know dummy entries [CiA 301].
  bool share_targets = false;
  bool read_homing = true;     // some drives do not tell; then neither can be asked for
  bool must_be_homed = false;  // otherwise it is a fault
  std::uint8_t master_node_id = 127;
  std::int64_t sync_period_ns = 2'000'000;  // multiples of 0.1 ms up to 25.5 ms
  std::int64_t heartbeat_ns = 20'000'000;   // of drives and master; whole milliseconds
  std::int64_t heartbeat_timeout_ns = 50'000'000;
  std::int64_t statusword_timer_ns = 100'000'000;  // whole milliseconds; comes so often without a change
  std::int64_t boot_timeout_ns = 5'000'000'000;
  std::int64_t sdo_timeout_ns = 500'000'000;
  std::int64_t enable_timeout_ns = 3'000'000'000;  // brakes are released meanwhile
  std::int64_t stop_timeout_ns = 2'000'000'000;    // a quick stop that takes longer is given up waiting for
  double rest_rad_per_s = 0.02;
  int tolerated_missing_pdos = 0;  // in a row; 0 or 1
  int most_missed_commands = 2;    // periods in a row without a command while enabled
};

enum class ConfigFinding : std::uint8_t {
  kNone,
  kAxes,
  kNodeId,
  kNodeIdTwice,
  kScale,
  kRange,
  kLimit,
  kCobId,
  kCobIdTwice,
  kPeriod,
  kHeartbeat,
  kStatuswordTimer,
  kTimeout,
  kTolerance,
  kBus,
};

struct ConfigResult {
  ConfigFinding finding = ConfigFinding::kNone;
  int axis = -1;  // from 0; -1: none in particular
};

[[nodiscard]] ConfigResult check(const CanopenArmConfig& config);
[[nodiscard]] const char* describe(ConfigFinding finding);

// Buses the axes are on.
[[nodiscard]] int bus_count(const CanopenArmConfig& config);

// What a master must receive on a bus: of each axis there its two PDOs, answers, emergencies and heartbeat.
inline constexpr std::size_t kMaxFilters = 5 * kMaxJoints;
[[nodiscard]] std::size_t receive_filters(const CanopenArmConfig& config, int bus,
                                          std::span<CanFilter, kMaxFilters> filters);

}  // namespace vergence::canopen
