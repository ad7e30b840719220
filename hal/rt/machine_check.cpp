#include "hal/rt/machine_check.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdarg>
#include <cstdio>
#include <string_view>

namespace vergence::rt {
namespace {

constexpr int kMostCores = 1024;
constexpr int kCapIpcLock = 14;

class CoreSet {
 public:
  void insert(int core) {
    if (core >= 0 && core < kMostCores) words_[word(core)] |= bit(core);
  }
  [[nodiscard]] bool has(int core) const {
    return core >= 0 && core < kMostCores && (words_[word(core)] & bit(core)) != 0;
  }

 private:
  static std::size_t word(int core) { return static_cast<std::size_t>(core) / 64; }
  static std::uint64_t bit(int core) { return std::uint64_t{1} << (core % 64); }
  std::array<std::uint64_t, kMostCores / 64> words_{};
};

// A list as the kernel writes it, "0-3,5". What is none, as "(null)", is empty.
CoreSet parse_cores(std::string_view list) {
  CoreSet cores;
  const char* at = list.data();
  const char* end = at + list.size();
  while (at < end) {
    int first = 0;
    auto [stopped, error] = std::from_chars(at, end, first);
    if (error != std::errc{}) break;
    int last = first;
    if (stopped < end && *stopped == '-') {
      const auto range = std::from_chars(stopped + 1, end, last);
      if (range.ec != std::errc{}) break;
      stopped = range.ptr;
    }
    for (int core = first; core <= std::min(last, kMostCores - 1); ++core) cores.insert(core);
    at = stopped < end ? stopped + 1 : end;
  }
  return cores;
}

// A small file below the root; its trailing white space is left out.
class Text {
 public:
  Text(const char* root, const char* path) {
    std::array<char, 512> whole{};
    const int length = std::snprintf(whole.data(), whole.size(), "%s%s", root, path);
    if (length < 0 || static_cast<std::size_t>(length) >= whole.size()) return;
    const int file = open(whole.data(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return;
    while (size_ < bytes_.size()) {
      const ssize_t got = read(file, bytes_.data() + size_, bytes_.size() - size_);
      if (got <= 0) break;
      size_ += static_cast<std::size_t>(got);
    }
    close(file);
    exists_ = true;
    while (size_ > 0 && (bytes_[size_ - 1] == '\n' || bytes_[size_ - 1] == ' ')) --size_;
  }
  [[nodiscard]] bool exists() const { return exists_; }
  [[nodiscard]] std::string_view view() const { return {bytes_.data(), size_}; }
  [[nodiscard]] bool has(std::string_view part) const { return view().find(part) != std::string_view::npos; }

 private:
  std::array<char, 4096> bytes_;
  std::size_t size_ = 0;
  bool exists_ = false;
};

// Adds to a finding's detail what fits.
[[gnu::format(printf, 2, 3)]] void say(Finding& finding, const char* format, ...) {
  const std::size_t used = std::string_view(finding.detail.data()).size();
  std::va_list arguments;
  va_start(arguments, format);
  (void)std::vsnprintf(finding.detail.data() + used, finding.detail.size() - used, format, arguments);
  va_end(arguments);
}

void judge(Finding& finding, Verdict verdict, const char* remedy) {
  finding.verdict = verdict;
  finding.remedy = remedy;
}

int width(std::string_view text) {
  constexpr std::size_t kMost = 100;
  return static_cast<int>(std::min(text.size(), kMost));
}

// As substr(), which would throw.
std::string_view after(std::string_view text, std::size_t count) {
  text.remove_prefix(std::min(count, text.size()));
  return text;
}

class MachineChecker {
 public:
  MachineChecker(const MachineDemand& demand, const KernelAnswers& answers, const char* root)
      : demand_(demand), answers_(answers), root_(root) {}

  void kernel(Finding& finding) const {
    const Text flag = text("/sys/kernel/realtime");
    const Text version = text("/proc/version");
    const std::string_view own(answers_.version.data());
    const auto says_so = [](std::string_view words) {
      return words.find("PREEMPT_RT") != std::string_view::npos ||
             words.find("PREEMPT RT") != std::string_view::npos;
    };
    const bool is_rt = flag.view() == "1" || says_so(own) || says_so(version.view());
    say(finding, "%.*s", width(own), own.data());
    if (is_rt) {
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kFail,
            "boot a PREEMPT_RT kernel (Debian: apt install linux-image-rt-amd64, or -arm64)");
    }
  }

  void fifo(Finding& finding) const {
    if (answers_.fifo_errno == 0) {
      say(finding, "SCHED_FIFO at %d granted", demand_.priority);
      finding.verdict = Verdict::kPass;
      return;
    }
    say(finding, "SCHED_FIFO at %d refused, errno %d", demand_.priority, answers_.fifo_errno);
    judge(finding, Verdict::kFail,
          "grant CAP_SYS_NICE (setcap cap_sys_nice+ep, docker --cap-add SYS_NICE), or LimitRTPRIO=95 in the "
          "unit");
  }

  void priority_limit(Finding& finding) const {
    const bool enough = answers_.priority_limit >= static_cast<std::uint64_t>(demand_.priority);
    if (answers_.priority_limit == kUnlimited) {
      say(finding, "unlimited");
    } else {
      say(finding, "%llu, asked for %d", static_cast<unsigned long long>(answers_.priority_limit),
          demand_.priority);
    }
    if (!enough && answers_.fifo_errno == 0) say(finding, "; granted by CAP_SYS_NICE");
    if (enough || answers_.fifo_errno == 0) {
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kFail,
            "LimitRTPRIO=95 in the unit, or `@vergence - rtprio 95` in /etc/security/limits.conf");
    }
  }

