#include "hal/canopen/boot_script.hpp"

#include <cmath>

#include "hal/canopen/axis_pdos.hpp"
#include "hal/canopen/objects.hpp"

namespace vergence::canopen {
namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;

class Writer {
 public:
  void write(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
    script.add({BootStepKind::kWrite, {index, sub, size, value}});
  }
  void write_if_there(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
    script.add({BootStepKind::kWriteIfThere, {index, sub, size, value}});
  }
  void expect(std::uint16_t index, std::uint8_t sub, std::uint32_t value, std::uint32_t mask) {
    script.add({BootStepKind::kExpect, {index, sub, 4, value}, mask});
  }
  void write_pdo(const PdoConfig& pdo) {
    for (const SdoWrite& object : pdo_writes(pdo)) {
      const auto kind = object.may_be_missing ? BootStepKind::kWriteIfThere : BootStepKind::kWrite;
      script.add({kind, object});
    }
  }

  BootScript script;
};

std::uint32_t milliseconds(std::int64_t ns) {
  return static_cast<std::uint32_t>(ns / kNsPerMs);
}

std::uint32_t whole(double x) {
  return static_cast<std::uint32_t>(std::llround(std::abs(x)));
}

void write_interpolation_period(std::int64_t period_ns, Writer& writer) {
  const bool whole_ms = period_ns % kNsPerMs == 0;
  const auto units = static_cast<std::uint32_t>(period_ns / (whole_ms ? kNsPerMs : kNsPerMs / 10));
  const auto exponent = static_cast<std::uint8_t>(whole_ms ? -3 : -4);  // two's complement
  writer.write_if_there(kInterpolationPeriod, 1, 1, units);
  writer.write_if_there(kInterpolationPeriod, 2, 1, exponent);
}

}  // namespace

bool is_statusword_timer(const BootStep& step) {
  return step.object.index == kTpdoCommunication + 1 && step.object.sub == kPdoTimerSub;
}

BootScript boot_script(const CanopenArmConfig& config, int axis_number) {
  const CanopenAxisConfig& axis = config.axis[static_cast<std::size_t>(axis_number)];
  Writer writer;
  writer.expect(kDeviceType, 0, kDriveProfile, 0xFFFF);
  if (axis.vendor_id != 0) writer.expect(kIdentity, 1, axis.vendor_id, 0xFFFFFFFF);

  // A drive that is left alone stops by itself: without the master's heartbeat, and where it can, without
  // SYNC.
  writer.write(kHeartbeatProducer, 0, 2, milliseconds(config.heartbeat_ns));
  writer.write_if_there(
      kHeartbeatConsumer, 1, 4,
      std::uint32_t{config.master_node_id} << 16 | milliseconds(config.heartbeat_timeout_ns));
  writer.write_if_there(kCyclePeriod, 0, 4, static_cast<std::uint32_t>(config.sync_period_ns / 1000));
  writer.write_if_there(kAbortConnectionOption, 0, 2, kAbortConnectionQuickStop);
  writer.write_if_there(kQuickStopOption, 0, 2, kQuickStopAndStay);
  writer.write(kQuickStopDeceleration, 0, 4,
               whole(axis.quick_stop_rad_per_s2 * axis.velocity_units_per_rad_per_s));
  writer.write_if_there(kFollowingErrorWindow, 0, 4, whole(axis.following_error_rad * axis.counts_per_rad));
  writer.write_if_there(kFollowingErrorTime, 0, 2, 0);

  // The bits that say it are those of homing in homing mode only.
  if (config.read_homing) {
    writer.write(kModeOfOperation, 0, 1, kModeHoming);
    writer.script.add({BootStepKind::kReadHoming, {kStatusword, 0, 2, 0}});
  }
  const std::uint8_t mode = config.mode == CyclicMode::kVelocity ? kModeCyclicVelocity : kModeCyclicPosition;
  writer.write(kModeOfOperation, 0, 1, mode);
  writer.expect(kModeDisplay, 0, mode, 0xFF);
  write_interpolation_period(config.sync_period_ns, writer);

  const AxisPdos pdos = axis_pdos(config, axis_number);
  for (const PdoConfig* pdo : pdos.all()) writer.write_pdo(*pdo);
  // The others would only take room on the bus.
  for (std::uint8_t number = 3; number <= kPdos; ++number) {
    for (const PdoDirection direction : {PdoDirection::kToDrive, PdoDirection::kFromDrive}) {
      writer.script.add({BootStepKind::kWriteIfThere, pdo_off(direction, number, axis.node_id)});
    }
  }
  return writer.script;
}

}  // namespace vergence::canopen
