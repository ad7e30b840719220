// `vergenced`: reads the configuration, judges the machine, opens the devices, starts the tasks, and from
// then on only watches: commands, black box, watchdog, and the signals that end it. Everything it needs is
// static.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "firmware_like/config/config_image.hpp"
#include "firmware_like/daemon/command_socket.hpp"
#include "firmware_like/daemon/executive.hpp"
#include "firmware_like/daemon/linux_devices.hpp"
#include "firmware_like/daemon/options.hpp"
#include "hal/rt/machine_check.hpp"
#include "hal/rt/memory_lock.hpp"
#include "hal/rt/service_manager.hpp"

namespace vergence {
namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr int kServe_ms = 20;
constexpr std::int64_t kStopPatience_ns = 3'000'000'000;
constexpr std::int64_t kRetryBox_ns = 60'000'000'000;

std::atomic<bool> ending{false};

// One of each, placed statically: nothing is asked of the heap.
ControllerConfig config;
std::array<std::byte, kMaxImageBytes> image;
LinuxDevices devices;
Executive<LinuxDevices> executive{devices};
TelemetryWriter telemetry;
CommandSocket commands{executive.operators()};
BlackBoxFile box_file;
rt::ServiceManager service;
rt::CpuLatencyRequest latency;
rt::MonotonicClock wall;

void say(const char* what, const char* text, const char* more = "") {
  std::fprintf(stderr, "vergenced: %s: %s%s%s\n", what, text, more[0] != '\0' ? ": " : "", more);
}

void on_signal(int) {
  ending.store(true);
}

void take_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  (void)sigaction(SIGTERM, &action, nullptr);
  (void)sigaction(SIGINT, &action, nullptr);
  action.sa_handler = SIG_IGN;
  (void)sigaction(SIGPIPE, &action, nullptr);
}

int read_config(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    say(path, std::strerror(errno), "`vergence config build` makes a configuration image");
    return kBadInput;
  }
  std::size_t size = 0;
  ssize_t got = 1;
  while (size < image.size() && got > 0) {
    got = ::read(file, image.data() + size, image.size() - size);
    if (got > 0) size += static_cast<std::size_t>(got);
  }
  (void)::close(file);
  const ImageResult result = read_image(std::span(image).first(size), config);
  if (result.status == ImageStatus::kOk) return kDone;
  std::fprintf(stderr, "vergenced: %s: %s%s%s%s%s %s\n", path, describe(result.status),
               result.section[0] != '\0' ? ": " : "", result.section, result.key[0] != '\0' ? "." : "",
               result.key, result.problem);
  return kBadInput;
}

// False where the machine is unfit.
bool judge_machine() {
  rt::MachineDemand demand;
  demand.priority = 0;
  for (const TaskRow& row : kTasks) demand.priority = std::max(demand.priority, row.priority);
  demand.cores = config.runtime.core;
  const rt::MachineReport report = rt::check_machine(demand, rt::ask_kernel(demand.priority));
  for (const rt::Finding& finding : report.findings) {
    if (finding.verdict == rt::Verdict::kPass) continue;
    std::fprintf(stderr, "vergenced: machine: %s: %s: %s (%s)\n", rt::to_string(finding.verdict),
                 rt::to_string(finding.probe), finding.detail.data(), finding.remedy);
  }
  return report.worst() != rt::Verdict::kFail;
}

void open_telemetry() {
  const SegmentStatus status = telemetry.open(config.runtime.telemetry.data());
  if (status != SegmentStatus::kOk) {
    say(config.runtime.telemetry.data(), describe(status), "nobody can watch");
    return;
  }
  executive.publish_to(telemetry);
}

// Without one the controller works, but nothing is kept of a fault.
bool prepare_box() {
  const BoxFileStatus status = box_file.prepare(config.runtime.black_box.data());
  if (status != BoxFileStatus::kOk) {
    say(config.runtime.black_box.data(), describe(status), std::strerror(box_file.last_errno()));
  }
  return status == BoxFileStatus::kOk;
}

bool lock(rt::RealtimePolicy policy) {
  const rt::MemoryLock memory = rt::lock_memory();
  if (memory.error != rt::MemoryLockError::kNone) say("memory", rt::describe(memory.error));
  if (const rt::CpuLatencyError error = latency.hold(); error != rt::CpuLatencyError::kNone) {
    say("/dev/cpu_dma_latency", rt::describe(error));
  }
  return memory.error == rt::MemoryLockError::kNone || policy == rt::RealtimePolicy::kIgnore;
}

// Everything up to the running tasks.
int start(const DaemonOptions& options) {
  if (const int status = read_config(options.config); status != kDone) return status;
  const bool fit = judge_machine();
  if (!fit && options.realtime == rt::RealtimePolicy::kEnforce) {
    say("machine", "it cannot keep time", "mend what failed, or run with --realtime=ignore");
    return kFailed;
  }
  if (options.checks_only) return kDone;
  if (const rt::ServiceError error = service.open(); error != rt::ServiceError::kNone) {
    say("systemd", rt::describe(error));
  }
  if (!devices.open(config)) {
    say("devices", devices.message());
    return kFailed;
  }
  open_telemetry();
  (void)prepare_box();
  if (const SocketStatus status = commands.open(config.runtime.command_socket.data());
      status != SocketStatus::kOk) {
    say(config.runtime.command_socket.data(), describe(status), std::strerror(commands.last_errno()));
    return kFailed;
  }
  if (!lock(options.realtime)) return kFailed;
  const StartResult result = executive.start(config, options.realtime);
  if (result.status != Status::kOk) {
    say("controller", describe(result.status));
    return kBadInput;
  }
  if (result.thread_error != rt::RtThreadError::kNone) {
    say(task(result.task).name, rt::describe(result.thread_error), std::strerror(result.error_number));
    return kFailed;
  }
  return kDone;
}