  void memory_limit(Finding& finding) const {
    constexpr std::uint64_t kMiB = 1024 * 1024;
    const bool enough = answers_.memory_limit_bytes >= demand_.locked_bytes;
    if (answers_.memory_limit_bytes == kUnlimited) {
      say(finding, "unlimited");
    } else {
      say(finding, "%llu MiB, asked for %llu MiB",
          static_cast<unsigned long long>(answers_.memory_limit_bytes / kMiB),
          static_cast<unsigned long long>(demand_.locked_bytes / kMiB));
    }
    const bool privileged = may_lock();
    if (!enough && privileged) say(finding, "; granted by CAP_IPC_LOCK");
    if (enough || privileged) {
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kFail,
            "LimitMEMLOCK=infinity in the unit, or `@vergence - memlock unlimited` in "
            "/etc/security/limits.conf");
    }
  }

  void throttling(Finding& finding) const {
    const Text runtime = text("/proc/sys/kernel/sched_rt_runtime_us");
    const Text period = text("/proc/sys/kernel/sched_rt_period_us");
    if (!runtime.exists() || runtime.view() == "-1") {
      say(finding, "off");
      finding.verdict = Verdict::kPass;
      return;
    }
    say(finding, "%.*s of %.*s us", width(runtime.view()), runtime.view().data(), width(period.view()),
        period.view().data());
    judge(finding, Verdict::kWarn, "sysctl -w kernel.sched_rt_runtime_us=-1, once no task can run away");
  }

  void cores(Finding& finding) const {
    int highest = 0;
    for (const int core : demand_.cores) highest = std::max(highest, core);
    say(finding, "%d online, the tasks want core %d", answers_.cores, highest);
    if (answers_.cores > highest) {
      finding.verdict = Verdict::kPass;
    } else if (answers_.cores > 1) {
      judge(finding, Verdict::kWarn, "take a machine with more cores: tasks without theirs share the others");
    } else {
      judge(finding, Verdict::kFail,
            "take a machine with two cores at least: images must not wait for the bus, nor it for them");
    }
  }

  void governor(Finding& finding) const {
    bool all_fast = true;
    bool any = false;
    each_core([&](int core) {
      const Text governor = core_text(core, "cpufreq/scaling_governor");
      if (!governor.exists()) return;
      any = true;
      if (governor.view() == "performance") return;
      say(finding, "%score %d: %.*s", all_fast ? "" : ", ", core, width(governor.view()),
          governor.view().data());
      all_fast = false;
    });
    if (all_fast) {
      say(finding, any ? "performance" : "none: the frequency is not the kernel's to choose");
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kWarn, "cpupower frequency-set -g performance");
    }
  }

  void isolation(Finding& finding) const {
    within(finding, "/sys/devices/system/cpu/isolated",
           "boot with isolcpus=managed_irq,domain,CORES and irqaffinity=OTHERS");
  }

  void ticks(Finding& finding) const {
    within(finding, "/sys/devices/system/cpu/nohz_full", "boot with nohz_full=CORES rcu_nocbs=CORES");
  }

