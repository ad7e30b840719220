// rig_probe: uses each of the drivers once against the rig's devices, without a controller: takes pairs of
// pictures, boots the drives and moves a joint, turns a motor by pulses; prints what it found and whether
// that is right.
#include <time.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "firmware_like/config/config_image.hpp"
#include "firmware_like/daemon/linux_devices.hpp"
#include "hal/rt/monotonic_clock.hpp"

namespace vergence::rig {
namespace {

constexpr std::int64_t kPeriod_ns = 2'000'000;
constexpr std::int64_t kEnd_ns = 3'000'000'000;
constexpr std::int64_t kEyesFrom_ns = 500'000'000;
constexpr std::int64_t kEyesTo_ns = 900'000'000;
constexpr double kEyes_steps_per_s = 500;
constexpr std::size_t kMotor = 0;  // tilt
constexpr std::int64_t kJointFrom_ns = 1'500'000'000;
constexpr std::int64_t kJointTo_ns = 2'000'000'000;
constexpr double kJoint_rad_per_s = 0.1;
constexpr std::size_t kJoint = 3;
constexpr std::int64_t kDisable_ns = 2'500'000'000;

void sleep_until(std::int64_t t_ns) {
  const timespec until{t_ns / kNsPerSecond, t_ns % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

// What the probe finds; and what it does at its time.
class Probe {
 public:
  explicit Probe(LinuxDevices& devices) : devices_(devices) {}

  void run() {
    std::atomic<bool> ends{false};
    std::thread capturing([&] {
      devices_.start_capture(clock_.now_ns());
      while (!ends) devices_.capture_once(clock_);
      devices_.stop_capture();
    });
    const std::int64_t start_ns = clock_.now_ns();
    std::int64_t period_ns = start_ns;
    while (period_ns < start_ns + kEnd_ns) {
      const std::int64_t now_ns = clock_.now_ns();
      if (now_ns >= devices_.next_edge_ns()) devices_.run_edges(now_ns);
      if (now_ns >= period_ns) {
        work(period_ns, period_ns - start_ns);
        period_ns += kPeriod_ns;
      }
      sleep_until(std::min(period_ns, devices_.next_edge_ns()));
    }
    devices_.eyes().enable(false);
    devices_.run_edges(clock_.now_ns());
    ends = true;
    capturing.join();
  }

  // True where all is as it should be.
  [[nodiscard]] bool report() const {
    const double pairs_per_s =
        pairs_ > 1 ? static_cast<double>(pairs_ - 1) / seconds(last_ns_ - first_ns_) : 0;
    const double way_rad = arm_.position_rad[kJoint] - from_rad_;
    const double sent_rad = kJoint_rad_per_s * seconds(kJointTo_ns - kJointFrom_ns);
    const auto steps = static_cast<double>(eyes_.steps[kMotor]);
    const double sent_steps = kEyes_steps_per_s * seconds(kEyesTo_ns - kEyesFrom_ns);
    bool good = true;
    const auto row = [&good](const char* what, double value, double low, double high) {
      const bool fits = value >= low && value <= high;
      std::printf("%-44s %12.4f   %10.4f to %10.4f   %s\n", what, value, low, high, fits ? "ok" : "WRONG");
      good = good && fits;
    };
    std::printf("%-44s %12s   %24s\n", "probe", "value", "expected");
    row("pairs of pictures a second", pairs_per_s, 20, 61);
    row("brightness of the last left picture", brightness_, 20, 235);
    row("arm enabled, s after the start", enabled_s_, 0, 1.4);
    row("way of joint 4, rad", way_rad, 0.95 * sent_rad, 1.05 * sent_rad);
    row("arm's faults", static_cast<double>(faults_), 0, 0);
    row("steps of the tilt motor", steps, sent_steps - 8, sent_steps + 8);
    return good;
  }

  // To be compared with what the plant saw.
  [[nodiscard]] double joint_rad() const { return arm_.position_rad[kJoint]; }
  [[nodiscard]] std::int64_t steps() const { return eyes_.steps[kMotor]; }

 private:
  void work(std::int64_t now_ns, std::int64_t since_ns) {
    look();
    move_arm(now_ns, since_ns);
    move_eyes(since_ns);
  }

  void look() {
    StereoFrame frame;
    if (!devices_.cameras().take(frame) || frame.left.data == nullptr) return;
    if (pairs_++ == 0) first_ns_ = frame.stamp_ns;
    last_ns_ = frame.stamp_ns;
    double sum = 0;
    const auto bytes = static_cast<std::size_t>(frame.left.width_px) * 2;
    for (std::size_t i = 0; i < bytes; i += 2) sum += frame.left.data[i];
    brightness_ = sum / frame.left.width_px;
  }

  void move_arm(std::int64_t now_ns, std::int64_t since_ns) {
    devices_.process_arm(now_ns);
    if (devices_.arm().read(arm_)) {
      if (arm_.fault != 0) ++faults_;
      if (arm_.state == ArmState::kEnabled && enabled_s_ < 0) enabled_s_ = seconds(since_ns);
      if (since_ns < kJointFrom_ns) from_rad_ = arm_.position_rad[kJoint];
    }
    devices_.arm().request(since_ns < kDisable_ns ? ArmRequest::kEnable : ArmRequest::kDisable);
    std::array<double, kMaxJoints> velocity{};
    if (since_ns >= kJointFrom_ns && since_ns < kJointTo_ns) velocity[kJoint] = kJoint_rad_per_s;
    devices_.arm().command(velocity);
  }

  void move_eyes(std::int64_t since_ns) {
    (void)devices_.eyes().read(eyes_);
    devices_.eyes().enable(true);
    std::array<double, kPanTiltMotors> rate{};
    if (since_ns >= kEyesFrom_ns && since_ns < kEyesTo_ns) rate[kMotor] = kEyes_steps_per_s;
    devices_.eyes().command(rate);
  }

  LinuxDevices& devices_;
  rt::MonotonicClock clock_;
  std::uint64_t pairs_ = 0;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
  double brightness_ = 0;
  ArmFeedback arm_;
  double enabled_s_ = -1;
  double from_rad_ = 0;
  std::uint64_t faults_ = 0;
  PanTiltFeedback eyes_;
};

int run(const char* file) {
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto config = std::make_unique<ControllerConfig>();
  const ImageResult result = read_image(std::as_bytes(std::span(bytes)), *config);
  if (result.status != ImageStatus::kOk) {
    std::fprintf(stderr, "rig_probe: %s: %s\n", file, describe(result.status));
    return 2;
  }
  const auto devices = std::make_unique<LinuxDevices>();
  if (!devices->open(*config)) {
    std::fprintf(stderr, "rig_probe: %s\n", devices->message());
    return 1;
  }
  Probe probe(*devices);
  probe.run();
  const bool good = probe.report();
  std::printf("joint 4 at %.6f rad, tilt at %lld steps\n", probe.joint_rad(),
              static_cast<long long>(probe.steps()));
  devices->close();
  return good ? 0 : 1;
}

}  // namespace
}  // namespace vergence::rig

// rig_probe --config robot.vcfg
int main(int argc, char** argv) {
  if (argc < 3 || std::strcmp(argv[1], "--config") != 0) {
    std::fprintf(stderr, "rig_probe --config robot.vcfg\n");
    return 2;
  }
  return vergence::rig::run(argv[2]);
}