void save_box() {
  if (box_file.is_prepared()) {
    const BoxFileStatus status = box_file.save(executive.black_box());
    if (status == BoxFileStatus::kOk) {
      say("black box", box_file.saved_as());
    } else {
      say("black box", describe(status), std::strerror(box_file.last_errno()));
    }
  }
  executive.black_box().release();
}

class Watch {
 public:
  // Once in a while, from the main thread.
  void step() {
    const std::int64_t now_ns = wall.now_ns();
    TelemetryRecord record;
    const bool known = executive.last_record(record);
    const char* const mode = known ? to_string(static_cast<Mode>(record.mode)) : "init";
    commands.serve(kServe_ms, mode, known ? arm_state(record.arm_state) : "unknown");
    if (known && record.mode_changes != changes_) tell_change(record);
    feed_watchdog(now_ns);
    if (executive.black_box().is_frozen()) save_box();
    if (!box_file.is_prepared() && now_ns >= next_box_ns_) {
      (void)prepare_box();
      next_box_ns_ = now_ns + kRetryBox_ns;
    }
  }

 private:
  static const char* arm_state(std::uint32_t state) {
    switch (static_cast<ArmState>(state)) {
      case ArmState::kDisabled: return "disabled";
      case ArmState::kEnabling: return "enabling";
      case ArmState::kEnabled: return "enabled";
      case ArmState::kQuickStop: return "quick-stop";
      case ArmState::kFault: return "fault";
    }
    return "unknown";
  }

  void tell_change(const TelemetryRecord& record) {
    changes_ = record.mode_changes;
    const char* const mode = to_string(static_cast<Mode>(record.mode));
    const char* const event = to_string(static_cast<Event>(record.last_event));
    std::fprintf(stderr, "vergenced: mode: %s, after %s\n", mode, event);
    if (record.arm_fault != 0) say("arm", canopen::describe(devices.arm_fault()).data());
    (void)service.status(mode);
  }

  void feed_watchdog(std::int64_t now_ns) {
    const std::optional<TaskId> silent = executive.health().silent(now_ns);
    if (!silent) {
      (void)service.keep_alive(now_ns);
      told_silent_ = false;
      return;
    }
    executive.operators().put(OperatorCommand::kStop);
    if (!told_silent_) say(task(*silent).name, "the task is silent", "stopping; the watchdog is not fed");
    told_silent_ = true;
  }

  std::uint64_t changes_ = 0;
  std::int64_t next_box_ns_ = 0;
  bool told_silent_ = false;
};

bool is_still(const TelemetryRecord& record) {
  const auto state = static_cast<ArmState>(record.arm_state);
  const auto mode = static_cast<Mode>(record.mode);
  const bool off = state == ArmState::kDisabled || state == ArmState::kFault;
  return !is_armed(mode) && (off || !config.robot.has_arm);
}

// The arm first: a controlled stop, drives off, then the threads.
void stop(Watch& watch) {
  (void)service.stopping();
  executive.operators().put(OperatorCommand::kStop);
  const std::int64_t until_ns = wall.now_ns() + kStopPatience_ns;
  TelemetryRecord record;
  do {
    watch.step();
  } while (wall.now_ns() < until_ns && executive.last_record(record) && !is_still(record));
  commands.close();
  executive.stop();
  devices.close();
}

void report_tasks() {
  for (std::size_t i = 0; i < kTaskCount; ++i) {
    const TaskSummary& summary = executive.summary(static_cast<TaskId>(i));
    const rt::TaskTiming& timing = summary.timing.timing;
    if (timing.runs() == 0) continue;
    std::fprintf(
        stderr,
        "vergenced: %-7s %llu runs, latency %lld us at worst, %lld us of work, %llu periods lost, %llu "
        "deadlines missed, %lld page faults, stack %zu of %zu KiB, %s\n",
        kTasks[i].name, static_cast<unsigned long long>(timing.runs()),
        static_cast<long long>(timing.worst_latency_ns() / 1000),
        static_cast<long long>(timing.worst_execution_ns() / 1000),
        static_cast<unsigned long long>(timing.lost_periods()),
        static_cast<unsigned long long>(timing.misses()),
        static_cast<long long>(summary.faults.minor + summary.faults.major), summary.stack_used_bytes / 1024,
        summary.stack_bytes / 1024, rt::describe(summary.placement));
  }
}

int run(int argc, char** argv) {
  DaemonOptions options;
  const char* problem = "";
  if (!parse_options(argc, argv, options, problem)) {
    std::fprintf(stderr, "vergenced: error: %s\n%s", problem, kUsage);
    return kBadInput;
  }
  if (options.shows_help || options.shows_version) {
    std::fputs(options.shows_help ? kUsage : VERGENCE_VERSION "\n", stdout);
    return kDone;
  }
  take_signals();
  const int status = start(options);
  if (status != kDone || options.checks_only) {
    commands.close();
    devices.close();
    return status;
  }
  (void)service.ready();
  say("ready", config.runtime.command_socket.data());
  Watch watch;
  while (!ending.load()) watch.step();
  stop(watch);
  report_tasks();
  return kDone;
}

}  // namespace
}  // namespace vergence

int main(int argc, char** argv) {
  return vergence::run(argc, argv);
}