  void siblings(Finding& finding) const {
    bool alone = true;
    each_core([&](int core) {
      const Text list = core_text(core, "topology/thread_siblings_list");
      const CoreSet shared = parse_cores(list.view());
      bool has_sibling = false;
      for (int other = 0; other < kMostCores; ++other) {
        has_sibling = has_sibling || (other != core && shared.has(other));
      }
      if (!has_sibling) return;
      say(finding, "%score %d is one of %.*s", alone ? "" : ", ", core, width(list.view()),
          list.view().data());
      alone = false;
    });
    if (alone) {
      say(finding, "none");
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kWarn,
            "echo off > /sys/devices/system/cpu/smt/control, or boot with nosmt, or keep the siblings idle");
    }
  }

  void idle_states(Finding& finding) const {
    if (text("/sys/devices/system/cpu/cpuidle/current_driver").view() == "none") {
      say(finding, "the kernel has none to choose");
      finding.verdict = Verdict::kPass;
      return;
    }
    std::array<char, 512> device{};
    const int length = std::snprintf(device.data(), device.size(), "%s/dev/cpu_dma_latency", root_);
    const bool fits = length > 0 && static_cast<std::size_t>(length) < device.size();
    const int file = fits ? open(device.data(), O_WRONLY | O_CLOEXEC) : -1;
    if (file >= 0) {
      close(file);
      say(finding, "/dev/cpu_dma_latency can be held");
      finding.verdict = Verdict::kPass;
      return;
    }
    say(finding, "/dev/cpu_dma_latency cannot be written");
    judge(finding, Verdict::kWarn,
          "give the device to the controller's group by a udev rule, or boot with processor.max_cstate=1 "
          "intel_idle.max_cstate=0");
  }

  void clock(Finding& finding) const {
    const Text source = text("/sys/devices/system/clocksource/clocksource0/current_clocksource");
    const std::string_view name = source.view();
    say(finding, "%.*s", width(name), name.data());
    constexpr std::array<std::string_view, 5> kInProcessor = {
        "tsc", "arch_sys_counter", "kvm-clock", "hyperv_clocksource_tsc_page", "riscv_clocksource"};
    constexpr std::array<std::string_view, 4> kOutside = {"hpet", "acpi_pm", "jiffies", "refined-jiffies"};
    if (std::find(kInProcessor.begin(), kInProcessor.end(), name) != kInProcessor.end()) {
      finding.verdict = Verdict::kPass;
    } else if (std::find(kOutside.begin(), kOutside.end(), name) != kOutside.end()) {
      judge(finding, Verdict::kFail,
            "boot with tsc=reliable, or mend the firmware that made the kernel distrust the processor's "
            "counter");
    } else {
      if (name.empty()) say(finding, "unknown");
      judge(finding, Verdict::kWarn, "measure how long it takes to read: this clock is not known here");
    }
  }

  void swap(Finding& finding) const {
    const Text swaps = text("/proc/swaps");
    const std::size_t header = swaps.view().find('\n');
    if (header == std::string_view::npos) {
      say(finding, "off");
      finding.verdict = Verdict::kPass;
      return;
    }
    const std::string_view rest = after(swaps.view(), header + 1);
    const std::string_view name = rest.substr(0, rest.find_first_of(" \t"));
    say(finding, "on %.*s", width(name), name.data());
    judge(finding, Verdict::kWarn, "swapoff -a, and take it out of /etc/fstab");
  }

  void hypervisor(Finding& finding) const {
    // x86 has a flag for it, which is a word of the first processor's line; other processors tell less.
    const Text type = text("/sys/hypervisor/type");
    if (!text("/proc/cpuinfo").has(" hypervisor") && !type.exists()) {
      say(finding, "none seen");
      finding.verdict = Verdict::kPass;
      return;
    }
    say(finding, "a virtual machine%s%.*s", type.exists() ? ", " : "", width(type.view()),
        type.view().data());
    judge(finding, Verdict::kWarn, "run on the hardware itself: a host may stop all cores at once");
  }

 private:
  [[nodiscard]] Text text(const char* path) const { return {root_, path}; }
  [[nodiscard]] Text core_text(int core, const char* name) const {
    std::array<char, 128> path{};
    (void)std::snprintf(path.data(), path.size(), "/sys/devices/system/cpu/cpu%d/%s", core, name);
    return {root_, path.data()};
  }

  // The tasks' cores that there are, each once.
  template <typename Use>
  void each_core(Use&& use) const {
    CoreSet seen;
    for (const int core : demand_.cores) {
      if (core < 0 || core >= answers_.cores || seen.has(core)) continue;
      seen.insert(core);
      use(core);
    }
  }

  // Passes where the list in the file has all of the tasks' cores. Core 0 is never alone: it keeps the rest.
  void within(Finding& finding, const char* path, const char* remedy) const {
    const Text list = text(path);
    const CoreSet listed = parse_cores(list.view());
    bool all = true;
    each_core([&](int core) {
      if (core == 0 || listed.has(core)) return;
      say(finding, all ? "not core %d" : ", %d", core);
      all = false;
    });
    if (all) {
      const std::string_view cores = list.view().empty() ? "none, and none is asked for" : list.view();
      say(finding, "cores %.*s", width(cores), cores.data());
      finding.verdict = Verdict::kPass;
    } else {
      judge(finding, Verdict::kWarn, remedy);
    }
  }

  [[nodiscard]] bool may_lock() const {
    const Text status = text("/proc/self/status");
    constexpr std::string_view kLabel = "CapEff:\t";
    const std::size_t at = status.view().find(kLabel);
    if (at == std::string_view::npos) return false;
    const std::string_view rest = after(status.view(), at + kLabel.size());
    std::uint64_t capabilities = 0;
    const auto [stopped, error] = std::from_chars(rest.data(), rest.data() + rest.size(), capabilities, 16);
    (void)stopped;
    return error == std::errc{} && (capabilities >> kCapIpcLock & 1) != 0;
  }

  const MachineDemand& demand_;
  const KernelAnswers& answers_;
  const char* root_;
};

