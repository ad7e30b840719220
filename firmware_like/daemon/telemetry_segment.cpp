#include "firmware_like/daemon/telemetry_segment.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

namespace vergence {
namespace {

using Words = std::array<std::uint64_t, TelemetryMemory::kWords>;

}  // namespace

void put_record(TelemetryMemory& memory, const TelemetryRecord& record) {
  Words words{};
  std::memcpy(words.data(), &record, sizeof record);
  const std::uint64_t before = memory.sequence.load(std::memory_order_relaxed);
  memory.sequence.store(before + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  for (std::size_t i = 0; i < words.size(); ++i) memory.words[i].store(words[i], std::memory_order_relaxed);
  memory.sequence.store(before + 2, std::memory_order_release);
}

bool get_record(const TelemetryMemory& memory, TelemetryRecord& record, int attempts) {
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const std::uint64_t before = memory.sequence.load(std::memory_order_acquire);
    if ((before & 1U) != 0) continue;
    Words words{};
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = memory.words[i].load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (memory.sequence.load(std::memory_order_relaxed) != before) continue;
    std::memcpy(static_cast<void*>(&record), words.data(), sizeof record);
    return true;
  }
  return false;
}

const char* describe(SegmentStatus status) {
  switch (status) {
    case SegmentStatus::kOk: return "no error";
    case SegmentStatus::kBadName: return "its name must be a slash and up to 60 letters";
    case SegmentStatus::kCannotOpen: return "it cannot be opened: does vergenced run, and may you read it?";
    case SegmentStatus::kCannotSize: return "there is no room for it in /dev/shm";
    case SegmentStatus::kCannotMap: return "it cannot be mapped into memory";
    case SegmentStatus::kNotTelemetry: return "it is not the controller's";
    case SegmentStatus::kOtherVersion: return "it is of another version than this program";
  }
  return "unknown error";
}

SegmentStatus TelemetryWriter::open(const char* name) {
  close();
  const std::size_t length = std::strlen(name);
  if (length < 2 || length >= name_.size() || name[0] != '/') return SegmentStatus::kBadName;
  // A new one each time: readers of an old one keep that, and see that it stands still.
  (void)::shm_unlink(name);
  const int file = ::shm_open(name, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0644);
  errno_ = errno;
  if (file < 0) return SegmentStatus::kCannotOpen;
  std::copy_n(name, length + 1, name_.begin());
  const auto finish = [&](SegmentStatus status) {
    errno_ = errno;
    (void)::close(file);
    if (status != SegmentStatus::kOk) close();
    return status;
  };
  if (::fchmod(file, 0644) != 0 || ::posix_fallocate(file, 0, sizeof(TelemetryMemory)) != 0) {
    return finish(SegmentStatus::kCannotSize);
  }
  void* const place =
      ::mmap(nullptr, sizeof(TelemetryMemory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
  if (place == MAP_FAILED) return finish(SegmentStatus::kCannotMap);
  memory_ = new (place) TelemetryMemory;
  memory_->writer_pid = ::getpid();
  return finish(SegmentStatus::kOk);
}

void TelemetryWriter::close() {
  if (memory_ != nullptr) (void)::munmap(memory_, sizeof(TelemetryMemory));
  memory_ = nullptr;
  if (name_[0] != '\0') (void)::shm_unlink(name_.data());
  name_ = {};
}

SegmentStatus TelemetryReader::open(const char* name) {
  close();
  const int file = ::shm_open(name, O_RDONLY | O_CLOEXEC, 0);
  errno_ = errno;
  if (file < 0) return SegmentStatus::kCannotOpen;
  struct stat about {};
  const bool large_enough =
      ::fstat(file, &about) == 0 && about.st_size >= static_cast<off_t>(sizeof(TelemetryMemory));
  void* const place =
      large_enough ? ::mmap(nullptr, sizeof(TelemetryMemory), PROT_READ, MAP_SHARED, file, 0) : MAP_FAILED;
  errno_ = errno;
  (void)::close(file);
  if (!large_enough) return SegmentStatus::kOtherVersion;
  if (place == MAP_FAILED) return SegmentStatus::kCannotMap;
  memory_ = static_cast<const TelemetryMemory*>(place);
  const TelemetryMemory ours;
  SegmentStatus status = SegmentStatus::kOk;
  if (memory_->magic != ours.magic) status = SegmentStatus::kNotTelemetry;
  if (memory_->version != ours.version || memory_->record_bytes != ours.record_bytes) {
    status = SegmentStatus::kOtherVersion;
  }
  if (status != SegmentStatus::kOk) close();
  return status;
}

bool TelemetryReader::read(TelemetryRecord& record) const {
  if (memory_ == nullptr || memory_->sequence.load(std::memory_order_acquire) == 0) return false;
  return get_record(*memory_, record);
}

void TelemetryReader::close() {
  if (memory_ != nullptr) {
    (void)::munmap(const_cast<TelemetryMemory*>(memory_), sizeof(TelemetryMemory));
  }
  memory_ = nullptr;
}

}  // namespace vergence
