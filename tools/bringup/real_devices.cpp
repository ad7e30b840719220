#include "tools/bringup/real_devices.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "hal/canopen/socket_can.hpp"
#include "hal/rt/monotonic_clock.hpp"
#include "hal/rt/sleep.hpp"
#include "hal/v4l2/linux_video_device.hpp"
#include "tools/bringup/ask_drives.hpp"
#include "tools/bringup/can_link.hpp"
#include "tools/bringup/gpio_checks.hpp"
#include "tools/bringup/rt_checks.hpp"
#include "tools/bringup/watch_cameras.hpp"
#include "tools/io/image_file.hpp"
#include "tools/io/input_error.hpp"
#include "tools/io/writable.hpp"
#ifdef VERGENCE_WITH_GPIOD
#include "firmware_like/task_table.hpp"
#include "hal/gpio_step/libgpiod_lines.hpp"
#include "hal/rt/rt_thread.hpp"
#include "tools/bringup/libgpiod_view.hpp"
#endif

namespace vergence::tools {
namespace {

std::vector<Finding> skipped(const char* group, const char* check, const char* why) {
  Findings found(group);
  found.skip(check, why);
  return found.take();
}

std::vector<Finding> keep_pictures(const CameraObservation& seen, const std::filesystem::path& out) {
  constexpr std::array kNames = {"left.png", "right.png"};
  Findings found("cameras");
  std::string written;
  try {
    make_directory(out);
    for (std::size_t side = 0; side < kNames.size(); ++side) {
      if (seen.eyes[side].picture.data.empty()) continue;
      write_png(out / kNames[side], seen.eyes[side].picture);
      written += (written.empty() ? "" : ", ") + (out / kNames[side]).string();
    }
  } catch (const InputError& error) {
    found.fail("pictures", error.what(), "name another folder with --out");
    return found.take();
  }
  if (written.empty()) {
    found.skip("pictures", "no picture came");
  } else {
    found.pass("pictures", written + ": look at them, for focus, and for left and right");
  }
  return found.take();
}

#ifdef VERGENCE_WITH_GPIOD

// What the thread of the pulses works on.
struct Moving {
  const ControllerConfig* config = nullptr;
  PulsePlan plan;
  step::LibgpiodLines lines;
  LibgpiodEdges edges;
  bool has_loopback = false;
  std::array<PulseObservation, kPanTiltMotors> seen;
};

void make_pulses(void* context) {
  auto& moving = *static_cast<Moving*>(context);
  rt::MonotonicClock clock;
  rt::MonotonicSleeper sleeper;
  PulseTrain train(moving.lines, clock, sleeper, moving.has_loopback ? &moving.edges : nullptr);
  moving.seen = train.run(moving.config->motors, moving.plan);
}

// As urgent as the controller's step task, where that may be had.
std::string run_pulses(Moving& moving) {
  const TaskRow& row = task(TaskId::kSteps);
  const auto stack = std::make_unique<rt::RtStack<std::size_t{256} * 1024>>();
  rt::RtThreadConfig thread;
  thread.name = "pulses";
  thread.stack = stack->span();
  thread.core = moving.config->runtime.core[static_cast<std::size_t>(TaskId::kSteps)];
  thread.scheduling.priority = row.priority;
  rt::RtThread runner;
  rt::RtThreadError error = runner.start(thread, make_pulses, &moving);
  if (error == rt::RtThreadError::kNotPermitted) {
    thread.policy = rt::RealtimePolicy::kIgnore;
    error = runner.start(thread, make_pulses, &moving);
  }
  runner.join();
  return error == rt::RtThreadError::kNone ? "" : rt::describe(error);
}

#endif

}  // namespace

std::vector<Finding> check_cameras(const ControllerConfig& config, double seconds,
                                   const std::filesystem::path& out) {
  v4l2::LinuxVideoSystem system;
  rt::MonotonicClock clock;
  const CameraObservation seen =
      watch_cameras(system, config.cameras, seconds, [&] { return clock.now_ns(); });
  std::vector<Finding> findings = judge(seen, config.cameras);
  if (!out.empty()) {
    for (Finding& finding : keep_pictures(seen, out)) findings.push_back(std::move(finding));
  }
  return findings;
}

namespace {

std::vector<Finding> check_bus(const CanConfig& config, int number, double seconds) {
  const char* const interface = config.interface_of(number);
  const CanLink link = read_link(interface);
  canopen::SocketCan bus;
  const canopen::CanFilter everything{0, 0};
  const canopen::SocketStep step = bus.open(interface, std::span(&everything, 1));
  CanObservation seen;
  if (step != canopen::SocketStep::kOk) {
    seen.open_problem = std::string(canopen::describe(step)) + " (" + std::strerror(bus.last_errno()) + ")";
  } else if (!link.was_told || link.is_up) {
    rt::MonotonicClock clock;
    rt::MonotonicSleeper sleeper;
    ReadOnly read_only(bus, clock, sleeper);
    seen = ask_drives(read_only, config.arm, seconds, number);
  }
  seen.bus = number;
  seen.link = link;
  return judge(seen, config);
}

}  // namespace

std::vector<Finding> check_can(const ControllerConfig& config, double seconds) {
  if (!config.robot.has_arm) return skipped("can", "arm", "the configuration has no arm");
  std::vector<Finding> findings;
  for (int bus = 0; bus < canopen::bus_count(config.can.arm); ++bus) {
    for (Finding& finding : check_bus(config.can, bus, seconds)) findings.push_back(std::move(finding));
  }
  return findings;
}

std::vector<Finding> check_gpio(const ControllerConfig& config) {
  if (!config.robot.has_eyes) return skipped("gpio", "eyes", "the configuration has no eyes that turn");
#ifdef VERGENCE_WITH_GPIOD
  LibgpiodView view;
  return judge(look_at_lines(view, config.lines), config.lines);
#else
  Findings found("gpio");
  found.fail("libgpiod", "this program was built without it", "install libgpiod-dev and build again");
  return found.take();
#endif
}

std::vector<Finding> move_eyes(const ControllerConfig& config, const PulsePlan& plan,
                               const std::string& loopback) {
  if (!config.robot.has_eyes) return not_moved("the configuration has no eyes that turn");
#ifdef VERGENCE_WITH_GPIOD
  const auto moving = std::make_unique<Moving>();
  moving->config = &config;
  moving->plan = plan;
  moving->has_loopback = !loopback.empty();
  std::string problem;
  if (moving->has_loopback) problem = moving->edges.open(loopback);
  if (problem.empty()) {
    const step::LinesError error = moving->lines.open(config.lines);
    if (error.kind != step::LinesErrorKind::kNone) {
      problem = std::string(error.what.data()) + ": " + step::describe(error.kind);
    }
  }
  if (problem.empty()) problem = run_pulses(*moving);
  moving->lines.close();
  for (PulseObservation& seen : moving->seen) {
    if (!problem.empty()) seen.problem = problem;
  }
  return judge(moving->seen, moving->has_loopback, plan.steps);
#else
  (void)plan;
  (void)loopback;
  return not_moved("built without libgpiod");
#endif
}

std::vector<Finding> check_rt(const ControllerConfig& config, double seconds) {
  const rt::MachineReport machine = judge_machine(config.runtime);
  return judge(machine, measure_wake_ups(config.runtime, config.robot.arm_period_ns, seconds));
}

}  // namespace vergence::tools