struct ProbeRow {
  Probe probe;
  const char* name;
  void (MachineChecker::*look)(Finding&) const;
};

constexpr std::array<ProbeRow, kProbes> kRows = {{
    {Probe::kKernel, "PREEMPT_RT kernel", &MachineChecker::kernel},
    {Probe::kFifo, "real-time scheduling", &MachineChecker::fifo},
    {Probe::kPriorityLimit, "RLIMIT_RTPRIO", &MachineChecker::priority_limit},
    {Probe::kMemoryLimit, "RLIMIT_MEMLOCK", &MachineChecker::memory_limit},
    {Probe::kThrottling, "real-time throttling", &MachineChecker::throttling},
    {Probe::kCores, "number of cores", &MachineChecker::cores},
    {Probe::kGovernor, "frequency governor", &MachineChecker::governor},
    {Probe::kIsolation, "isolated cores", &MachineChecker::isolation},
    {Probe::kTicks, "cores without ticks", &MachineChecker::ticks},
    {Probe::kSiblings, "hardware siblings", &MachineChecker::siblings},
    {Probe::kIdleStates, "idle states", &MachineChecker::idle_states},
    {Probe::kClock, "clock source", &MachineChecker::clock},
    {Probe::kSwap, "swap", &MachineChecker::swap},
    {Probe::kHypervisor, "hypervisor", &MachineChecker::hypervisor},
}};

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (static_cast<std::size_t>(kRows[i].probe) != i) return false;
  }
  return true;
}
static_assert(is_in_order());

std::uint64_t limit_of(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? kUnlimited : limit.rlim_cur;
}

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass: return "pass";
    case Verdict::kWarn: return "warn";
    case Verdict::kFail: return "fail";
  }
  return "?";
}

const char* to_string(Probe probe) {
  return kRows[static_cast<std::size_t>(probe)].name;
}

Verdict MachineReport::worst() const {
  Verdict worst = Verdict::kPass;
  for (const Finding& finding : findings) worst = std::max(worst, finding.verdict);
  return worst;
}

KernelAnswers ask_kernel(int priority) {
  KernelAnswers answers;
  utsname names{};
  if (uname(&names) == 0) {
    const std::string_view version(names.version);
    std::copy_n(version.begin(), std::min(version.size(), answers.version.size() - 1),
                answers.version.begin());
  }
  const int policy = sched_getscheduler(0);
  sched_param before{};
  (void)sched_getparam(0, &before);
  sched_param wanted{};
  wanted.sched_priority = priority;
  if (sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) {
    (void)sched_setscheduler(0, policy, &before);
  } else {
    answers.fifo_errno = errno;
  }
  answers.priority_limit = limit_of(RLIMIT_RTPRIO);
  answers.memory_limit_bytes = limit_of(RLIMIT_MEMLOCK);
  answers.cores = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  return answers;
}

MachineReport check_machine(const MachineDemand& demand, const KernelAnswers& answers, const char* root) {
  const MachineChecker checker(demand, answers, root);
  MachineReport report;
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    report.findings[i].probe = kRows[i].probe;
    (checker.*kRows[i].look)(report.findings[i]);
  }
  return report;
}

}  // namespace vergence::rt
