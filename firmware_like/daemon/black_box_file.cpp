#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "firmware_like/config/crc32.hpp"
#include "firmware_like/daemon/black_box.hpp"

namespace vergence {

const char* describe(BoxFileStatus status) {
  switch (status) {
    case BoxFileStatus::kOk: return "no error";
    case BoxFileStatus::kBadPath: return "its path has 1 to 107 bytes";
    case BoxFileStatus::kCannotOpen:
      return "it cannot be made: is there such a folder, and may we write to it?";
    case BoxFileStatus::kNoRoom: return "the disk has no room for it: faults will leave no record";
    case BoxFileStatus::kCannotMap: return "it cannot be mapped into memory";
    case BoxFileStatus::kCannotSave: return "it cannot be written or named";
    case BoxFileStatus::kTooMany: return "eight are there already: move them elsewhere, none is overwritten";
  }
  return "unknown error";
}

std::uint32_t crc_of_box(BoxHeader header, std::span<const std::byte> body) {
  header.crc = 0;
  return crc32(body, crc32(std::as_bytes(std::span(&header, 1))));
}

BoxFileStatus BlackBoxFile::prepare(const char* path) {
  discard();
  const std::size_t length = std::strlen(path);
  if (length == 0 || length > 107) return BoxFileStatus::kBadPath;
  std::memcpy(path_.data(), path, length + 1);
  (void)std::snprintf(pending_.data(), pending_.size(), "%.107s.pending", path);
  file_ = ::open(pending_.data(), O_CREAT | O_TRUNC | O_RDWR | O_CLOEXEC, 0640);
  errno_ = errno;
  if (file_ < 0) return BoxFileStatus::kCannotOpen;
  if (const int error = ::posix_fallocate(file_, 0, kBoxFileBytes); error != 0) {
    discard();
    errno_ = error;
    return BoxFileStatus::kNoRoom;
  }
  void* const place = ::mmap(nullptr, kBoxFileBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (place == MAP_FAILED) {
    const int error = errno;
    discard();
    errno_ = error;
    return BoxFileStatus::kCannotMap;
  }
  place_ = static_cast<std::byte*>(place);
  return BoxFileStatus::kOk;
}

BoxFileStatus BlackBoxFile::save(const BlackBox& box) {
  if (place_ == nullptr) return BoxFileStatus::kCannotSave;
  int number = 1;
  for (; number <= kMostFiles; ++number) {
    (void)std::snprintf(saved_.data(), saved_.size(), "%.107s.%d", path_.data(), number);
    if (::access(saved_.data(), F_OK) != 0) break;
  }
  if (number > kMostFiles) return BoxFileStatus::kTooMany;

  std::byte* next = place_ + sizeof(BoxHeader);
  const auto put = [&next](const auto& value) {
    std::memcpy(next, &value, sizeof value);
    next += sizeof value;
  };
  BoxHeader header;
  header.records = static_cast<std::uint32_t>(box.records());
  header.pairs = static_cast<std::uint32_t>(box.pairs());
  header.fault_ns = box.fault_ns();
  for (std::size_t i = 0; i < header.records; ++i) put(box.record_at(i));
  for (std::size_t i = 0; i < header.pairs; ++i) put(box.pair_at(i));
  const std::byte* const begin = place_ + sizeof(BoxHeader);
  header.crc = crc_of_box(header, {begin, next});
  std::memcpy(place_, &header, sizeof header);
  const bool saved = ::msync(place_, kBoxFileBytes, MS_SYNC) == 0 &&
                     ::ftruncate(file_, static_cast<off_t>(next - place_)) == 0 &&
                     ::rename(pending_.data(), saved_.data()) == 0;
  errno_ = errno;
  if (!saved) return BoxFileStatus::kCannotSave;
  pending_ = {};  // it has another name now
  discard();
  return BoxFileStatus::kOk;
}

void BlackBoxFile::discard() {
  if (place_ != nullptr) (void)::munmap(place_, kBoxFileBytes);
  place_ = nullptr;
  if (file_ >= 0) (void)::close(file_);
  file_ = -1;
  if (pending_[0] != '\0') (void)::unlink(pending_.data());
  pending_ = {};
}

}  // namespace vergence
