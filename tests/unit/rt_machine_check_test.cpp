// Every probe of the machine, passing and not, on made-up machines.
#include "hal/rt/machine_check.hpp"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace vergence::rt {
namespace {

constexpr std::array kCores = {1, 2, 3};

class MachineCheckTest : public ::testing::Test {
 protected:
  void SetUp() override {
    put("/sys/kernel/realtime", "1\n");
    put("/proc/version", "Linux version 6.1.0-rt (builder) #1 SMP PREEMPT_RT\n");
    put("/proc/sys/kernel/sched_rt_runtime_us", "-1\n");
    put("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
    put("/proc/self/status", "Name:\tvergenced\nCapEff:\t0000000000000000\nCapBnd:\t000001ffffffffff\n");
    put("/proc/swaps", "Filename\t\t\tType\t\tSize\t\tUsed\t\tPriority\n");
    put("/sys/devices/system/cpu/isolated", "1-3\n");
    put("/sys/devices/system/cpu/nohz_full", "1-3\n");
    put("/sys/devices/system/cpu/cpuidle/current_driver", "intel_idle\n");
    put("/sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    put("/dev/cpu_dma_latency", "");
    for (int core = 0; core < 4; ++core) {
      put(core_path(core, "cpufreq/scaling_governor"), "performance\n");
      put(core_path(core, "topology/thread_siblings_list"), std::to_string(core) + "\n");
    }
    std::strcpy(answers_.version.data(), "#1 SMP PREEMPT_RT Debian 6.1");
    answers_.priority_limit = 99;
    answers_.memory_limit_bytes = kUnlimited;
    answers_.cores = 4;
    demand_.cores = kCores;
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  static std::string core_path(int core, const std::string& name) {
    return "/sys/devices/system/cpu/cpu" + std::to_string(core) + "/" + name;
  }
  void put(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories((root_ + path).substr(0, (root_ + path).rfind('/')));
    std::ofstream(root_ + path) << text;
  }
  void remove(const std::string& path) const { std::filesystem::remove(root_ + path); }
  [[nodiscard]] MachineReport check() const { return check_machine(demand_, answers_, root_.c_str()); }

  // That probe finds this, with a remedy unless it passes, and all others pass.
  void expect_only(Probe probe, Verdict verdict, const std::string& detail) const {
    const MachineReport report = check();
    for (const Finding& finding : report.findings) {
      const Verdict expected = finding.probe == probe ? verdict : Verdict::kPass;
      EXPECT_EQ(finding.verdict, expected) << to_string(finding.probe) << ": " << finding.detail.data();
      EXPECT_EQ(*finding.remedy == '\0', finding.verdict == Verdict::kPass) << to_string(finding.probe);
      EXPECT_NE(finding.detail[0], '\0') << to_string(finding.probe);
    }
    EXPECT_EQ(report.worst(), verdict);
    EXPECT_NE(std::string(report[probe].detail.data()).find(detail), std::string::npos)
        << report[probe].detail.data();
  }

  std::string root_ =
      std::filesystem::temp_directory_path() / ("vergence-machine-" + std::to_string(getpid()));
  MachineDemand demand_;
  KernelAnswers answers_;
};

TEST_F(MachineCheckTest, AFitMachinePassesEveryProbe) {
  expect_only(Probe::kKernel, Verdict::kPass, "PREEMPT_RT");
  std::set<std::string> names;
  for (const Finding& finding : check().findings) names.insert(to_string(finding.probe));
  EXPECT_EQ(names.size(), kProbes);
}

TEST_F(MachineCheckTest, AnyOfThreeSignsMakesAnRtKernel) {
  const std::string plain = "#1 SMP PREEMPT_DYNAMIC Debian 6.1";
  std::strcpy(answers_.version.data(), plain.c_str());
  expect_only(Probe::kKernel, Verdict::kPass, plain);  // /sys and /proc say so
  remove("/sys/kernel/realtime");
  expect_only(Probe::kKernel, Verdict::kPass, plain);  // /proc/version
  put("/proc/version", "Linux version 6.1 #1 SMP PREEMPT_DYNAMIC\n");
  expect_only(Probe::kKernel, Verdict::kFail, plain);
  put("/sys/kernel/realtime", "0\n");
  expect_only(Probe::kKernel, Verdict::kFail, plain);
  put("/sys/kernel/realtime", "1\n");
  expect_only(Probe::kKernel, Verdict::kPass, plain);
  put("/sys/kernel/realtime", "0\n");
  std::strcpy(answers_.version.data(), "#1 SMP PREEMPT RT 4.19");  // as it was written once
  expect_only(Probe::kKernel, Verdict::kPass, "PREEMPT RT");
}

TEST_F(MachineCheckTest, RefusedSchedulingFails) {
  answers_.fifo_errno = EPERM;
  expect_only(Probe::kFifo, Verdict::kFail, "SCHED_FIFO at 80 refused, errno 1");
}

TEST_F(MachineCheckTest, ALowPriorityLimitFailsUnlessAnotherRightMakesUpForIt) {
  answers_.priority_limit = 79;
  expect_only(Probe::kPriorityLimit, Verdict::kPass, "CAP_SYS_NICE");
  answers_.fifo_errno = EPERM;
  const MachineReport report = check();
  EXPECT_EQ(report[Probe::kPriorityLimit].verdict, Verdict::kFail);
  EXPECT_NE(*report[Probe::kPriorityLimit].remedy, '\0');
}

TEST_F(MachineCheckTest, ALowMemoryLimitFailsUnlessAnotherRightMakesUpForIt) {
  demand_.locked_bytes = 64U << 20;
  answers_.memory_limit_bytes = demand_.locked_bytes;
  expect_only(Probe::kMemoryLimit, Verdict::kPass, "64 MiB, asked for 64 MiB");
  answers_.memory_limit_bytes = 8U << 20;
  expect_only(Probe::kMemoryLimit, Verdict::kFail, "8 MiB, asked for 64 MiB");
  put("/proc/self/status", "Name:\tvergenced\nCapEff:\t0000000000004000\n");
  expect_only(Probe::kMemoryLimit, Verdict::kPass, "CAP_IPC_LOCK");
  put("/proc/self/status", "Name:\tvergenced\nCapEff:\t000001ffffffbfff\n");  // all but that
  expect_only(Probe::kMemoryLimit, Verdict::kFail, "8 MiB");
}

TEST_F(MachineCheckTest, ThrottlingWarns) {
  put("/proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  expect_only(Probe::kThrottling, Verdict::kWarn, "950000 of 1000000 us");
}

TEST_F(MachineCheckTest, FewerCoresWarnAndOneFails) {
  answers_.cores = 3;
  expect_only(Probe::kCores, Verdict::kWarn, "3 online, the tasks want core 3");
  answers_.cores = 1;
  expect_only(Probe::kCores, Verdict::kFail, "1 online");
}

TEST_F(MachineCheckTest, AGovernorOfATasksCoreThatSavesWarns) {
  put(core_path(0, "cpufreq/scaling_governor"), "powersave\n");  // no task's
  expect_only(Probe::kGovernor, Verdict::kPass, "performance");
  put(core_path(1, "cpufreq/scaling_governor"), "powersave\n");
  put(core_path(3, "cpufreq/scaling_governor"), "schedutil\n");
  expect_only(Probe::kGovernor, Verdict::kWarn, "core 1: powersave, core 3: schedutil");
  for (int core = 0; core < 4; ++core) remove(core_path(core, "cpufreq/scaling_governor"));
  expect_only(Probe::kGovernor, Verdict::kPass, "none");
}

TEST_F(MachineCheckTest, CoresThatAreNotIsolatedWarn) {
  for (const std::string& list : {std::string("1,3"), std::string("0-1,3"), std::string("3,1")}) {
    put("/sys/devices/system/cpu/isolated", list + "\n");
    expect_only(Probe::kIsolation, Verdict::kWarn, "not core 2");
  }
  for (const std::string& list :
       {std::string("1-3"), std::string("1,2,3"), std::string("0-7"), std::string("1,2-3,9")}) {
    put("/sys/devices/system/cpu/isolated", list + "\n");
    expect_only(Probe::kIsolation, Verdict::kPass, list);
  }
  for (const std::string& list : {std::string(), std::string("(null)"), std::string("1-")}) {
    put("/sys/devices/system/cpu/isolated", list + "\n");
    expect_only(Probe::kIsolation, Verdict::kWarn, "not core 1, 2, 3");
  }
}

TEST_F(MachineCheckTest, CoresWithTicksWarn) {
  put("/sys/devices/system/cpu/nohz_full", "(null)\n");
  expect_only(Probe::kTicks, Verdict::kWarn, "not core 1, 2, 3");
  remove("/sys/devices/system/cpu/nohz_full");
  expect_only(Probe::kTicks, Verdict::kWarn, "not core 1");
}

TEST_F(MachineCheckTest, SiblingsOfATasksCoreWarn) {
  put(core_path(2, "topology/thread_siblings_list"), "2,6\n");
  expect_only(Probe::kSiblings, Verdict::kWarn, "core 2 is one of 2,6");
  put(core_path(2, "topology/thread_siblings_list"), "2-3\n");
  expect_only(Probe::kSiblings, Verdict::kWarn, "core 2 is one of 2-3");
  remove(core_path(2, "topology/thread_siblings_list"));
  expect_only(Probe::kSiblings, Verdict::kPass, "none");
}

TEST_F(MachineCheckTest, IdleStatesThatCannotBeKeptShallowWarn) {
  remove("/dev/cpu_dma_latency");
  expect_only(Probe::kIdleStates, Verdict::kWarn, "cannot be written");
  put("/sys/devices/system/cpu/cpuidle/current_driver", "none\n");
  expect_only(Probe::kIdleStates, Verdict::kPass, "none");
}

TEST_F(MachineCheckTest, AClockOutsideTheProcessorFails) {
  const std::string path = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  for (const char* name : {"hpet", "acpi_pm", "jiffies"}) {
    put(path, std::string(name) + "\n");
    expect_only(Probe::kClock, Verdict::kFail, name);
  }
  for (const char* name : {"tsc", "arch_sys_counter", "kvm-clock"}) {
    put(path, std::string(name) + "\n");
    expect_only(Probe::kClock, Verdict::kPass, name);
  }
  put(path, "sundial\n");
  expect_only(Probe::kClock, Verdict::kWarn, "sundial");
  remove(path);
  expect_only(Probe::kClock, Verdict::kWarn, "unknown");
}

TEST_F(MachineCheckTest, SwapWarns) {
  put("/proc/swaps", "Filename\tType\tSize\tUsed\tPriority\n/dev/sda2 partition\t999\t0\t-2\n");
  expect_only(Probe::kSwap, Verdict::kWarn, "on /dev/sda2");
  remove("/proc/swaps");
  expect_only(Probe::kSwap, Verdict::kPass, "off");
}

// Whatever files hold, a detail ends within its array.
TEST_F(MachineCheckTest, LongFilesAreCut) {
  put("/sys/devices/system/cpu/isolated", std::string(100'000, '1'));
  put("/proc/version", std::string(100'000, 'x'));
  std::array<int, 300> cores;
  for (int i = 0; i < 300; ++i) cores[static_cast<std::size_t>(i)] = i;
  demand_.cores = cores;
  answers_.cores = 300;
  const MachineReport report = check();
  for (const Finding& finding : report.findings) {
    EXPECT_NE(std::memchr(finding.detail.data(), 0, finding.detail.size()), nullptr)
        << to_string(finding.probe);
  }
  EXPECT_EQ(report[Probe::kIsolation].verdict, Verdict::kWarn);
}

TEST(MachineAnswers, AskingLeavesTheThreadAsItWas) {
  const int policy = sched_getscheduler(0);
  const KernelAnswers answers = ask_kernel(80);
  EXPECT_EQ(sched_getscheduler(0), policy);
  EXPECT_GE(answers.cores, 1);
  EXPECT_NE(answers.version[0], '\0');
  EXPECT_EQ(ask_kernel(1000).fifo_errno, EINVAL);
  // This machine, whatever it is: all probes say something.
  MachineDemand demand;
  demand.cores = kCores;
  for (const Finding& finding : check_machine(demand, answers).findings) {
    EXPECT_NE(finding.detail[0], '\0') << to_string(finding.probe);
  }
}

}  // namespace
}  // namespace vergence::rt
