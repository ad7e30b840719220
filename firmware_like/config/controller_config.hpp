// Everything `vergenced` is told before it starts, in one value of fixed size: robot and control, target,
// devices, and how it is to run. Made from TOML by `vergence config build`; defaults are those of the
// members.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "algo/target_model.hpp"
#include "algo/tracker.hpp"
#include "firmware_like/robot_config.hpp"
#include "firmware_like/task_table.hpp"
#include "hal/canopen/arm_config.hpp"
#include "hal/gpio_step/lines_config.hpp"
#include "hal/gpio_step/step_motors.hpp"
#include "hal/v4l2/v4l2_config.hpp"

namespace vergence {

inline constexpr std::size_t kMaxPath = 108;  // of a Unix-domain socket's address
using PathText = std::array<char, kMaxPath>;
using InterfaceText = std::array<char, 16>;  // a network interface's name

enum class SchedulingPolicy : std::uint8_t {
  kFifo,
  kDeadline,
};

[[nodiscard]] constexpr std::array<int, kTaskCount> default_cores() {
  std::array<int, kTaskCount> cores{};
  for (std::size_t i = 0; i < kTaskCount; ++i) cores[i] = kTasks[i].core;
  return cores;
}

struct RuntimeConfig {
  SchedulingPolicy policy = SchedulingPolicy::kFifo;
  std::array<int, kTaskCount> core = default_cores();
  PathText command_socket{"/run/vergence/command"};
  PathText telemetry{"/vergence"};  // of shm_open()
  PathText black_box{"/var/lib/vergence/black_box"};
};

struct CanConfig {
  InterfaceText interface { "can0" };
  InterfaceText interface_2{};  // empty: there is one bus
  std::int64_t bitrate_bit_per_s = 1'000'000;
  canopen::CanopenArmConfig arm;

  [[nodiscard]] const char* interface_of(int bus) const {
    return bus == 0 ? interface.data() : interface_2.data();
  }
};

struct ControllerConfig {
  RobotConfig robot;
  TargetKind target = TargetKind::kPhoto;
  MarkerModel marker;  // of the two, the one that target says
  PhotoModel photo;
  v4l2::StereoVideoConfig cameras;
  CanConfig can;
  step::LinesConfig lines;
  step::StepMotorsConfig motors;
  RuntimeConfig runtime;
};

}  // namespace vergence
