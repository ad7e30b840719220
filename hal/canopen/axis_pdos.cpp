#include "hal/canopen/axis_pdos.hpp"

#include "hal/canopen/objects.hpp"

namespace vergence::canopen {
namespace {

PdoConfig pdo_of(const CanopenAxisConfig& axis, PdoDirection direction, std::uint8_t number,
                 std::uint32_t cob_id, std::uint8_t transmission) {
  PdoConfig pdo;
  pdo.direction = direction;
  pdo.number = number;
  pdo.cob_id = cob_id != 0 ? cob_id : default_pdo_cob_id(direction, number, axis.node_id);
  pdo.transmission = transmission;
  return pdo;
}

PdoConfig pdo_of(const CanopenAxisConfig& axis, PdoDirection direction, std::uint8_t number,
                 std::uint32_t cob_id, std::uint8_t transmission, const PdoEntry& entry) {
  PdoConfig pdo = pdo_of(axis, direction, number, cob_id, transmission);
  pdo.entries.add(entry);
  return pdo;
}

const CanopenAxisConfig& axis_of(const CanopenArmConfig& config, int axis) {
  return config.axis[static_cast<std::size_t>(axis)];
}

// The axes whose targets travel in the frame of `leader`, in their order.
FixedList<int, kTargetsPerFrame> targets_of(const CanopenArmConfig& config, int leader) {
  FixedList<int, kTargetsPerFrame> axes;
  for (int i = leader; i < config.axes && axes.size() < kTargetsPerFrame; ++i) {
    if (i == leader || (config.share_targets && axis_of(config, i).bus == axis_of(config, leader).bus)) {
      axes.add(i);
    }
  }
  return axes;
}

// Of two axes in a frame each maps its own half and a dummy in place of the other's, so that the frame has
// the length both expect.
PdoConfig target_pdo(const CanopenArmConfig& config, int axis_number) {
  const int leader = target_leader(config, axis_number);
  const CanopenAxisConfig& axis = axis_of(config, leader);
  const std::uint16_t target = config.mode == CyclicMode::kVelocity ? kTargetVelocity : kTargetPosition;
  PdoConfig pdo = pdo_of(axis, PdoDirection::kToDrive, 1, axis.rpdo1_cob_id, kEverySync);
  for (const int i : targets_of(config, leader)) {
    pdo.entries.add({i == axis_number ? target : kDummyUnsigned32, 0, 8 * kTargetBytes});
  }
  return pdo;
}

}  // namespace

int target_leader(const CanopenArmConfig& config, int axis) {
  if (!config.share_targets) return axis;
  int before = 0;  // on the same bus
  int last = axis;
  for (int i = 0; i < axis; ++i) {
    if (axis_of(config, i).bus != axis_of(config, axis).bus) continue;
    ++before;
    last = i;
  }
  return before % kTargetsPerFrame == 0 ? axis : last;
}

std::uint8_t target_offset(const CanopenArmConfig& config, int axis) {
  return target_leader(config, axis) == axis ? 0 : kTargetBytes;
}

AxisPdos axis_pdos(const CanopenArmConfig& config, int axis_number) {
  const CanopenAxisConfig& axis = axis_of(config, axis_number);
  AxisPdos pdos;
  pdos.target = target_pdo(config, axis_number);
  pdos.controlword =
      pdo_of(axis, PdoDirection::kToDrive, 2, axis.rpdo2_cob_id, kOnEvent, {kControlword, 0, 16});
  pdos.position =
      pdo_of(axis, PdoDirection::kFromDrive, 1, axis.tpdo1_cob_id, kEverySync, {kPositionActual, 0, 32});
  pdos.statusword =
      pdo_of(axis, PdoDirection::kFromDrive, 2, axis.tpdo2_cob_id, kOnEvent, {kStatusword, 0, 16});
  // A bit that flickers must not fill the bus, and a change that was lost must show.
  pdos.statusword.inhibit_ns = config.sync_period_ns;
  pdos.statusword.event_timer_ns = config.statusword_timer_ns;
  return pdos;
}

}  // namespace vergence::canopen
