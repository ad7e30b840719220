// Devices in memory, with the interfaces of the real ones: what the controller commands is read on the other
// side by whoever plays the world, and what that one sets is what the controller sees. They hold no physics.
#pragma once

#include "hal/arm.hpp"
#include "hal/clock.hpp"
#include "hal/pan_tilt.hpp"
#include "hal/stereo_camera.hpp"

namespace vergence::sim {

// Virtual time: moves when it is told to.
class SimClock {
 public:
  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }

  void set_now_ns(std::int64_t now_ns) { now_ns_ = now_ns; }

 private:
  std::int64_t now_ns_ = 0;
};

class SimStereoCamera {
 public:
  [[nodiscard]] bool take(StereoFrame& frame) {
    if (!fresh_) return false;
    fresh_ = false;
    frame = frame_;
    return true;
  }
  [[nodiscard]] CameraState state() const { return state_; }

  // The world's side. The images must stay until the next take(): while a delivered pair is not taken, the
  // controller may still look at the one before.
  [[nodiscard]] bool is_taken() const { return !fresh_; }
  void deliver(const StereoFrame& frame) {
    frame_ = frame;
    fresh_ = true;
  }
  void set_state(CameraState state) { state_ = state; }

 private:
  StereoFrame frame_;
  bool fresh_ = false;
  CameraState state_ = CameraState::kOk;
};

class SimArm {
 public:
  [[nodiscard]] bool read(ArmFeedback& feedback) {
    if (!fresh_) return false;
    fresh_ = false;
    feedback = feedback_;
    return true;
  }
  void command(const std::array<double, kMaxJoints>& velocity_rad_per_s) {
    velocity_ = velocity_rad_per_s;
    ++commands_;
  }
  void request(ArmRequest request) {
    request_ = request;
    ++requests_;
  }

  // The world's side.
  void deliver(const ArmFeedback& feedback) {
    feedback_ = feedback;
    fresh_ = true;
  }
  [[nodiscard]] const std::array<double, kMaxJoints>& commanded_rad_per_s() const { return velocity_; }
  [[nodiscard]] ArmRequest requested() const { return request_; }
  // How many there were, so that the same one again is not taken for silence.
  [[nodiscard]] std::uint64_t commands() const { return commands_; }
  [[nodiscard]] std::uint64_t requests() const { return requests_; }

 private:
  ArmFeedback feedback_;
  bool fresh_ = false;
  std::array<double, kMaxJoints> velocity_{};
  ArmRequest request_ = ArmRequest::kDisable;
  std::uint64_t commands_ = 0;
  std::uint64_t requests_ = 0;
};

class SimPanTilt {
 public:
  [[nodiscard]] bool read(PanTiltFeedback& feedback) {
    if (!fresh_) return false;
    fresh_ = false;
    feedback = feedback_;
    return true;
  }
  void command(const std::array<double, kPanTiltMotors>& steps_per_s) { rate_ = steps_per_s; }
  void enable(bool on) { enabled_ = on; }

  // The world's side.
  void deliver(const PanTiltFeedback& feedback) {
    feedback_ = feedback;
    fresh_ = true;
  }
  [[nodiscard]] const std::array<double, kPanTiltMotors>& commanded_steps_per_s() const { return rate_; }
  [[nodiscard]] bool is_enabled() const { return enabled_; }

 private:
  PanTiltFeedback feedback_;
  bool fresh_ = false;
  std::array<double, kPanTiltMotors> rate_{};
  bool enabled_ = false;
};

static_assert(Clock<SimClock> && StereoCamera<SimStereoCamera> && Arm<SimArm> && PanTilt<SimPanTilt>);

}  // namespace vergence::sim
