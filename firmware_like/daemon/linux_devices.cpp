#include "firmware_like/daemon/linux_devices.hpp"

#include <cstdio>
#include <cstring>

namespace vergence {

bool LinuxDevices::open_cameras(const ControllerConfig& config) {
  int side = 0;
  const v4l2::VideoError error = cameras_.configure(video_, config.cameras, side);
  if (v4l2::is_ok(error)) return true;
  std::array<char, 256> text{};
  (void)v4l2::write_message(error, text);
  (void)std::snprintf(message_.data(), message_.size(), "%s camera: %s", side == 0 ? "left" : "right",
                      text.data());
  return false;
}

bool LinuxDevices::open_bus(const CanConfig& config, int bus) {
  std::array<canopen::CanFilter, canopen::kMaxFilters> filters{};
  const std::size_t count = canopen::receive_filters(config.arm, bus, filters);
  canopen::SocketCan& its = buses_[static_cast<std::size_t>(bus)];
  const char* const interface = config.interface_of(bus);
  const canopen::SocketStep step = its.open(interface, std::span(filters).first(count));
  if (step == canopen::SocketStep::kOk) return true;
  (void)std::snprintf(message_.data(), message_.size(),
                      "CAN interface %s: %s: %s (ip link show %s; docs/canopen.md says how it is set up)",
                      interface, canopen::describe(step), std::strerror(its.last_errno()), interface);
  return false;
}

bool LinuxDevices::open_arm(const ControllerConfig& config) {
  for (int bus = 0; bus < canopen::bus_count(config.can.arm); ++bus) {
    if (!open_bus(config.can, bus)) return false;
  }
  const canopen::ConfigResult result = arm_.init(config.can.arm, clock_.now_ns());
  if (result.finding != canopen::ConfigFinding::kNone) {
    (void)std::snprintf(message_.data(), message_.size(), "can.axis %d: %s", result.axis + 1,
                        canopen::describe(result.finding));
    return false;
  }
  has_arm_ = true;
  return true;
}

bool LinuxDevices::open_eyes(const ControllerConfig& config) {
#ifdef VERGENCE_WITH_GPIOD
  const step::LinesError error = lines_.open(config.lines);
  if (error.kind != step::LinesErrorKind::kNone) {
    (void)std::snprintf(message_.data(), message_.size(), "GPIO %s: %s%s%s", error.what.data(),
                        step::describe(error.kind), error.os_error != 0 ? ": " : "",
                        error.os_error != 0 ? std::strerror(error.os_error) : "");
    return false;
  }
#else
  (void)std::snprintf(message_.data(), message_.size(),
                      "eyes.present: this vergenced was built without libgpiod and cannot turn eyes");
  return false;
#endif
  bool lines_work = false;
  const step::MotorError motor = eyes_.configure(config.motors, lines_work);
  if (motor.error != step::TimingError::kNone) {
    (void)std::snprintf(message_.data(), message_.size(), "eyes, motor %d: %s", motor.motor + 1,
                        step::describe(motor.error));
    return false;
  }
  if (!lines_work) (void)std::snprintf(message_.data(), message_.size(), "GPIO: the lines cannot be set");
  return lines_work;
}

bool LinuxDevices::open(const ControllerConfig& config) {
  const bool opened = open_cameras(config) && (!config.robot.has_arm || open_arm(config)) &&
                      (!config.robot.has_eyes || open_eyes(config));
  if (!opened) close();
  return opened;
}

void LinuxDevices::close() {
#ifdef VERGENCE_WITH_GPIOD
  lines_.close();
#endif
  has_arm_ = false;
  for (canopen::SocketCan& bus : buses_) bus.close();
}

}  // namespace vergence
