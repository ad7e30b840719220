// Locked memory, with and without the right to it, in children: the lock is the whole process's.
#include "hal/rt/memory_lock.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/in_child.hpp"

namespace vergence::rt {
namespace {

using testing::drop_rights;
using testing::in_child;
using testing::kSanitized;

long locked_kB() {
  std::ifstream status("/proc/self/status");
  std::string word;
  long kB = -1;
  while (status >> word) {
    if (word == "VmLck:") status >> kB;
  }
  return kB;
}

MemoryLockError lock_with_limit(rlim_t bytes) {
  return static_cast<MemoryLockError>(in_child([bytes] {
    const rlimit limit{bytes, bytes};
    if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0 || !drop_rights()) return 100;
    const MemoryLock lock = lock_memory();
    return lock.error == memory_lock_error(lock.error_number) ? static_cast<int>(lock.error) : 101;
  }));
}

TEST(MemoryLock, SaysWhichRightIsMissing) {
  if (kSanitized) GTEST_SKIP() << "sanitizers lock nothing";
  EXPECT_EQ(lock_with_limit(0), MemoryLockError::kNotPermitted);
  EXPECT_EQ(lock_with_limit(64 * 1024), MemoryLockError::kOverLimit);
}

TEST(MemoryLock, LocksWhereItMay) {
  if (kSanitized) GTEST_SKIP() << "sanitizers lock nothing";
  constexpr int kNotGranted = 50;
  const int status = in_child([] {
    const MemoryLock lock = lock_memory();
    if (lock.error == MemoryLockError::kNotPermitted || lock.error == MemoryLockError::kOverLimit) {
      return kNotGranted;
    }
    if (lock.error != MemoryLockError::kNone) return 1;
    if (!lock.heap_is_kept) return 2;
    const long whole_kB = locked_kB();
    if (whole_kB * 1024 < static_cast<long>(kPrefaultedStack_bytes)) return 3;
    unlock_memory();
    return locked_kB() == 0 ? 0 : 4;
  });
  if (status == kNotGranted) GTEST_SKIP() << describe(MemoryLockError::kOverLimit);
  EXPECT_EQ(status, 0);
}

TEST(MemoryLock, NamesErrors) {
  EXPECT_EQ(memory_lock_error(0), MemoryLockError::kNone);
  EXPECT_EQ(memory_lock_error(EPERM), MemoryLockError::kNotPermitted);
  EXPECT_EQ(memory_lock_error(ENOMEM), MemoryLockError::kOverLimit);
  EXPECT_EQ(memory_lock_error(EAGAIN), MemoryLockError::kFailed);
  for (const MemoryLockError error : {MemoryLockError::kNotPermitted, MemoryLockError::kOverLimit}) {
    EXPECT_NE(std::strstr(describe(error), "LimitMEMLOCK"), nullptr);
  }
}

class CpuLatencyTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    // Open to a process that gives up its rights.
    std::filesystem::permissions(folder_, std::filesystem::perms(0755));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("vergence-latency-" + std::to_string(getpid()));
  std::string device_ = folder_ / "cpu_dma_latency";
};

TEST_F(CpuLatencyTest, HoldsTheDeviceOpenAtZero) {
  std::ofstream(device_) << "before";
  CpuLatencyRequest request;
  ASSERT_EQ(request.hold(device_.c_str()), CpuLatencyError::kNone);
  EXPECT_TRUE(request.is_held());
  std::ifstream in(device_);
  const std::string written((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(written, std::string(4, '\0') + "re");
  request.release();
  EXPECT_FALSE(request.is_held());
}

TEST_F(CpuLatencyTest, SaysWhyItCouldNot) {
  CpuLatencyRequest request;
  EXPECT_EQ(request.hold(device_.c_str()), CpuLatencyError::kNoDevice);
  EXPECT_EQ(request.last_errno(), ENOENT);
  EXPECT_EQ(request.hold(folder_.c_str()), CpuLatencyError::kFailed);
  EXPECT_EQ(request.hold("/dev/full"), CpuLatencyError::kFailed);
  EXPECT_EQ(request.last_errno(), ENOSPC);
  EXPECT_FALSE(request.is_held());

  std::ofstream(device_) << "x";
  std::filesystem::permissions(device_, std::filesystem::perms::none);
  const int status = in_child([this] {
    if (!drop_rights()) return 100;
    CpuLatencyRequest refused;
    const CpuLatencyError error = refused.hold(device_.c_str());
    return refused.is_held() ? 101 : static_cast<int>(error);
  });
  EXPECT_EQ(status, static_cast<int>(CpuLatencyError::kNotPermitted));
}

}  // namespace
}  // namespace vergence::rt
