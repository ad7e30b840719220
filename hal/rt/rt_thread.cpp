#include "hal/rt/rt_thread.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

namespace vergence::rt {
namespace {

constexpr std::uint64_t kPaint = 0xA5A5'5A5A'C3C3'3C3C;

// As the kernel has it; the C library has neither the call nor, before 2.41, the struct.
struct KernelSchedAttr {
  std::uint32_t size = sizeof(KernelSchedAttr);
  std::uint32_t policy = SCHED_OTHER;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0;
  std::uint64_t deadline_ns = 0;
  std::uint64_t period_ns = 0;
};
constexpr std::uint32_t kSchedDeadline = 6;

// 0, or what errno says.
int schedule_this_thread(const KernelSchedAttr& attributes) {
  return syscall(SYS_sched_setattr, 0, &attributes, 0U) == 0 ? 0 : errno;
}

[[nodiscard]] bool is_usable(const Scheduling& scheduling) {
  if (scheduling.kind == SchedulingKind::kFifo) return scheduling.priority >= 1 && scheduling.priority <= 99;
  return scheduling.runtime_ns > 0 && scheduling.runtime_ns <= scheduling.deadline_ns &&
         scheduling.deadline_ns <= scheduling.period_ns;
}

KernelSchedAttr attributes_of(const Scheduling& scheduling) {
  KernelSchedAttr attributes;
  if (scheduling.kind == SchedulingKind::kFifo) {
    attributes.policy = SCHED_FIFO;
    attributes.priority = static_cast<std::uint32_t>(scheduling.priority);
  } else {
    attributes.policy = kSchedDeadline;
    attributes.runtime_ns = static_cast<std::uint64_t>(scheduling.runtime_ns);
    attributes.deadline_ns = static_cast<std::uint64_t>(scheduling.deadline_ns);
    attributes.period_ns = static_cast<std::uint64_t>(scheduling.period_ns);
  }
  return attributes;
}

Placement place_this_thread(int core) {
  if (core < 0) return Placement::kNotAsked;
  if (core >= CPU_SETSIZE || core >= sysconf(_SC_NPROCESSORS_CONF)) return Placement::kFewerCores;
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<std::size_t>(core), &cores);
  return sched_setaffinity(0, sizeof cores, &cores) == 0 ? Placement::kPinned : Placement::kRefused;
}

std::size_t page_bytes() {
  const long bytes = sysconf(_SC_PAGESIZE);
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 4096;
}

}  // namespace

const char* describe(RtThreadError error) {
  switch (error) {
    case RtThreadError::kNone: return "no error";
    case RtThreadError::kRunning: return "the thread runs already: join it first";
    case RtThreadError::kStackTooSmall: return "the stack is too small: give it 256 KiB";
    case RtThreadError::kCreate: return "no thread could be had: raise RLIMIT_NPROC or TasksMax=";
    case RtThreadError::kBadScheduling:
      return "a priority is 1 to 99; of a deadline, 0 < runtime <= deadline <= period, at least 1024 ns";
    case RtThreadError::kNotPermitted:
      return "real-time scheduling was refused: grant CAP_SYS_NICE, or LimitRTPRIO= in the unit, or rtprio "
             "in "
             "/etc/security/limits.conf; SCHED_DEADLINE needs CAP_SYS_NICE and all cores. Or choose to run "
             "without";
    case RtThreadError::kNotAdmitted:
      return "SCHED_DEADLINE has no such time left: ask for less runtime, or raise "
             "kernel.sched_rt_runtime_us";
    case RtThreadError::kNotSupported: return "the kernel has no such scheduling: take SCHED_FIFO";
  }
  return "unknown error";
}

const char* describe(Placement placement) {
  switch (placement) {
    case Placement::kNotAsked: return "on any core";
    case Placement::kPinned: return "pinned";
    case Placement::kFewerCores: return "on any core: the machine has fewer";
    case Placement::kRefused: return "on any core: that one is offline, or not in the cpuset";
    case Placement::kByKernel: return "on any core: SCHED_DEADLINE chooses";
  }
  return "unknown placement";
}

PageFaults page_faults_of_this_thread() {
  rusage usage{};
  if (getrusage(RUSAGE_THREAD, &usage) != 0) return {};
  return {usage.ru_minflt, usage.ru_majflt};
}

RtThread::~RtThread() {
  join();
}

