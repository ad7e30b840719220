// The last 30 s and more of everything, kept in memory that was there from the start, and written to a file
// when something went wrong. Who records never waits for the file: another thread writes it, and until it
// has, nothing new is recorded, so that what led to the fault cannot be overwritten.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "algo/image.hpp"
#include "firmware_like/daemon/telemetry_record.hpp"
#include "hal/stereo_camera.hpp"

namespace vergence {

inline constexpr std::size_t kBoxRecords = 30'000;    // 30 s at 1 kHz, a minute at 500 Hz
inline constexpr std::size_t kBoxTailRecords = 1000;  // after the fault: a second, or two
inline constexpr std::size_t kBoxPictures = 60;       // pairs, two a second
inline constexpr std::int64_t kBoxPictureEvery_ns = 480'000'000;
inline constexpr int kBoxPictureWidth = 160;
inline constexpr int kBoxPictureHeight = 120;

// Every n-th pixel of an image, as luma, Cb and Cr planes of what was captured (BT.601, full range).
struct BoxPicture {
  static constexpr std::size_t kPixels = std::size_t{kBoxPictureWidth} * kBoxPictureHeight;
  std::array<std::uint8_t, kPixels> luma{};
  std::array<std::uint8_t, kPixels> cb{};
  std::array<std::uint8_t, kPixels> cr{};
};
struct BoxPair {
  std::uint64_t sequence = 0;
  std::int64_t stamp_ns = 0;
  BoxPicture left;
  BoxPicture right;
};
void take_picture(const ImageView& image, BoxPicture& picture);

// The file: this, then the records, then the pairs, each oldest first.
struct BoxHeader {
  std::array<char, 8> magic{'V', 'E', 'R', 'G', 'B', 'O', 'X', '\n'};
  std::uint32_t version = kTelemetryVersion;
  std::uint32_t record_bytes = sizeof(TelemetryRecord);
  std::uint32_t pair_bytes = sizeof(BoxPair);
  std::uint32_t records = 0;
  std::uint32_t pairs = 0;
  std::uint32_t crc = 0;      // of all of the file, with 0 here
  std::int64_t fault_ns = 0;  // when it was asked for
};
// Of a header, and of what follows it in the file.
[[nodiscard]] std::uint32_t crc_of_box(BoxHeader header, std::span<const std::byte> body);

class BlackBox {
 public:
  // The arm's task, each period; bounded, without system calls.
  void record(const TelemetryRecord& record);
  // The same task: keep what is there, and kBoxTailRecords more. True where this is the first call since the
  // last file.
  bool trigger(std::int64_t now_ns);

  // The vision task, each pair; takes what is due.
  void look(const StereoFrame& frame);

  // Another thread: whether there is something to write, and, after it was written or could not be, to go on.
  [[nodiscard]] bool is_frozen() const { return state_.load(std::memory_order_acquire) == State::kFrozen; }
  void release();
  // Only while it is frozen. i: 0 is the oldest.
  [[nodiscard]] std::size_t records() const;
  [[nodiscard]] const TelemetryRecord& record_at(std::size_t i) const;
  [[nodiscard]] std::size_t pairs() const;
  [[nodiscard]] const BoxPair& pair_at(std::size_t i) const;
  [[nodiscard]] std::int64_t fault_ns() const { return fault_ns_; }

 private:
  enum class State : std::uint32_t {
    kRecording,
    kTail,
    kFrozen,
  };

  std::atomic<State> state_{State::kRecording};
  std::atomic<bool> looking_{false};  // the vision task is at it
  std::uint64_t recorded_ = 0;
  std::size_t tail_ = 0;
  std::int64_t fault_ns_ = 0;
  std::uint64_t looked_ = 0;
  std::int64_t next_picture_ns_ = 0;
  std::array<TelemetryRecord, kBoxRecords> records_{};
  std::array<BoxPair, kBoxPictures> pairs_{};
};

inline constexpr std::size_t kBoxFileBytes =
    sizeof(BoxHeader) + kBoxRecords * sizeof(TelemetryRecord) + kBoxPictures * sizeof(BoxPair);

enum class BoxFileStatus : std::uint8_t {
  kOk,
  kBadPath,
  kCannotOpen,
  kNoRoom,  // on the disk
  kCannotMap,
  kCannotSave,
  kTooMany,  // as many files as are kept are there
};
// What is wrong and what to do, for people.
[[nodiscard]] const char* describe(BoxFileStatus status);

// The file, made in its full size beforehand, so that a full disk is noticed while there is time.
class BlackBoxFile {
 public:
  static constexpr int kMostFiles = 8;  // PATH.1 to PATH.8; older ones are never overwritten

  BlackBoxFile() = default;
  ~BlackBoxFile() { discard(); }
  BlackBoxFile(const BlackBoxFile&) = delete;
  BlackBoxFile& operator=(const BlackBoxFile&) = delete;

  // PATH.pending, until it is written.
  [[nodiscard]] BoxFileStatus prepare(const char* path);
  // Writes a frozen box and gives the file its name; then a new one is to be prepared.
  [[nodiscard]] BoxFileStatus save(const BlackBox& box);
  void discard();
  [[nodiscard]] bool is_prepared() const { return place_ != nullptr; }
  [[nodiscard]] const char* saved_as() const { return saved_.data(); }
  [[nodiscard]] int last_errno() const { return errno_; }

 private:
  static constexpr std::size_t kPathRoom = 128;
  std::array<char, kPathRoom> path_{};
  std::array<char, kPathRoom> pending_{};
  std::array<char, kPathRoom> saved_{};
  std::byte* place_ = nullptr;
  int file_ = -1;
  int errno_ = 0;
};

}  // namespace vergence
