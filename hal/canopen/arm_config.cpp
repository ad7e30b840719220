#include "hal/canopen/arm_config.hpp"

#include <algorithm>
#include <cmath>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/nmt.hpp"

namespace vergence::canopen {
namespace {

constexpr double kMaxInteger = 2147483647.0;
constexpr std::int64_t kNsPerMs = 1'000'000;

bool is_positive(double x) {
  return x > 0 && std::isfinite(x);
}

// Both ends inside what 32 bits hold.
bool fits(double rad, const CanopenAxisConfig& axis) {
  return std::abs(rad * axis.counts_per_rad + axis.zero_counts) <= kMaxInteger;
}

bool is_cob_id(std::uint32_t cob_id) {
  return cob_id >= 0x181 && cob_id <= 0x57F;
}

// 16 bits of milliseconds, as heartbeats have it.
bool is_heartbeat_time(std::int64_t ns) {
  return ns >= kNsPerMs && ns <= 0xFFFF * kNsPerMs && ns % kNsPerMs == 0;
}

ConfigFinding check(const CanopenAxisConfig& axis) {
  if (axis.node_id < 1 || axis.node_id > kMaxNodeId) return ConfigFinding::kNodeId;
  const double counts = axis.counts_per_rad;
  const double units = axis.velocity_units_per_rad_per_s;
  if (!is_positive(std::abs(counts)) || !is_positive(std::abs(units)) || (counts > 0) != (units > 0)) {
    return ConfigFinding::kScale;
  }
  if (!std::isfinite(axis.min_rad) || !std::isfinite(axis.max_rad) || !(axis.min_rad < axis.max_rad) ||
      !fits(axis.min_rad, axis) || !fits(axis.max_rad, axis)) {
    return ConfigFinding::kRange;
  }
  const bool limits_positive = is_positive(axis.max_velocity_rad_per_s) &&
                               is_positive(axis.quick_stop_rad_per_s2) &&
                               is_positive(axis.following_error_rad);
  if (!limits_positive || std::abs(axis.max_velocity_rad_per_s * units) > kMaxInteger ||
      std::abs(axis.quick_stop_rad_per_s2 * units) > kMaxInteger ||
      std::abs(axis.following_error_rad * counts) > kMaxInteger) {
    return ConfigFinding::kLimit;
  }
  return ConfigFinding::kNone;
}

using CobIds = FixedList<std::uint32_t, 4 * kMaxJoints>;

// In range, and not those of an axis before it on this bus; but for the target, which two may share.
ConfigFinding check_cob_ids(const CanopenArmConfig& config, int axis, CobIds& taken) {
  const AxisPdos pdos = axis_pdos(config, axis);
  for (const PdoConfig* pdo : pdos.all()) {
    if (!is_cob_id(pdo->cob_id)) return ConfigFinding::kCobId;
    if (pdo == &pdos.target && target_leader(config, axis) != axis) continue;
    if (std::find(taken.begin(), taken.end(), pdo->cob_id) != taken.end()) return ConfigFinding::kCobIdTwice;
    taken.add(pdo->cob_id);
  }
  return ConfigFinding::kNone;
}

// Every axis on a bus there may be, and no bus without an axis.
ConfigResult check_buses(const CanopenArmConfig& config) {
  for (int bus = 0; bus < bus_count(config); ++bus) {
    bool is_used = false;
    for (int i = 0; i < config.axes; ++i) {
      const int its = config.axis[static_cast<std::size_t>(i)].bus;
      if (its >= kMaxBuses) return {ConfigFinding::kBus, i};
      is_used = is_used || its == bus;
    }
    if (!is_used) return {ConfigFinding::kBus, -1};
  }
  return {};
}

}  // namespace

int bus_count(const CanopenArmConfig& config) {
  int last = 0;
  for (int i = 0; i < config.axes && i < kMaxJoints; ++i) {
    last = std::max<int>(last, config.axis[static_cast<std::size_t>(i)].bus);
  }
  return last + 1;
}

ConfigResult check(const CanopenArmConfig& config) {
  if (config.axes < 1 || config.axes > kMaxJoints) return {ConfigFinding::kAxes, -1};
  if (config.master_node_id < 1 || config.master_node_id > kMaxNodeId) return {ConfigFinding::kNodeId, -1};
  if (const ConfigResult found = check_buses(config); found.finding != ConfigFinding::kNone) return found;
  std::array<CobIds, kMaxBuses> cob_ids;
  for (int i = 0; i < config.axes; ++i) {
    const CanopenAxisConfig& axis = config.axis[static_cast<std::size_t>(i)];
    if (const ConfigFinding own = check(axis); own != ConfigFinding::kNone) return {own, i};
    if (axis.node_id == config.master_node_id) return {ConfigFinding::kNodeIdTwice, i};
    for (int j = 0; j < i; ++j) {
      const CanopenAxisConfig& other = config.axis[static_cast<std::size_t>(j)];
      if (axis.bus == other.bus && axis.node_id == other.node_id) return {ConfigFinding::kNodeIdTwice, i};
    }
    const ConfigFinding finding = check_cob_ids(config, i, cob_ids[axis.bus]);
    if (finding != ConfigFinding::kNone) return {finding, i};
  }
  constexpr std::int64_t kStep_ns = 100'000;
  if (config.sync_period_ns < kStep_ns || config.sync_period_ns > 255 * kStep_ns ||
      config.sync_period_ns % kStep_ns != 0) {
    return {ConfigFinding::kPeriod, -1};
  }
  if (!is_heartbeat_time(config.heartbeat_ns) || !is_heartbeat_time(config.heartbeat_timeout_ns) ||
      config.heartbeat_timeout_ns < config.heartbeat_ns + config.sync_period_ns) {
    return {ConfigFinding::kHeartbeat, -1};
  }
  if (!is_heartbeat_time(config.statusword_timer_ns) ||
      config.statusword_timer_ns < 2 * config.sync_period_ns) {
    return {ConfigFinding::kStatuswordTimer, -1};
  }
  if (config.boot_timeout_ns <= 0 || config.sdo_timeout_ns <= 0 || config.enable_timeout_ns <= 0 ||
      config.stop_timeout_ns <= 0) {
    return {ConfigFinding::kTimeout, -1};
  }
  if (config.tolerated_missing_pdos < 0 || config.tolerated_missing_pdos > 1 ||
      config.most_missed_commands < 0 || !is_positive(config.rest_rad_per_s) ||
      (config.must_be_homed && !config.read_homing)) {
    return {ConfigFinding::kTolerance, -1};
  }
  return {};
}

const char* describe(ConfigFinding finding) {
  switch (finding) {
    case ConfigFinding::kNone: return "ok";
    case ConfigFinding::kAxes: return "the number of axes is not 1 to 7";
    case ConfigFinding::kNodeId: return "a node id is not 1 to 127";
    case ConfigFinding::kNodeIdTwice: return "two nodes of a bus have the same id";
    case ConfigFinding::kScale: return "a scale is zero or not finite, or the two of an axis differ in sign";
    case ConfigFinding::kRange:
      return "the range of an axis is empty, not finite or beyond 32 bits of counts";
    case ConfigFinding::kLimit: return "a limit of an axis is not positive, not finite or beyond 32 bits";
    case ConfigFinding::kCobId: return "the COB-ID of a PDO is not 0x181 to 0x57F";
    case ConfigFinding::kCobIdTwice: return "two PDOs of a bus have the same COB-ID";
    case ConfigFinding::kPeriod: return "the SYNC period is not a multiple of 0.1 ms up to 25.5 ms";
    case ConfigFinding::kHeartbeat:
      return "a heartbeat time is not 1 to 65535 whole ms, or the timeout not a period longer than the beat";
    case ConfigFinding::kStatuswordTimer:
      return "the statusword's event timer is not 1 to 65535 whole ms, or less than two SYNC periods";
    case ConfigFinding::kTimeout: return "a timeout is not positive";
    case ConfigFinding::kTolerance:
      return "a tolerance is outside its range, or homing is demanded but not to be read";
    case ConfigFinding::kBus: return "an axis is on a bus that cannot be, or a bus has no axis";
  }
  return "unknown finding";
}

std::size_t receive_filters(const CanopenArmConfig& config, int bus,
                            std::span<CanFilter, kMaxFilters> filters) {
  std::size_t count = 0;
  for (int i = 0; i < config.axes && i < kMaxJoints; ++i) {
    const CanopenAxisConfig& axis = config.axis[static_cast<std::size_t>(i)];
    if (axis.bus != bus) continue;
    const AxisPdos pdos = axis_pdos(config, i);
    filters[count++] = {pdos.position.cob_id, 0x7FF};
    filters[count++] = {pdos.statusword.cob_id, 0x7FF};
    filters[count++] = {kSdoResponseCobId + axis.node_id, 0x7FF};
    filters[count++] = {kEmergencyCobId + axis.node_id, 0x7FF};
    filters[count++] = {kHeartbeatCobId + axis.node_id, 0x7FF};
  }
  return count;
}

}  // namespace vergence::canopen