// The guard is the first whole page, the stack all whole words above it, painted, which touches its pages.
bool RtThread::lay_out(std::span<std::byte> memory) {
  const std::size_t page = page_bytes();
  const std::size_t misaligned = reinterpret_cast<std::uintptr_t>(memory.data()) % page;
  const std::size_t before = misaligned == 0 ? 0 : page - misaligned;
  const long least = sysconf(_SC_THREAD_STACK_MIN);
  const std::size_t needed = before + page + (least > 0 ? static_cast<std::size_t>(least) : 0);
  if (memory.size() < needed) return false;
  guard_ = memory.subspan(before, page);
  stack_ = memory.subspan(before + page);
  stack_ = stack_.first(stack_.size() / 64 * 64);
  auto* words = reinterpret_cast<std::uint64_t*>(stack_.data());
  std::fill_n(words, stack_.size() / sizeof kPaint, kPaint);
  has_guard_ = mprotect(guard_.data(), guard_.size(), PROT_NONE) == 0;
  return true;
}

void RtThread::unguard() {
  // The memory is the caller's again.
  if (has_guard_) (void)mprotect(guard_.data(), guard_.size(), PROT_READ | PROT_WRITE);
}

RtThreadError RtThread::start(const RtThreadConfig& config, Function function, void* context) {
  if (running_) return RtThreadError::kRunning;
  errno_ = 0;
  outcome_ = RtThreadError::kNone;
  placement_ = Placement::kNotAsked;
  has_guard_ = false;
  stack_ = {};
  config_ = config;
  function_ = function;
  context_ = context;
  if (config.policy == RealtimePolicy::kEnforce && !is_usable(config.scheduling)) {
    return RtThreadError::kBadScheduling;
  }
  if (!lay_out(config.stack)) return RtThreadError::kStackTooSmall;

  pthread_attr_t attributes;
  int error = pthread_attr_init(&attributes);
  if (error == 0) error = pthread_attr_setstack(&attributes, stack_.data(), stack_.size());
  if (error == 0 && sem_init(&settled_, 0, 0) != 0) error = errno;
  if (error == 0) {
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    error = pthread_create(&thread_, &attributes, enter, this);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    errno_ = error;
    unguard();
    return error == EINVAL ? RtThreadError::kStackTooSmall : RtThreadError::kCreate;
  }

  running_ = true;
  while (sem_wait(&settled_) != 0 && errno == EINTR) {
  }
  if (outcome_ != RtThreadError::kNone) join();
  return outcome_;
}

void RtThread::join() {
  if (!running_) return;
  pthread_join(thread_, nullptr);
  sem_destroy(&settled_);
  unguard();
  running_ = false;
}

void* RtThread::enter(void* self) {
  auto& thread = *static_cast<RtThread*>(self);
  thread.outcome_ = thread.place_and_schedule();
  const bool runs = thread.outcome_ == RtThreadError::kNone;
  sem_post(&thread.settled_);
  if (runs) thread.function_(thread.context_);
  return nullptr;
}

RtThreadError RtThread::place_and_schedule() {
  prctl(PR_SET_NAME, config_.name);
  prctl(PR_SET_TIMERSLACK, 1UL);  // of SCHED_OTHER; otherwise its sleeps end 50 us late
  const bool by_deadline =
      config_.policy == RealtimePolicy::kEnforce && config_.scheduling.kind == SchedulingKind::kDeadline;
  // A deadline is promised on all cores or none: the kernel admits no pinned thread.
  placement_ = by_deadline ? Placement::kByKernel : place_this_thread(config_.core);

  if (config_.policy == RealtimePolicy::kIgnore) {
    errno_ = schedule_this_thread({});  // which is always granted, whatever the starter has
    return RtThreadError::kNone;
  }
  errno_ = schedule_this_thread(attributes_of(config_.scheduling));
  switch (errno_) {
    case 0: return RtThreadError::kNone;
    case EBUSY: return RtThreadError::kNotAdmitted;
    case EINVAL: return RtThreadError::kBadScheduling;
    case ENOSYS: return RtThreadError::kNotSupported;
    default: return RtThreadError::kNotPermitted;
  }
}

// Reads below the stack pointer, which sanitizers mistake for a fault.
__attribute__((no_sanitize("address", "thread"))) std::size_t RtThread::stack_high_water_bytes() const {
  const auto* words = reinterpret_cast<const volatile std::uint64_t*>(stack_.data());
  const std::size_t count = stack_.size() / sizeof kPaint;
  std::size_t unused = 0;
  while (unused < count && words[unused] == kPaint) ++unused;
  return (count - unused) * sizeof kPaint;
}

}  // namespace vergence::rt
