// The controller's state in shared memory, for any process to read and none to disturb: the writer writes
// whatever readers do, and a reader that was overtaken reads again (a sequence lock).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "firmware_like/daemon/telemetry_record.hpp"

namespace vergence {

// As it lies in memory. Readers check magic, version and size before anything else.
struct TelemetryMemory {
  std::array<char, 8> magic{'V', 'E', 'R', 'G', 'T', 'L', 'M', '\n'};
  std::uint32_t version = kTelemetryVersion;
  std::uint32_t record_bytes = sizeof(TelemetryRecord);
  std::int64_t writer_pid = 0;
  std::atomic<std::uint64_t> sequence{0};  // odd: being written
  // In words, so that copying beside a writer is no data race.
  static constexpr std::size_t kWords = (sizeof(TelemetryRecord) + 7) / 8;
  std::array<std::atomic<std::uint64_t>, kWords> words{};
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
};

void put_record(TelemetryMemory& memory, const TelemetryRecord& record);

// False where a writer was in the way each of `attempts` times; it may be tried again.
[[nodiscard]] bool get_record(const TelemetryMemory& memory, TelemetryRecord& record, int attempts = 100);

enum class SegmentStatus : std::uint8_t {
  kOk,
  kBadName,
  kCannotOpen,  // errno in last_errno()
  kCannotSize,
  kCannotMap,
  kNotTelemetry,
  kOtherVersion,
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(SegmentStatus status);

// The writer's side. All but open() are free of system calls.
class TelemetryWriter {
 public:
  TelemetryWriter() = default;
  ~TelemetryWriter() { close(); }
  TelemetryWriter(const TelemetryWriter&) = delete;
  TelemetryWriter& operator=(const TelemetryWriter&) = delete;

  // A name as shm_open() wants it: "/vergence". Others may read it, none may write.
  [[nodiscard]] SegmentStatus open(const char* name);
  void write(const TelemetryRecord& record) {
    if (memory_ != nullptr) put_record(*memory_, record);
  }
  void close();
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  TelemetryMemory* memory_ = nullptr;
  std::array<char, 64> name_{};
  int errno_ = 0;
};

// A reader in another process.
class TelemetryReader {
 public:
  TelemetryReader() = default;
  ~TelemetryReader() { close(); }
  TelemetryReader(const TelemetryReader&) = delete;
  TelemetryReader& operator=(const TelemetryReader&) = delete;

  [[nodiscard]] SegmentStatus open(const char* name);
  // False where nothing was written yet, or as get_record().
  [[nodiscard]] bool read(TelemetryRecord& record) const;
  [[nodiscard]] std::int64_t writer_pid() const { return memory_ == nullptr ? 0 : memory_->writer_pid; }
  void close();
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  const TelemetryMemory* memory_ = nullptr;
  int errno_ = 0;
};

}  // namespace vergence
