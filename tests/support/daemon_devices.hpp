// Devices for the executive that need no hardware: drives that follow at once, eyes that count, cameras that
// see nothing but grey. Faults can be ordered from the test's thread.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "algo/pa10.hpp"
#include "hal/arm.hpp"
#include "hal/pan_tilt.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/stereo_camera.hpp"
#include "tests/support/ideal_robot.hpp"

namespace vergence::testing {

class DaemonDevices {
 public:
  DaemonDevices() {
    const SerialArm arm = pa10();
    const Pa10Inverse inverse = inverse_pa10(arm, start_of_hand(), JointVector::Zero());
    const JointVector q = nearest_solution(arm, inverse, JointVector::Zero()).value();
    for (Eigen::Index i = 0; i < kMaxJoints; ++i)
      arm_.feedback.position_rad[static_cast<std::size_t>(i)] = q[i];
  }

  struct Cameras {
    std::vector<std::uint8_t> grey = std::vector<std::uint8_t>(640 * 480 * 3, 128);
    std::atomic<std::uint64_t> captured{0};
    std::uint64_t taken = 0;
    std::atomic<std::int64_t> stamp_ns{0};

    [[nodiscard]] bool take(StereoFrame& frame) {
      const std::uint64_t newest = captured.load();
      if (newest == taken) return false;
      taken = newest;
      frame.sequence = newest;
      frame.stamp_ns = stamp_ns.load();
      frame.left = {grey.data(), 640, 480, 640 * 3, PixelFormat::kRgb24, nullptr, 0};
      frame.right = frame.left;
      return true;
    }
    [[nodiscard]] CameraState state() const { return CameraState::kOk; }
  };
  struct Drives {
    ArmFeedback feedback;
    ArmRequest wanted = ArmRequest::kDisable;
    std::array<double, kMaxJoints> velocity{};
    bool fresh = false;
    [[nodiscard]] bool read(ArmFeedback& out) {
      if (!fresh) return false;
      fresh = false;
      out = feedback;
      return true;
    }
    void command(const std::array<double, kMaxJoints>& rad_per_s) { velocity = rad_per_s; }
    void request(ArmRequest request) { wanted = request; }
  };
  struct Eyes {
    PanTiltFeedback feedback;
    std::atomic<bool> enabled{false};
    rt::MonotonicClock clock;
    [[nodiscard]] bool read(PanTiltFeedback& out) {
      feedback.stamp_ns = clock.now_ns();
      feedback.state = enabled ? PanTiltState::kEnabled : PanTiltState::kDisabled;
      out = feedback;
      return true;
    }
    void command(const std::array<double, kPanTiltMotors>&) {}
    void enable(bool on) { enabled = on; }
  };

  [[nodiscard]] Cameras& cameras() { return cameras_; }
  [[nodiscard]] Drives& arm() { return arm_; }
  [[nodiscard]] Eyes& eyes() { return eyes_; }

  void process_arm(std::int64_t now_ns) {
    if (drives_silent) return;
    if (arm_hangs_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(arm_hangs_ms.exchange(0)));
    ArmFeedback& feedback = arm_.feedback;
    if (feedback.state == ArmState::kEnabled && feedback.stamp_ns != 0) {
      const double dt_s = seconds(now_ns - feedback.stamp_ns);
      for (std::size_t i = 0; i < kMaxJoints; ++i) feedback.position_rad[i] += arm_.velocity[i] * dt_s;
    }
    feedback.state = arm_.wanted == ArmRequest::kEnable ? ArmState::kEnabled : ArmState::kDisabled;
    feedback.stamp_ns = now_ns;
    arm_.fresh = true;
  }
  void start_capture(std::int64_t) { capturing = true; }
  void capture_once(rt::MonotonicClock& clock) {
    rt::sleep_until(clock.now_ns() + 30'000'000);
    cameras_.stamp_ns = clock.now_ns() - 9'000'000;
    ++cameras_.captured;
  }
  void stop_capture() { capturing = false; }
  [[nodiscard]] std::int64_t next_edge_ns() { return clock_.now_ns() + 1'000'000; }
  void run_edges(std::int64_t) { ++edges; }

  std::atomic<bool> drives_silent{false};
  std::atomic<int> arm_hangs_ms{0};
  std::atomic<bool> capturing{false};
  std::atomic<std::uint64_t> edges{0};

 private:
  Cameras cameras_;
  Drives arm_;
  Eyes eyes_;
  rt::MonotonicClock clock_;
};

}  // namespace vergence::testing
