// The devices of the real controller: V4L2 cameras, an arm on SocketCAN, step motors on libgpiod lines. What
// the robot does not have stays closed and silent.
#pragma once

#include <array>
#include <cstdint>

#include "firmware_like/config/controller_config.hpp"
#include "hal/canopen/arm_master.hpp"
#include "hal/canopen/socket_can.hpp"
#include "hal/gpio_step/step_motors.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/v4l2/linux_video_device.hpp"
#include "hal/v4l2/v4l2_stereo_camera.hpp"
#ifdef VERGENCE_WITH_GPIOD
#include "hal/gpio_step/libgpiod_lines.hpp"
#endif

namespace vergence {

class LinuxDevices {
 public:
  // Cameras are opened by the capturing thread, again and again until they are there; the bus and the lines
  // now. False with a message for people, what and how to mend it.
  [[nodiscard]] bool open(const ControllerConfig& config);
  // Enable line dropped, lines given back, bus left.
  void close();
  [[nodiscard]] const char* message() const { return message_.data(); }

  [[nodiscard]] v4l2::V4l2StereoCamera& cameras() { return cameras_; }
  void start_capture(std::int64_t now_ns) { cameras_.start(now_ns); }
  void capture_once(rt::MonotonicClock& clock) { cameras_.run_once(clock); }
  void stop_capture() { cameras_.stop(); }

  // Silent where there is no arm.
  class ArmPort {
   public:
    explicit ArmPort(LinuxDevices& devices) : devices_(&devices) {}
    [[nodiscard]] bool read(ArmFeedback& feedback) {
      return devices_->has_arm_ && devices_->arm_.read(feedback);
    }
    void command(const std::array<double, kMaxJoints>& velocity_rad_per_s) {
      if (devices_->has_arm_) devices_->arm_.command(velocity_rad_per_s);
    }
    void request(ArmRequest request) {
      if (devices_->has_arm_) devices_->arm_.request(request);
    }

   private:
    LinuxDevices* devices_;
  };
  [[nodiscard]] ArmPort& arm() { return arm_port_; }
  void process_arm(std::int64_t now_ns) {
    if (has_arm_) arm_.process(now_ns);
  }

#ifdef VERGENCE_WITH_GPIOD
  using Lines = step::LibgpiodLines;
#else
  // Built without libgpiod: there are none.
  struct Lines {
    [[nodiscard]] bool set_outputs(std::uint32_t) { return false; }
    [[nodiscard]] bool set_enable(bool) { return false; }
    [[nodiscard]] bool read_inputs(std::uint32_t&) { return false; }
  };
#endif
  [[nodiscard]] step::StepMotors<Lines, rt::MonotonicClock>& eyes() {
    return eyes_;
  }
  [[nodiscard]] std::int64_t next_edge_ns() const {
    return eyes_.next_deadline_ns();
  }
  void run_edges(std::int64_t now_ns) {
    eyes_.run_edges(now_ns);
  }

  // Of the arm's task's thread: why the arm was stopped.
  [[nodiscard]] const canopen::ArmFaultRecord& arm_fault() const {
    return arm_.master().fault();
  }
  [[nodiscard]] const canopen::CanHealth& bus_health(int bus) const {
    return buses_[static_cast<std::size_t>(bus)].health();
  }

 private:
  [[nodiscard]] bool open_cameras(const ControllerConfig& config);
  [[nodiscard]] bool open_bus(const CanConfig& config, int bus);
  [[nodiscard]] bool open_arm(const ControllerConfig& config);
  [[nodiscard]] bool open_eyes(const ControllerConfig& config);

  v4l2::LinuxVideoSystem video_;
  v4l2::V4l2StereoCamera cameras_;
  std::array<canopen::SocketCan, canopen::kMaxBuses> buses_;
  canopen::CanopenArm<canopen::SocketCan> arm_{buses_[0], buses_[1]};
  ArmPort arm_port_{*this};
  bool has_arm_ = false;
  rt::MonotonicClock clock_;
  Lines lines_;
  step::StepMotors<Lines, rt::MonotonicClock> eyes_{lines_, clock_};
  std::array<char, 512> message_{};
};

}  // namespace vergence
