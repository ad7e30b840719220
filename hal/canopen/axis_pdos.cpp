#include "hal/canopen/axis_pdos.hpp"

#include "hal/canopen/objects.hpp"

namespace vergence::canopen {
namespace {

PdoConfig pdo_of(const CanopenAxisConfig& axis, PdoDirection direction, std::uint8_t number,
                 std::uint32_t cob_id, std::uint8_t transmission, const PdoEntry& entry) {
  PdoConfig pdo;
  pdo.direction = direction;
  pdo.number = number;
  pdo.cob_id = cob_id != 0 ? cob_id : default_pdo_cob_id(direction, number, axis.node_id);
  pdo.transmission = transmission;
  pdo.entries.add(entry);
  return pdo;
}

}  // namespace

AxisPdos axis_pdos(const CanopenArmConfig& config, int axis_number) {
  const CanopenAxisConfig& axis = config.axis[static_cast<std::size_t>(axis_number)];
  const std::uint16_t target = config.mode == CyclicMode::kVelocity ? kTargetVelocity : kTargetPosition;
  AxisPdos pdos;
  pdos.target = pdo_of(axis, PdoDirection::kToDrive, 1, axis.rpdo1_cob_id, kEverySync, {target, 0, 32});
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
